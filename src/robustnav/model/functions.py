"""The numbers a filter asks of a model, and their readable NumPy form.

``ModelFunctions`` is what every filter in ``filter/`` is written against; ``NumericModel`` evaluates it from the
symbolic model, ``robustnav.engine.CompiledModel`` from the generated C.  Both give the same numbers to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from robustnav.frames import Array, matrix_from_quat, quat_conjugate, quat_multiply, quat_normalize, skew, wrap_angle
from robustnav.model.blocks import Model, Rotation
from robustnav.model.derive import Derivation

NOTHING: Array = np.zeros(0)


class ModelFunctions(Protocol):
    """A model with its numbers bound: x is the state (nx,), e an error (ne,), u an input (nu,)."""

    model: Model
    rows: Sequence[int]  # scalar rows each sensor is fused as

    def propagate(self, x: Array, u: Array, dt: float) -> Array:
        """Return the state after ``dt`` seconds of input ``u``."""

    def transition(self, x: Array, u: Array, dt: float) -> tuple[Array, Array]:
        """Return F and Q (ne, ne) of the step that starts at ``x``."""

    def inject(self, x: Array, e: Array) -> Array:
        """Return x [+] e."""

    def inject_turned(self, x: Array, e: Array) -> Array:
        """Return x [+] e with the body vectors of ``e`` given in navigation axes."""

    def difference(self, a: Array, b: Array) -> Array:
        """Return e with a = b [+] e."""

    def measure(self, sensor: int, x: Array, known: Array = NOTHING) -> Array:
        """Return what a sensor reads at ``x``; ``known`` travels with the reading."""

    def residual(self, sensor: int, x: Array, z: Array) -> Array:
        """Return measured minus predicted of a whole reading ``z`` (width,), as the rows a sensor is fused as."""

    def jacobian(self, sensor: int, x: Array, known: Array = NOTHING) -> Array:
        """Return the Jacobian (rows, ne) of the predicted rows on the error."""


def innovation(model: ModelFunctions, sensor: int, x: Array, z: Array) -> Array:
    """Return measured minus predicted in the sensor's own axes (size,), angles taken into [-pi, pi)."""
    one = model.model.sensors[sensor]
    r = np.asarray(z[: one.size], float) - model.measure(sensor, x, z[one.size :])
    return wrap_angle(r) if one.wraps else r


