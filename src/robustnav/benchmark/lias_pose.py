"""Planar pose of a level body with several tags from the ranges of one instant, all instants at once.

Least squares in x, y and heading at a known height, by Gauss-Newton from four headings; H. Jiang et al., Efficient
Planar Pose Estimation via UWB Measurements, ICRA 2023, arXiv 2209.06779, state the problem.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.uwb_planar import PlanarPose
from robustnav.records import Array, IntArray, Ranges

HEADINGS = np.arange(4) * (np.pi / 2)
STEPS, SMALL = 100, 1e-6  # SMALL in m and rad
MIN_RANGES = 4  # one more than the unknowns


class _Epochs(NamedTuple):
    """Ranges (m, links) [m], NaN where missing; anchors and levers (links, 3) [m]; height: z of frame a [m]."""

    t: Array
    ranges: Array
    anchors: Array
    lever_b: Array
    height: float

    def rows(self, chosen: IntArray) -> _Epochs:
        return self._replace(t=self.t[chosen], ranges=self.ranges[chosen])


def planar_poses(ranges: Ranges, height: float, every: int = 1) -> PlanarPose:
    """Return the pose of every so-manieth instant, NaN where there are fewer than four ranges or no minimum.

    Parameters
    ----------
    ranges : with ``lever_b``; rows of one stamp are one instant.
    height : z of the body's origin in frame a [m], down.
    every : take one instant in so many.

    Raises
    ------
    InputError : no lever arms, no ranges, or a step below one.
    """
    if ranges.lever_b is None or not len(ranges) or every < 1:
        got = "no lever arms" if ranges.lever_b is None else f"{len(ranges)} ranges, every {every}"
        raise InputError("planar pose", got=got, expected="ranges with lever arms, every 1, 2, ...")
    epochs = _epochs(ranges, height, every)
    start = np.append(ranges.anchors.p_a[:, :2].mean(axis=0), 0.0)
    costs, poses = zip(*(_descend(epochs, start + np.array([0.0, 0.0, heading])) for heading in HEADINGS), strict=True)
    best = np.argmin(costs, axis=0)
    rows = np.arange(len(epochs.t))
    out: Array = np.stack(poses)[best, rows]
    out[~np.isfinite(np.stack(costs)[best, rows])] = np.nan
    return PlanarPose(epochs.t, out[:, :2], out[:, 2])


def _epochs(ranges: Ranges, height: float, every: int) -> _Epochs:
    t, row = np.unique(ranges.t, return_inverse=True)
    tags = len(ranges.tags)
    table = np.full((len(t), len(ranges.anchors.ids) * tags), np.nan)
    table[row, ranges.anchor * tags + ranges.tag] = ranges.distance
    anchors = np.repeat(ranges.anchors.p_a, tags, axis=0)
    lever_b = np.tile(np.asarray(ranges.lever_b), (len(ranges.anchors.ids), 1))
    return _Epochs(t[::every], table[::every], anchors, lever_b, height)


def _descend(epochs: _Epochs, start: Array) -> tuple[Array, Array]:
    """Return cost (m,) and pose (m, 3) after Gauss-Newton; an infinite cost where it did not settle."""
    x = np.tile(start, (len(epochs.t), 1))
    enough = np.sum(np.isfinite(epochs.ranges), axis=1) >= MIN_RANGES
    moving = np.flatnonzero(enough)
    for _ in range(STEPS):
        e, J = _residuals(epochs.rows(moving), x[moving])
        JtJ = np.einsum("mli,mlj->mij", J, J)
        step = np.einsum("mij,mj->mi", np.linalg.pinv(JtJ, hermitian=True), np.einsum("mlj,ml->mj", J, e))
        x[moving] += step
        moving = moving[~(np.abs(step) < SMALL).all(axis=1)]
        if not moving.size:
            break
    cost = np.where(enough, np.sum(_residuals(epochs, x)[0] ** 2, axis=1), np.inf)
    cost[moving] = np.inf
    return cost, x


def _residuals(epochs: _Epochs, x: Array) -> tuple[Array, Array]:
    """Return measured minus predicted (m, links) [m] and its derivative's negative (m, links, 3); missing ones zero."""
    c, s = np.cos(x[:, 2, None]), np.sin(x[:, 2, None])
    forward, right, down = epochs.lever_b.T
    turned = np.stack([c * forward - s * right, s * forward + c * right], axis=-1)
    apart = x[:, None, :2] + turned - epochs.anchors[:, :2]
    d = np.sqrt(np.sum(apart**2, axis=-1) + (epochs.height + down - epochs.anchors[:, 2]) ** 2)
    by_heading = apart[..., 1] * turned[..., 0] - apart[..., 0] * turned[..., 1]
    J = np.concatenate([apart, by_heading[..., None]], axis=-1) / d[..., None]
    missing = np.isnan(epochs.ranges)
    return np.where(missing, 0.0, epochs.ranges - d), np.where(missing[..., None], 0.0, J)
