"""The fit behind a time offset: predictions from a reference track moved in time and along its course."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robustnav.calibrate.range_line import student
from robustnav.calibrate.robust import HUBER, MAD_TO_SD, Loss, fit_linear
from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array, BoolArray, IntArray, Stream

MIN_SPEED = 0.3  # m/s: below, position says nothing of time
STEPS = 30
CONVERGED = 1e-6  # s, m
MIN_ROWS = 30


@dataclass(frozen=True)
class OffsetOptions:
    """How an offset is sought.

    Parameters
    ----------
    largest : offset considered [s].
    biases : whether each anchor, or each axis of positions, has a constant error of its own.
    block_s : errors closer in time than this may be correlated in any way: intervals rest on whole blocks.
    max_gap : of the reference across which it is interpolated [s].
    loss : against gross errors.
    level : of the intervals.

    Raises
    ------
    InputError : a number out of its range.
    """

    largest: float = 1.0
    biases: bool = True
    block_s: float = 10.0
    max_gap: float = 0.5
    loss: Loss = HUBER
    level: float = 0.95

    def __post_init__(self) -> None:
        for name in ("largest", "block_s", "max_gap"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise InputError(f"time offset, {name}", got=str(getattr(self, name)), expected="seconds above 0")
        if not 0 < self.level < 1:
            raise InputError("time offset, level", got=str(self.level), expected="a number between 0 and 1")


class Value(NamedTuple):
    """An estimate with the ends of its interval."""

    value: float
    low: float
    high: float


class Track:
    """A reference: position, and velocity between its samples, by straight lines; NaN across gaps and outside."""

    def __init__(self, track: Stream, max_gap: float) -> None:
        known = np.isfinite(track.values).all(axis=1)
        self.t, self.p = track.t[known], track.values[known]
        if self.p.ndim != 2 or self.p.shape[1] != 3 or len(self.t) < 3 or not (np.diff(self.t) > 0).all():
            got = f"{len(self.t)} samples of shape {track.values.shape[1:]}, times that repeat or too few"
            raise InputError("reference track", got=got, expected="(n, 3) positions, n >= 3, times that ascend")
        self._max_gap = max_gap
        self._v = np.gradient(self.p, self.t, axis=0)

    def at(self, t: Array) -> tuple[Array, Array]:
        """Return positions and velocities (n, 3) at times (n,) [s]."""
        p, v = (np.column_stack([np.interp(t, self.t, c) for c in part.T]) for part in (self.p, self._v))
        row = np.clip(np.searchsorted(self.t, t, side="right"), 1, len(self.t) - 1)
        outside = (t < self.t[0]) | (t > self.t[-1]) | (self.t[row] - self.t[row - 1] > self._max_gap)
        p[outside] = np.nan
        v[outside] = np.nan
        return p, v


class Readings(NamedTuple):
    """Scalar readings: ``t`` (n,), ``z`` (n,) m, ``label`` (n,) into ``names``, and ``predict`` from positions (n, 3)
    to values (n,) and the unit vectors (n, 3) along which they change.
    """

    t: Array
    z: Array
    label: IntArray
    names: tuple[str, ...]
    predict: Callable[[Array, BoolArray], tuple[Array, Array]]


class Fit(NamedTuple):
    """Offset [s] and lever [m], None where not sought, ``biases`` [m], residuals ``e`` (n,) and their ``sd`` [m]."""

    delta: Value | None
    lever: Value | None
    biases: Array
    e: Array
    sd: float


def usable(given: Readings, reference: Track, options: OffsetOptions) -> BoolArray:
    """Return the readings (n,) taken in motion and inside the track whatever offset is tried."""
    keep = np.isfinite(given.z)
    for delta in (-options.largest, 0.0, options.largest):
        p, v = reference.at(given.t - delta)
        keep &= np.isfinite(p).all(axis=1)
        if delta == 0.0:
            keep &= np.linalg.norm(np.nan_to_num(v), axis=1) > MIN_SPEED
    count = int(np.count_nonzero(keep))
    if count < MIN_ROWS:
        got = f"{count} readings while the reference moves faster than {MIN_SPEED} m/s"
        raise InputError("time offset", got=got, expected=f"{MIN_ROWS} or more", do="take a recording with motion")
    columns = 2 + (len(np.unique(given.label[keep])) if options.biases else 0)
    blocks = len(np.unique(blocks_of(given.t[keep], options)))
    if blocks <= columns:
        do = "take a longer recording, or fewer seconds a block, or no biases"
        raise InputError("time offset", got=f"{blocks} blocks of time", expected=f"more than {columns}", do=do)
    return np.asarray(keep, bool)


def _columns(given: Readings, reference: Track, rows: BoolArray, at: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Return measured minus predicted (n,) and its columns for offset and lever (n,) at (offset, lever)."""
    p, v = reference.at(given.t[rows] - at[0])
    course = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)
    predicted, u = given.predict(p + at[1] * course, rows)
    along = np.einsum("ni,ni->n", u, course)
    return given.z[rows] - predicted, -np.einsum("ni,ni->n", u, v), along


