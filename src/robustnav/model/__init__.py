"""Models as data: blocks and equations, their Jacobians, their discretisation, their C."""

from robustnav.model.blocks import Equations, Model, Noise, Rotation, Sensor, Symbols, Vector
from robustnav.model.check import ModelCheck, check_model
from robustnav.model.functions import ModelFunctions, NumericModel

__all__ = [
    "Equations",
    "Model",
    "ModelCheck",
    "ModelFunctions",
    "Noise",
    "NumericModel",
    "Rotation",
    "Sensor",
    "Symbols",
    "Vector",
    "check_model",
]
