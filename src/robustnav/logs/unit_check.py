"""Whether numbers are an attitude at all; a reader that scaled anything to unit norm would hide a wrong column."""

from __future__ import annotations

import numpy as np

from robustnav.records import Array

TOLERANCE = 0.01  # of the norm; float32 and four printed digits pass


def not_unit(q: Array) -> tuple[int, float] | None:
    """Return row and norm of the first quaternion (n, 4) that is neither of unit norm nor missing (NaN), or None."""
    with np.errstate(over="ignore"):
        size = np.linalg.norm(q, axis=1)
    bad = np.flatnonzero(np.isinf(size) | (np.abs(size - 1) > TOLERANCE))
    return (int(bad[0]), float(size[bad[0]])) if bad.size else None
