"""Which form of a model runs: compiled where it can be, NumPy where it must."""

from __future__ import annotations

from robustnav.engine.compiled import CompiledModel
from robustnav.engine.filters import FilterSetup, KernelFilter
from robustnav.engine.reference import ReferenceFilter
from robustnav.engine.user import NoCompiler, compile_model
from robustnav.errors import InputError
from robustnav.model.blocks import Model
from robustnav.model.functions import ModelFunctions, NumericModel

RunningFilter = KernelFilter | ReferenceFilter
BACKENDS = ("auto", "c", "float", "numpy")


def functions_of(model: Model, backend: str = "auto") -> CompiledModel | ModelFunctions:
    """Return a model's functions.

    Parameters
    ----------
    model : the model.
    backend : ``c`` compiled in double, ``float`` compiled in float (built-in models), ``numpy``; ``auto`` is ``c``
        where the model is built in or a C compiler is installed, else ``numpy``.

    Raises
    ------
    InputError : unknown backend.
    NoCompiler : ``c`` for a user's model without a compiler.
    """
    if backend not in BACKENDS:
        raise InputError("backend", got=repr(backend), expected=", ".join(BACKENDS))
    if backend == "numpy":
        return NumericModel(model)
    if backend == "float":
        return CompiledModel(model, real="float")
    try:
        return compile_model(model)
    except NoCompiler:
        if backend == "c":
            raise
        return NumericModel(model)


def running_filter(model: Model, setup: FilterSetup, backend: str = "auto") -> RunningFilter:
    """Return a filter ready to run; ``backend`` as in ``functions_of``."""
    functions = functions_of(model, backend)
    if isinstance(functions, CompiledModel):
        return KernelFilter(functions, setup)
    return ReferenceFilter(functions, setup)


__all__ = ["BACKENDS", "RunningFilter", "functions_of", "running_filter"]
