"""Position of a slow tag from the ranges or differences of a short window, among outliers: where a filter starts.

Readings of the last half second or so, each anchor several times.  From several starts a damped Gauss-Newton descent
of a Student-t cost; the lowest minimum and its rivals come back, mirror images among them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robustnav.records import Array, BoolArray
from robustnav.snapshot.core import Problem, scale_of
from robustnav.snapshot.starts import starts

DEGREES_OF_FREEDOM = 4.0
MOST_STEPS = 40
LONGEST_STEP = 10.0  # m
_SMALL = 1e-6  # m, of a step
_APART = 3.0  # standard deviations between two minima that count as two


class WindowReadings(NamedTuple):
    """Readings of one tag, one row each, in the anchors' axes.

    ``value`` (m,) [m]: the distance to ``first`` (m, 3), or where ``pairs`` (m,) is true the distance to ``second``
    (m, 3) minus that to ``first``; ``sd`` (m,) [m]; ``down``: where the tag is on the third axis [m], or None, known
    to ``down_sd`` [m]: zero exactly, as in a plane.
    """

    value: Array
    first: Array
    second: Array
    pairs: BoolArray
    sd: Array
    down: float | None = None
    down_sd: float = 0.0

    @property
    def free(self) -> int:
        """Coordinates that are sought: 2 with a third that is known exactly, else 3."""
        return 2 if self.down is not None and self.down_sd == 0.0 else 3

    @property
    def down_known(self) -> tuple[float, float] | None:
        """The third coordinate [m] and its information [1/m^2]; None where it is unknown or exact."""
        return None if self.down is None or self.down_sd == 0.0 else (self.down, self.down_sd**-2)


class Minimum(NamedTuple):
    """A place ``p`` (3,) [m] the readings may come from, its covariance ``P`` (3, 3) [m^2] and robust ``cost``."""

    p: Array
    P: Array
    cost: float


def residuals(readings: WindowReadings, p: Array) -> tuple[Array, Array]:
    """Return measured minus predicted (..., m) [m] and the rows of its Jacobian (..., m, 3) at ``p`` (..., m, 3)."""
    one, row = _distance(p - readings.first)
    two, other = _distance(p - readings.second)
    predicted = np.where(readings.pairs, two - one, one)
    J = np.where(readings.pairs[:, None], other - row, row)
    return readings.value - predicted, J


def robust_cost(readings: WindowReadings, p: Array) -> Array:
    """Return the Student-t cost (...) of the tag at ``p`` (..., m, 3) [m], a place for each reading."""
    e = residuals(readings, p)[0] / readings.sd
    cost: Array = 0.5 * (DEGREES_OF_FREEDOM + 1) * np.log1p(e * e / DEGREES_OF_FREEDOM).sum(axis=-1)
    if readings.down_known is not None:
        down, info = readings.down_known
        cost = cost + 0.5 * info * (p[..., 0, 2] - down) ** 2
    return cost


def robust_minima(readings: WindowReadings, guesses: Array | None = None) -> list[Minimum]:
    """Return the minima of the robust cost, the lowest first.

    Parameters
    ----------
    readings : of a window in which the tag hardly moves.
    guesses : (k, 3) places to start from beside the closed forms [m], or None.

    Returns
    -------
    minima : empty with fewer than three readings that differ in geometry; a direction the readings say nothing of has
        a huge variance.
    """
    if len(readings.value) < 3:
        return []
    begin = _closed_forms(readings)
    begin = begin if guesses is None else np.vstack([begin, guesses])
    found = _descend(readings, begin)
    mirrored = _mirrored(readings, found[0].p) if found else None
    if mirrored is not None:
        found = sorted([*found, *_descend(readings, mirrored[None])], key=lambda m: m.cost)
    kept: list[Minimum] = []
    for one in found:
        if all(np.linalg.norm(one.p - k.p) > _APART * np.sqrt(_smallest(k.P)) + 1e-3 for k in kept):
            kept.append(one)
    return kept


def _distance(away: Array) -> tuple[Array, Array]:
    d = np.sqrt((away * away).sum(axis=-1))
    return d, away / np.maximum(d, 1e-12)[..., None]


def _smallest(P: Array) -> float:
    return float(np.linalg.eigvalsh(P).max())


def _descend(readings: WindowReadings, p: Array) -> list[Minimum]:
    """Return the minima reached from ``p`` (s, 3), sorted by cost."""
    free = readings.free
    p = p.copy()
    if free == 2:
        p[:, 2] = readings.down
    m = len(readings.value)

    def at(p: Array) -> Array:
        return np.broadcast_to(p[:, None, :], (len(p), m, 3))

    damping, cost = np.full(len(p), 1e-3), robust_cost(readings, at(p))
    moving = np.ones(len(p), bool)
    for _ in range(MOST_STEPS):
        rows = np.flatnonzero(moving)
        if not rows.size:
            break
        A, b = _normal(readings, at(p[rows]), free)
        diagonal = np.einsum("sii->si", A)
        scaled = A + (damping[rows, None] * diagonal + 1e-12 * diagonal.max(axis=1, keepdims=True))[..., None] * np.eye(
            free
        )
        step = np.linalg.solve(scaled, b[..., None])[..., 0]
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, LONGEST_STEP / np.maximum(length, 1e-300))[:, None]
        tried = p[rows].copy()
        tried[:, :free] += step
        new = robust_cost(readings, at(tried))
        better = new <= cost[rows]
        p[rows[better]], cost[rows[better]] = tried[better], new[better]
        damping[rows] = np.where(better, damping[rows] / 10, damping[rows] * 10)
        moving[rows] = ~((better & (length < _SMALL)) | (damping[rows] > 1e12))
    order = np.argsort(cost, kind="stable")
    return [Minimum(p[i], _covariance(readings, p[i], free), float(cost[i])) for i in order if np.isfinite(p[i]).all()]


def _normal(readings: WindowReadings, at: Array, free: int) -> tuple[Array, Array]:
    e, J = residuals(readings, at)
    J = J[..., :free]
    w = (DEGREES_OF_FREEDOM + 1) / (DEGREES_OF_FREEDOM * readings.sd**2 + e * e)
    A, b = np.einsum("smi,sm,smj->sij", J, w, J), np.einsum("smi,sm,sm->si", J, w, e)
    if readings.down_known is not None:
        down, info = readings.down_known
        A[:, 2, 2] += info
        b[:, 2] += info * (down - at[:, 0, 2])
    return A, b


def _covariance(readings: WindowReadings, p: Array, free: int) -> Array:
    """Return the covariance (3, 3); zero on a known third axis, 1e12 m^2 where the readings say nothing."""
    A = _normal(readings, np.broadcast_to(p, (1, len(readings.value), 3)), free)[0][0]
    values, vectors = np.linalg.eigh(A)
    out = np.zeros((3, 3))
    out[:free, :free] = (vectors / np.maximum(values, 1e-12)) @ vectors.T
    return out


def _closed_forms(readings: WindowReadings) -> Array:
    """Return starts (s, 3) from one range a place, the median of its readings."""
    ends = np.vstack([readings.first, readings.second[readings.pairs]])
    places, index = np.unique(ends, axis=0, return_inverse=True)
    index = index.reshape(-1)
    k, m = len(places), len(readings.value)
    differences = bool(readings.pairs.any())
    value: Array
    if differences:  # arrivals up to a common offset, from all pairs at once
        rows, second = np.flatnonzero(readings.pairs), index[m:]
        design = np.zeros((len(rows), k))
        design[np.arange(len(rows)), second] += 1.0
        design[np.arange(len(rows)), index[rows]] -= 1.0
        value = np.asarray(np.linalg.lstsq(design, readings.value[rows], rcond=None)[0], float)
    else:
        value = np.asarray([np.median(readings.value[index[:m] == i]) for i in range(k)])
    info = 1.0 / np.median(readings.sd) ** 2
    W = info * (np.eye(k) - differences * np.full((k, k), 1.0 / k))
    prior, prior_info = np.zeros(3), np.zeros(3)
    if readings.down is not None:
        prior[2], prior_info[2] = readings.down_known or (readings.down, 1e6)
    return starts(Problem(places, value, W, prior, prior_info, differences, scale_of(places, value)))


def _mirrored(readings: WindowReadings, p: Array) -> Array | None:
    """Return the image of ``p`` across the plane the anchors come nearest to, in space."""
    if readings.free == 2:
        return None
    places = np.unique(np.vstack([readings.first, readings.second[readings.pairs]]), axis=0)
    centre = places.mean(axis=0)
    normal = np.linalg.svd(places - centre)[2][2]
    image: Array = p - 2 * normal * (normal @ (p - centre))
    return image
