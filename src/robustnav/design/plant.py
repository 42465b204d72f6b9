"""What a continuous observer is designed for: dynamics, noise, outputs and what should be estimated well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.design.matrices import ComplexArray, direction, matrix, modes, right_divide
from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array

_RANK_TOLERANCE = 1e-9  # smallest singular value of a PBH matrix whose rows and columns are of order one
_AXIS_TOLERANCE = 1e-9  # real part counted as zero, relative to the size of A


@dataclass(frozen=True)
class Plant:
    """Linear plant x' = A x + B_w w, y = C_y x + D_w w, z = C_z x with white noise w of unit intensity.

    Noise sizes live in ``B_w`` and ``D_w``: a process noise of intensity q enters with sqrt(q).

    Parameters
    ----------
    A : (n, n) [1/s between like units].
    B_w : (n, q) process-noise input.
    C_y : (m, n) output.
    D_w : (m, q) sensor-noise input; ``D_w D_w'`` must be positive definite.
    C_z : (p, n) what the design is judged on.

    Raises
    ------
    InputError : shapes differ, a number is not finite, an output has no noise of its own.
    EstimatorError : a mode that does not decay is invisible in y, or one on the imaginary axis carries no noise.

    References
    ----------
    Zhou, Doyle, Glover, Robust and Optimal Control (1996), section 3.4 (PBH tests) and 14.5.
    """

    A: Array
    B_w: Array
    C_y: Array
    D_w: Array
    C_z: Array

    def __post_init__(self) -> None:
        n = len(np.atleast_1d(self.A))
        shapes = {"A": (n, n), "B_w": (n, -1), "C_y": (-1, n), "D_w": (-1, -1), "C_z": (-1, n)}
        for name, shape in shapes.items():
            object.__setattr__(self, name, matrix(getattr(self, name), shape, f"plant matrix {name}"))
        wanted = (len(self.C_y), self.B_w.shape[1])
        if self.D_w.shape != wanted:
            raise InputError("plant matrix D_w", got=f"shape {self.D_w.shape}", expected=f"shape {wanted}")
        _check_sensor_noise(self.R)
        _check_detectable(self)
        _check_stabilisable(self)

    @property
    def Q(self) -> Array:
        """Process-noise intensity B_w B_w' (n, n)."""
        return self.B_w @ self.B_w.T

    @property
    def R(self) -> Array:
        """Sensor-noise intensity D_w D_w' (m, m)."""
        return self.D_w @ self.D_w.T

    @property
    def S(self) -> Array:
        """Cross intensity B_w D_w' (n, m); zero when no noise enters both state and output."""
        return self.B_w @ self.D_w.T

    def closed_loop(self, L: Array) -> tuple[Array, Array]:
        """Return (A + L C_y, B_w + L D_w): the error dynamics and noise input of the observer with gain L (n, m)."""
        return self.A + L @ self.C_y, self.B_w + L @ self.D_w


def _check_sensor_noise(R: Array) -> None:
    sd = np.sqrt(np.diag(R))
    silent = np.flatnonzero(sd == 0)
    if silent.size:
        raise InputError(f"output {silent[0]} has no noise", expected="D_w D_w' positive definite")
    lowest = float(np.linalg.eigvalsh(R / np.outer(sd, sd)).min(initial=1.0))
    if lowest < 1e-12:
        raise InputError("sensor noises are linearly dependent", expected="D_w D_w' positive definite")


def _normalised_rows(M: Array) -> Array:
    size = np.linalg.norm(M, axis=1, keepdims=True)
    return M / np.where(size > 0, size, 1.0)


def _hidden_mode(A: Array, C: Array, candidates: ComplexArray) -> tuple[complex, ComplexArray] | None:
    """Return the first of ``candidates`` with an eigenvector of A that C does not see, and that vector (PBH)."""
    size = max(float(np.abs(A).max(initial=0.0)), np.finfo(float).tiny)
    for mode in candidates:
        stack = np.vstack([(A - mode * np.eye(len(A))) / size, _normalised_rows(C)])
        _, singular, right = np.linalg.svd(stack)
        if singular[-1] < _RANK_TOLERANCE:
            return complex(mode), right[-1].conj()
    return None


def _check_detectable(plant: Plant) -> None:
    poles = modes(plant.A)
    slack = _AXIS_TOLERANCE * np.abs(plant.A).max(initial=0.0)
    found = _hidden_mode(plant.A, plant.C_y, poles[poles.real >= -slack])
    if found:
        raise EstimatorError(
            "the plant is not detectable",
            got=f"no output sees the direction {direction(found[1])} (mode {found[0]:.3g} 1/s)",
            expected="every mode that does not decay by itself visible in y",
            do="add a sensor that sees this direction, or take it out of the state",
        )


def _check_stabilisable(plant: Plant) -> None:
    """A mode on the imaginary axis without noise would end with gain zero: no stabilising Riccati solution."""
    weight = right_divide(plant.S, plant.R)
    A = plant.A - weight @ plant.C_y
    noise = plant.B_w - weight @ plant.D_w
    poles = modes(A)
    slack = _AXIS_TOLERANCE * np.abs(A).max(initial=0.0)
    found = _hidden_mode(A.T, noise.T, poles[np.abs(poles.real) <= slack])
    if found:
        raise EstimatorError(
            "the plant is not stabilisable from its noise",
            got=f"no process noise drives the direction {direction(found[1])} (mode {found[0]:.3g} 1/s)",
            expected="process noise on every mode on the imaginary axis",
            do="give this state a process noise, however small, or take it out",
        )
