"""The rows an alignment reads: increments of a period, reference velocity and magnetic field at its end."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.strapdown.increments import Increments

VELOCITY, FIELD = slice(25, 27), slice(27, 30)  # where they stand in a row


def reading_rows(increments: Increments, reference: ArrayLike, field_b: ArrayLike | None = None) -> Array:
    """Return rows (n, 30) of increments, reference velocity and magnetic field.

    Parameters
    ----------
    increments : n of them.
    reference : (n, 2) velocity north and east [m/s], NaN where missing.
    field_b : (n, 3) magnetic field in body axes, any unit, NaN where missing; None without a compass.

    Raises
    ------
    InputError : another number of rows, an infinite number, or a field of length zero.
    """
    z = np.asarray(reference, float)
    if z.shape != (len(increments), 2):
        raise InputError("reference velocity", got=f"shape {z.shape}", expected=f"shape ({len(increments)}, 2)")
    _refuse("reference velocity", np.isinf(z).any(axis=1), z, "m/s, NaN where missing")
    field = np.full((len(z), 3), np.nan) if field_b is None else np.asarray(field_b, float)
    if field.shape != (len(z), 3):
        raise InputError("magnetic field", got=f"shape {field.shape}", expected=f"shape ({len(z)}, 3)")
    _refuse("magnetic field", np.isinf(field).any(axis=1) | ~field.any(axis=1), field, "a field, NaN where missing")
    return np.ascontiguousarray(np.hstack([increments.rows, z, field]))


def zero_velocity(increments: Increments) -> Array:
    """Return the reference (n, 2) [m/s] of a base that stands still; ``reference_sd`` is then how much it trembles."""
    return np.zeros((len(increments), 2))


def _refuse(thing: str, bad: Array, values: Array, expected: str) -> None:
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise InputError(thing, place=f"row {row}", got=str(values[row]), expected=expected)
