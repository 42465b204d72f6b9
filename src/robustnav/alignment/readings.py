"""The rows an alignment reads: increments of one period, and the reference velocity at its end."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.strapdown.increments import Increments


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
    return np.ascontiguousarray(np.hstack([increments.rows, z]))