def labels_of(given: Readings, rows: BoolArray) -> list[str]:
    """Return the names of the anchors or axes that have readings in use."""
    return [given.names[k] for k in np.unique(given.label[rows])]


def _bias_columns(given: Readings, rows: BoolArray, options: OffsetOptions) -> Array:
    if not options.biases:
        return np.zeros((int(np.count_nonzero(rows)), 0))
    label = given.label[rows]
    return np.asarray(label[:, None] == np.unique(label), float)


def blocks_of(t: Array, options: OffsetOptions) -> IntArray:
    """Return the block of time of each reading (n,)."""
    return np.asarray(np.floor(t / options.block_s), np.int64)


def residuals(
    given: Readings, reference: Track, rows: BoolArray, options: OffsetOptions, at: tuple[float, float]
) -> Array:
    """Return residuals (n,) at a given offset and lever, biases taken out by their medians."""
    e = _columns(given, reference, rows, at)[0]
    if options.biases:
        label = np.unique(given.label[rows], return_inverse=True)[1]
        e = e - np.array([np.median(e[label == k]) for k in range(int(label.max()) + 1)])[label]
    return e


def cost_at(given: Readings, reference: Track, rows: BoolArray, options: OffsetOptions, delta: float) -> float:
    """Return the sum of absolute residuals: no scale is needed to compare starts."""
    return float(np.abs(residuals(given, reference, rows, options, (delta, 0.0))).sum())


def fit(
    given: Readings,
    reference: Track,
    rows: BoolArray,
    options: OffsetOptions,
    start: tuple[float | None, float | None],
) -> Fit:
    """Return the fit of what has a start: offset, lever or both, beside the biases, by Gauss-Newton steps."""
    free = [k for k, one in enumerate(start) if one is not None]
    at = np.array([one or 0.0 for one in start])
    biases, blocks = _bias_columns(given, rows, options), blocks_of(given.t[rows], options)
    for _ in range(STEPS):
        e, *columns = _columns(given, reference, rows, (float(at[0]), float(at[1])))
        X = np.column_stack([*(columns[k] for k in free), biases])
        found = fit_linear(X, e, options.loss, blocks)
        at[free] += found.beta[: len(free)]
        if not abs(at[0]) <= options.largest:
            do = "widen the offsets considered, or look whether track and ranges share a frame and a clock"
            raise EstimatorError("time offset", got=f"beyond {options.largest:g} s", expected="an offset inside", do=do)
        if np.abs(found.beta[: len(free)]).max() < CONVERGED:
            break
    else:
        raise EstimatorError("time offset", got=f"no convergence in {STEPS} steps", do="look at the track for jumps")
    half = student(options.level, found.dof) * np.sqrt(np.diag(found.covariance))
    values: list[Value | None] = [None, None]
    for n, k in enumerate(free):
        values[k] = Value(float(at[k]), float(at[k] - half[n]), float(at[k] + half[n]))
    rest = e - X @ found.beta
    sd = MAD_TO_SD * float(np.median(np.abs(rest - np.median(rest))))
    return Fit(values[0], values[1], found.beta[len(free) :], rest, sd)


def robust_cost(loss: Loss, u: Array) -> float:
    """Return the robust cost of residuals ``u`` (n,) in standard deviations: the integral of weight(u) u."""
    a, c = np.abs(u), loss.constant
    if np.isinf(c):
        return float(0.5 * (a * a).sum())
    if loss.kind == "huber":
        return float(np.where(a <= c, 0.5 * a * a, c * (a - 0.5 * c)).sum())
    return float((0.5 * (c + 1.0) * np.log1p(a * a / c)).sum())
