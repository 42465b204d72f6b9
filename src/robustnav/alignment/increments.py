"""Inertial samples summed over one filter period, and the rows an alignment reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array

READING = 27  # rotation 4, velocity 3, d velocity / d accel bias 9, d velocity / d gyro bias 9, reference 2


@dataclass(frozen=True)
class Increments:
    """Pre-integrated inertial readings, one row a period, in the body axes at the start of the period.

    Parameters
    ----------
    rotation : (n, 4) ``q`` from the body at the end of a period to the body at its start, inertially fixed.
    velocity : (n, 3) sum of the specific force [m/s].
    per_accel_bias : (n, 3, 3) J [s]: ``rotation`` and ``velocity`` move by Exp(-J bg) and -J ba.
    per_gyro_bias : (n, 3, 3) [m]: ``velocity`` moves by -per_gyro_bias bg.

    Raises
    ------
    InputError : shapes that differ or a number that is not finite.
    """

    rotation: Array
    velocity: Array
    per_accel_bias: Array
    per_gyro_bias: Array

    def __post_init__(self) -> None:
        n = len(np.asarray(self.rotation))
        shapes = {"rotation": (n, 4), "velocity": (n, 3), "per_accel_bias": (n, 3, 3), "per_gyro_bias": (n, 3, 3)}
        for name, shape in shapes.items():
            value = np.ascontiguousarray(getattr(self, name), float)
            if value.shape != shape:
                raise InputError(f"increments {name}", got=f"shape {value.shape}", expected=f"shape {shape}")
            bad = np.flatnonzero(~np.isfinite(value).all(axis=tuple(range(1, value.ndim))))
            if bad.size:
                raise InputError(f"increments {name}", place=f"row {bad[0]}", got="a number that is not finite")
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.rotation)


def reading_rows(increments: Increments, reference: ArrayLike) -> Array:
    """Return rows (n, 27) of increments and reference velocity north, east (n, 2) [m/s], NaN where missing.

    Raises
    ------
    InputError : another number of rows, or an infinite velocity.
    """
    z = np.asarray(reference, float)
    if z.shape != (len(increments), 2):
        raise InputError("reference velocity", got=f"shape {z.shape}", expected=f"shape ({len(increments)}, 2)")
    if np.isinf(z).any():
        row = int(np.flatnonzero(np.isinf(z).any(axis=1))[0])
        raise InputError("reference velocity", place=f"row {row}", got=str(z[row]), expected="m/s, NaN where missing")
    n = len(increments)
    flat = (increments.per_accel_bias.reshape(n, 9), increments.per_gyro_bias.reshape(n, 9))
    return np.ascontiguousarray(np.hstack([increments.rotation, increments.velocity, *flat, z]))
