"""The filters at C speed, and the same filters in NumPy."""

from robustnav.engine.compiled import CompiledModel
from robustnav.engine.filters import FilterSetup, KernelFilter, Output, SensorData, SensorSeen
from robustnav.engine.user import NoCompiler, compile_model

__all__ = [
    "CompiledModel",
    "FilterSetup",
    "KernelFilter",
    "NoCompiler",
    "Output",
    "SensorData",
    "SensorSeen",
    "compile_model",
]
