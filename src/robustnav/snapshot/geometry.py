"""What a layout can give before anything is measured: dilution of precision on plain arrays."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from robustnav.records import Array
from robustnav.snapshot.core import distances
from robustnav.snapshot.record import Dop


class Sensing(NamedTuple):
    """What is measured: ``ranges`` or ``differences`` of ranges, and whether the third coordinate is known."""

    kind: Literal["ranges", "differences"] = "ranges"
    height_known: bool = False


def information(p: Array, anchors: Array, sensing: Sensing) -> Array:
    """Return G^T G (n, f, f) at positions (n, d) for ranges of unit sd, f free coordinates.

    For range differences a common offset is eliminated, whichever anchor is the reference.
    """
    u = distances(p, anchors)[1][..., : p.shape[1] - int(sensing.height_known)]
    if sensing.kind == "differences":
        u = u - u.mean(axis=1, keepdims=True)
    return u.swapaxes(1, 2) @ u


def dop(p: Array, anchors: Array, sensing: Sensing) -> Dop:
    """Return the dilution of precision (n,) at positions (n, d); infinite where a direction is not observable.

    References
    ----------
    Langley, "Dilution of precision", GPS World 10 (1999); without a clock state for two-way ranges.
    """
    values, vectors = np.linalg.eigh(information(p, anchors, sensing))
    good = values[:, 0] > 1e-10 * values[:, -1]
    variance = ((vectors * vectors) / np.where(good[:, None], values, 1.0)[:, None, :]).sum(axis=2)
    variance = np.where(good[:, None], variance, np.inf)
    vertical = np.sqrt(variance[:, 2]) if variance.shape[1] == 3 else np.full(len(p), np.nan)
    return Dop(np.sqrt(variance.sum(axis=1)), np.sqrt(variance[:, :2].sum(axis=1)), vertical)
