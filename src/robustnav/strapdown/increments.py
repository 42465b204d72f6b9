"""What goes into strapdown integration and what pre-integration leaves of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array, quat_from_rotvec, quat_multiply

WIDTH = 25  # numbers an interval: rotation 4, velocity 3, J 9, H 9

# A constant, a straight line, a parabola through the first samples, two and one sample before them.
_BACKWARDS = (
    np.array([[1.0], [1.0]]),
    np.array([[3.0, -2.0], [2.0, -1.0]]),
    np.array([[6.0, -8.0, 3.0], [3.0, -3.0, 1.0]]),
)


@dataclass(frozen=True)
class ImuSamples:
    """What an inertial unit measured, sample by sample; mean rates times ``dt`` where it reports rates.

    Parameters
    ----------
    angle : (n, 3) body rate against inertial space, integrated over each sample [rad].
    velocity : (n, 3) specific force, integrated over each sample [m/s], body axes.
    dt : sample interval [s].

    Raises
    ------
    InputError : no sample, shapes that differ, a number that is not finite, or an interval that is not positive.
    """

    angle: Array
    velocity: Array
    dt: float

    def __post_init__(self) -> None:
        for name in ("angle", "velocity"):
            value = np.ascontiguousarray(getattr(self, name), float)
            object.__setattr__(self, name, value)
            if value.ndim != 2 or value.shape[1] != 3 or not len(value) or value.shape != self.angle.shape:
                raise InputError(
                    f"inertial samples, {name}", got=f"shape {value.shape}", expected="shape (n, 3), the same for both"
                )
            check_finite(f"inertial samples, {name}", value)
        check_interval("inertial samples", self.dt)

    def __len__(self) -> int:
        return len(self.angle)

    def history(self) -> Array:
        """Return (2, 6) what the unit would have measured in the two samples before the first, the older one first.

        Coning and sculling corrections look two samples back.  A parabola through the first three is continued.
        """
        weights = _BACKWARDS[min(len(self), len(_BACKWARDS)) - 1]
        first = slice(weights.shape[1])
        before: Array = weights @ np.hstack([self.angle[first], self.velocity[first]])
        return before


@dataclass(frozen=True)
class Increments:
    """Rotation and velocity over intervals of equal length, with their derivatives by the sensors' biases.

    Parameters
    ----------
    rows : (n, 25) of each interval, matrices row by row; see the properties.
    dt : length of an interval [s].

    Raises
    ------
    InputError : another shape, a number that is not finite, or an interval that is not positive.
    """

    rows: Array
    dt: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", np.ascontiguousarray(self.rows, float))
        if self.rows.ndim != 2 or self.rows.shape[1] != WIDTH:
            raise InputError("increments", got=f"shape {self.rows.shape}", expected=f"shape (n, {WIDTH})")
        check_finite("increments", self.rows)
        check_interval("increments", self.dt)

    def __len__(self) -> int:
        return len(self.rows)

    @classmethod
    def of(cls, rotation: Array, velocity: Array, jacobians: tuple[Array, Array], dt: float) -> Increments:
        """Return increments of parts: (n, 4), (n, 3), and J and H, each (n, 3, 3); errors as of the class."""
        flat = [matrices.reshape(len(matrices), 9) for matrices in jacobians]
        return cls(np.concatenate([rotation, velocity, *flat], axis=1), dt)

    @property
    def rotation(self) -> Array:
        """Attitude at the interval's end, from body axes there to those at its start (n, 4)."""
        return self.rows[:, :4]

    @property
    def velocity(self) -> Array:
        """Specific force integrated in body axes of the interval's start (n, 3) [m/s]."""
        return self.rows[:, 4:7]

    @property
    def J(self) -> Array:
        """Rotation (left) by gyro bias and velocity by accelerometer bias, both negative (n, 3, 3) [s]."""
        return self.rows[:, 7:16].reshape(-1, 3, 3)

    @property
    def H(self) -> Array:
        """Velocity by gyro bias, negative (n, 3, 3) [m]."""
        return self.rows[:, 16:].reshape(-1, 3, 3)

    def corrected(self, gyro_bias: Array, accel_bias: Array) -> tuple[Array, Array]:
        """Return rotation (n, 4) and velocity (n, 3) [m/s] without biases, to first order.

        ``rotation <- Exp(-J gyro_bias) * rotation``, ``velocity <- velocity - J accel_bias - H gyro_bias``.

        Parameters
        ----------
        gyro_bias : (3,) or (n, 3) [rad/s].
        accel_bias : (3,) or (n, 3) [m/s^2].
        """
        turn = _times(self.J, gyro_bias)
        rotation = quat_multiply(quat_from_rotvec(-turn), self.rotation)
        return rotation, self.velocity - _times(self.J, accel_bias) - _times(self.H, gyro_bias)

    def between(self, first: int, last: int) -> Increments:
        """Return the intervals from number ``first`` up to, not including, ``last``."""
        return Increments(self.rows[first:last], self.dt)


def check_interval(thing: str, dt: float) -> None:
    """Raise ``InputError`` unless ``dt`` is a positive number of seconds."""
    if not 0 < dt < np.inf:
        raise InputError(f"{thing}, dt", got=f"{dt}", expected="a positive number of seconds")


def check_finite(thing: str, rows: Array) -> None:
    """Raise ``InputError`` naming the first row of (n, m) with a number that is not finite."""
    if not np.isfinite(rows).all():
        bad = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
        raise InputError(
            thing,
            place=f"row {bad}",
            got=str(rows[bad]),
            expected="finite numbers",
            do="cut the recording at the gap, and align or navigate each part",
        )


def _times(matrices: Array, vectors: Array) -> Array:
    out: Array = np.einsum("nij,...j->ni" if np.ndim(vectors) == 1 else "nij,nj->ni", matrices, np.asarray(vectors))
    return out
