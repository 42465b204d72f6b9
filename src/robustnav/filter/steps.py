"""What every filter step says of a reading, and packed covariances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.frames import Array


@dataclass(frozen=True)
class Seen:
    """A reading before it was used.

    ``nu`` (rows,): measured minus predicted; ``s`` (rows,): predicted variances, NaN for a constant gain;
    ``nis``: sum of nu^2 / s (or nu' S^-1 nu); ``weight``: what it counted for, 0 when a rule or a broken covariance
    refused it; ``margin``: of existence of an H-infinity filter after it, NaN of other filters.
    """

    nu: Array
    s: Array
    nis: float
    weight: float
    margin: float = float("nan")

    @property
    def used(self) -> bool:
        """Whether it moved the estimate."""
        return self.weight > 0


def pack(P: Array) -> Array:
    """Return the upper triangle by rows (n (n + 1) / 2,) of a symmetric matrix (n, n)."""
    out: Array = P[np.triu_indices(len(P))]
    return out


def unpack(packed: Array) -> Array:
    """Return symmetric matrices (..., n, n) of upper triangles by rows (..., n (n + 1) / 2)."""
    packed = np.asarray(packed, float)
    n = int((np.sqrt(8 * packed.shape[-1] + 1) - 1) / 2)
    rows, columns = np.triu_indices(n)
    out = np.zeros((*packed.shape[:-1], n, n))
    out[..., rows, columns] = packed
    out[..., columns, rows] = packed
    return out