class NumericModel:
    """A model evaluated in NumPy from its equations: the specification the compiled form is held to.

    Raises
    ------
    MissingExtra : SymPy or symengine is not installed.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        derivation = Derivation(model)
        self._parameters = model.parameter_values
        self._intensities = np.repeat(model.intensities, [n.size for n in model.noises])
        symbols = [derivation.x, derivation.u, derivation.p]
        zero = dict.fromkeys(derivation.w, 0)
        self._step: Evaluator | None = None
        if derivation.steps:
            stepping = [*symbols, [derivation.dt]]
            self._step = evaluator(stepping, [e.subs(zero) for b in model.state for e in derivation.steps[b.name]])
            self._F, self._G = (evaluator(stepping, part) for part in derivation.step_jacobians())
        else:
            self._rate = evaluator(symbols, [e.subs(zero) for b in model.state for e in derivation.rates[b.name]])
            self._constant = derivation.constant
            self._A, self._G = (evaluator(symbols, part) for part in derivation.error_rate())
        seen = [[derivation.x, derivation.known[s.name], derivation.p] for s in model.sensors]
        self._h = [evaluator(v, derivation.h[s.name]) for s, v in zip(model.sensors, seen, strict=True)]
        self._v = [
            evaluator(v, derivation.directions[s.name]) if derivation.in_navigation(s.name) else None
            for s, v in zip(model.sensors, seen, strict=True)
        ]
        H = [derivation.on_error(derivation.h[s.name]) for s in model.sensors]
        self._H = [evaluator(v, one) for v, one in zip(seen, H, strict=True)]
        self._rows = [derivation.rows(s.name) for s in model.sensors]
        self.rows: Sequence[int] = [len(r) for r in self._rows]

    def propagate(self, x: Array, u: Array, dt: float) -> Array:
        """Return the state after ``dt`` seconds: the midpoint rule on the manifold, or the model's own step."""
        if self._step is not None:
            return self._unit(self._step(x, u, self._parameters, [dt]))
        middle = self._move(x, self._rate(x, u, self._parameters), dt / 2)
        return self._move(x, self._rate(middle, u, self._parameters), dt, normalize=True)

    def error_rate(self, x: Array, u: Array) -> tuple[Array, Array]:
        """Return A (ne, ne) and G (ne, nw) of the error's rate e' = A e + G w."""
        return self._A(x, u, self._parameters), self._G(x, u, self._parameters)

    def transition(self, x: Array, u: Array, dt: float) -> tuple[Array, Array]:
        """Return F and Q (ne, ne) of the step that starts at ``x``; docs/models.md, section 1."""
        p = self._parameters
        if self._step is not None:
            G = self._G(x, u, p, [dt])
            return self._F(x, u, p, [dt]), dt * G @ np.diag(self._intensities) @ G.T
        rate = self._rate(x, u, p)
        middle = self._move(x, rate, dt / 2)
        A, G = self.error_rate(middle, u)
        Qc, one = np.diag(self._intensities), np.eye(self.model.error_size)
        rotation = self.model.rotation
        F = one + dt * A @ (one + dt / 2 * self._A(x, u, p)) if rotation is None else one + dt * A
        if rotation is not None and rotation.error == "b":
            rows = self.model.error_slices[rotation.name]
            phi = self._rate(middle, u, p)[self._rate_slice(rotation)] * dt
            F[rows] = (np.eye(3) - skew(phi) / 2) @ A[rows] * dt
            F[rows, rows] = matrix_from_quat(_increment(phi)).T
        if not self._constant:
            return F, dt * G @ Qc @ G.T
        spread, AG = G + dt / 2 * A @ G, A @ G
        return F, dt * spread @ Qc @ spread.T + dt**3 / 12 * AG @ Qc @ AG.T

    def inject(self, x: Array, e: Array) -> Array:
        """Return x [+] e."""
        out = np.array(x, float)
        for block in self.model.state:
            rows, columns = self.model.state_slices[block.name], self.model.error_slices[block.name]
            if isinstance(block, Rotation):
                turn = np.r_[1.0, e[columns] / 2]
                q = quat_multiply(turn, x[rows]) if block.error == "n" else quat_multiply(x[rows], turn)
                out[rows] = quat_normalize(q)
            else:
                out[rows] += e[columns]
        return out

    def inject_turned(self, x: Array, e: Array) -> Array:
        """Return x [+] e with the body vectors of ``e`` given in navigation axes."""
        rotation = self.model.rotation
        if rotation is None or rotation.error != "n":
            return self.inject(x, e)
        e = np.array(e, float)
        C_bn = matrix_from_quat(x[self.model.state_slices[rotation.name]]).T
        for block in self.model.state:
            if block.frame == "b":
                columns = self.model.error_slices[block.name]
                e[columns] = C_bn @ e[columns]
        return self.inject(x, e)

    def difference(self, a: Array, b: Array) -> Array:
        """Return e with a = b [+] e."""
        out = np.zeros(self.model.error_size)
        for block in self.model.state:
            rows, columns = self.model.state_slices[block.name], self.model.error_slices[block.name]
            if isinstance(block, Rotation):
                inverse = quat_conjugate(b[rows])
                d = quat_multiply(a[rows], inverse) if block.error == "n" else quat_multiply(inverse, a[rows])
                out[columns] = 2 * d[1:] / d[0]
            else:
                out[columns] = a[rows] - b[rows]
        return out

    def measure(self, sensor: int, x: Array, known: Array = NOTHING) -> Array:
        """Return what a sensor reads at ``x``; ``known`` travels with the reading."""
        return self._h[sensor](x, known, self._parameters)

    def residual(self, sensor: int, x: Array, z: Array) -> Array:
        """Return measured minus predicted; direction sensors in navigation axes, without rows that see nothing."""
        size = self.model.sensors[sensor].size
        v = self._direction(sensor, x, z[size:])
        if v is None:
            own: Array = innovation(self, sensor, x, z)[self._rows[sensor]]
            return own
        rotation = self.model.rotation
        q_nb = x[self.model.state_slices[rotation.name]] if rotation else x
        rows: Array = (matrix_from_quat(q_nb) @ z[:size] - v)[self._rows[sensor]]
        return rows

    def jacobian(self, sensor: int, x: Array, known: Array = NOTHING) -> Array:
        """Return the Jacobian (rows, ne) of the predicted rows on the error."""
        v = self._direction(sensor, x, known)
        if v is None:
            return self._H[sensor](x, known, self._parameters)[self._rows[sensor]]
        H = np.zeros((3, self.model.error_size))
        if self.model.rotation is not None:
            H[:, self.model.error_slices[self.model.rotation.name]] = skew(v)
        return H[self._rows[sensor]]

    def _direction(self, sensor: int, x: Array, known: Array) -> Array | None:
        evaluate = self._v[sensor]
        return None if evaluate is None else evaluate(x, known, self._parameters)

    def _rate_slice(self, rotation: Rotation) -> slice:
        return self.model.error_slices[rotation.name]  # a body rate has as many numbers as the error

    def _move(self, x: Array, rate: Array, dt: float, *, normalize: bool = False) -> Array:
        out = np.array(x, float)
        for block in self.model.state:
            rows, columns = self.model.state_slices[block.name], self.model.error_slices[block.name]
            if isinstance(block, Rotation):
                out[rows] = quat_multiply(x[rows], _increment(rate[columns] * dt))
            else:
                out[rows] += rate[columns] * dt
        return self._unit(out) if normalize else out

    def _unit(self, x: Array) -> Array:
        """Scale the quaternion by one Newton step of 1/sqrt at one."""
        rotation = self.model.rotation
        if rotation is not None:
            rows = self.model.state_slices[rotation.name]
            x[rows] *= 1.5 - 0.5 * (x[rows] @ x[rows])
        return x


def _increment(phi: Array) -> Array:
    """Return the quaternion of a small turn, to fourth order in the angle."""
    square = float(phi @ phi)
    out: Array = np.r_[1 - square / 8 + square**2 / 384, phi * (0.5 - square / 48)]
    return out


class Evaluator:
    """An array of expressions as a function of arrays, one for each list of symbols."""

    def __init__(self, function: Any, shape: tuple[int, ...]) -> None:
        self._function, self._shape = function, shape

    def __call__(self, *values: ArrayLike) -> Array:
        """Return the array at the values of each list."""
        return np.array(self._function(*values), float).reshape(self._shape)


def evaluator(symbols: list[list[Any]], expressions: Any) -> Evaluator:
    """Compile expressions to NumPy through SymPy, a road of its own beside the C printer."""
    import sympy as sp

    rows = [[sp.sympify(e) for e in row] if isinstance(row, list) else sp.sympify(row) for row in expressions]
    flat = [e for row in rows for e in (row if isinstance(row, list) else [row])]
    shape = (len(rows), len(rows[0])) if rows and isinstance(rows[0], list) else (len(rows),)
    arguments = [[sp.sympify(s) for s in part] for part in symbols]
    return Evaluator(sp.lambdify(arguments, flat, "numpy", cse=True), shape)
