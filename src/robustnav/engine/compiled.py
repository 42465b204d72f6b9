"""A model's functions in C, on NumPy arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from robustnav.engine import _kernel
from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.model.functions import NOTHING

_PROPAGATE, _TRANSITION, _INJECT, _INJECT_TURNED, _DIFFERENCE, _MEASURE, _RESIDUAL, _JACOBIAN, GAIN = range(9)
_NONE = -1


class CompiledModel:
    """A compiled model with its numbers bound; the same functions as ``NumericModel``.

    Parameters
    ----------
    model : the model whose numbers are used.
    handle : the kernel's object; None takes the built-in one of that name.
    real : ``double``, or ``float`` for built-in models.

    Raises
    ------
    InputError : no compiled form of that name, or sizes that differ from the model's.
    """

    def __init__(self, model: Model, handle: Any = None, real: str = "double") -> None:
        if handle is None:
            try:
                if not model.prebuilt:
                    raise KeyError(model.name)
                handle = _kernel.Model(model.name, real)
            except KeyError:
                raise InputError(
                    f"model {model.name!r} is not built in",
                    do="robustnav.engine.compile_model(model), or backend='numpy'",
                ) from None
        self.model, self.handle, self.real = model, handle, real
        nx, ne, nu, noises, parameters, self.rows = handle.sizes
        mine = (model.state_size, model.error_size, model.input_size, len(model.noises), len(model.parameters))
        if mine != (nx, ne, nu, noises, parameters) or len(self.rows) != len(model.sensors):
            raise InputError(
                f"compiled model {model.name!r}",
                got=f"sizes {(nx, ne, nu, noises, parameters)} and {len(self.rows)} sensors",
                expected=f"{mine} and {len(model.sensors)}",
                do="compile the model again after changing it",
            )
        self.parameters, self.intensities = model.parameter_values, model.intensities

    def propagate(self, x: Array, u: Array, dt: float) -> Array:
        """Return the state (nx,) after ``dt`` seconds of input ``u`` (nu,)."""
        return self._one(_PROPAGATE, (x, u, self.parameters), self.model.state_size, dt=dt)

    def transition(self, x: Array, u: Array, dt: float) -> tuple[Array, Array]:
        """Return F and Q (ne, ne) of the step that starts at ``x``."""
        n = self.model.error_size
        F, Q = np.empty((n, n)), np.empty((n, n))
        inputs = (_array(x), _array(u), self.intensities, self.parameters)
        self.handle.call(_TRANSITION, _NONE, inputs, dt, (F, Q))
        return F, Q

    def inject(self, x: Array, e: Array) -> Array:
        """Return x [+] e."""
        return self._one(_INJECT, (x, e), self.model.state_size)

    def inject_turned(self, x: Array, e: Array) -> Array:
        """Return x [+] e with the body vectors of ``e`` given in navigation axes."""
        return self._one(_INJECT_TURNED, (x, e), self.model.state_size)

    def difference(self, a: Array, b: Array) -> Array:
        """Return e with a = b [+] e."""
        return self._one(_DIFFERENCE, (a, b), self.model.error_size)

    def measure(self, sensor: int, x: Array, known: Array = NOTHING) -> Array:
        """Return what a sensor reads at ``x``; ``known`` travels with the reading."""
        return self._one(_MEASURE, (x, self._reading(sensor, known), self.parameters), self._size(sensor), sensor)

    def residual(self, sensor: int, x: Array, z: Array) -> Array:
        """Return measured minus predicted, as the rows the sensor is fused as."""
        return self._one(_RESIDUAL, (x, z, self.parameters), self.rows[sensor], sensor)

    def jacobian(self, sensor: int, x: Array, known: Array = NOTHING) -> Array:
        """Return the Jacobian (rows, ne) of the predicted rows on the error."""
        n = self.model.error_size
        inputs = (x, self._reading(sensor, known), self.parameters)
        return self._one(_JACOBIAN, inputs, self.rows[sensor] * n, sensor).reshape(-1, n)

    def gain(self, K: Array, r: Array) -> Array:
        """Return K r as the kernel computes it: over the entries that the model's structure allows."""
        return self._one(GAIN, (K.ravel(), r), self.model.error_size)

    def _size(self, sensor: int) -> int:
        return self.model.sensors[sensor].size

    def _reading(self, sensor: int, known: Array) -> Array:
        return np.concatenate([np.zeros(self._size(sensor)), known])

    def _one(self, what: int, inputs: tuple[Array, ...], size: int, sensor: int = _NONE, dt: float = 0.0) -> Array:
        out = np.empty(size)
        self.handle.call(what, sensor, tuple(_array(a) for a in inputs), dt, (out,))
        return out


def _array(a: Array) -> Array:
    return np.ascontiguousarray(a, float)
