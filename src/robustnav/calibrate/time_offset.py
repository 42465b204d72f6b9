"""The time offset between the stamps of ranges, or of a run's positions, and a reference track.

A stamp t means the reference's time t - delta: what is stamped t was measured where the reference was delta earlier.
Ranges alone say nothing of delta, for the whole path may be relabelled; a second clock is needed.  A tag that sits
ahead of the reference point, or behind it, looks the same as an offset as long as the speed does not change:
delta v stands for a lever along the course.  Both are fitted, alone and together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.calibrate.time_offset_fit import (
    Fit,
    OffsetOptions,
    Readings,
    Track,
    Value,
    blocks_of,
    cost_at,
    fit,
    labels_of,
    residuals,
    robust_cost,
    usable,
)
from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array, BoolArray, Ranges, Stream

COARSE = 0.05  # s between the offsets tried first
MIMIC = 0.5  # share of the fall in cost by an offset that a lever alone must reach to be named


@dataclass(frozen=True)
class TimeOffset:
    """An offset of time and how far it can be told from a lever.

    Parameters
    ----------
    offset : delta [s] without any lever: stamp t means the reference's time t - delta.
    lever_alone : distance of the tag ahead of the reference point along the course [m], without any offset.
    offset_beside, lever_beside : both fitted together; None where the speed changes too little to part them.
    cost_none, cost_offset, cost_lever, cost_both : robust costs of the four fits at one common scale; ``cost_both`` is
        NaN where there is no such fit.
    biases : of anchors or axes by name [m], measured minus predicted, from the fit of the offset.
    sd : of a reading about the fit of the offset [m].
    rows, blocks : readings in motion that were used, and the blocks of time they fall into.
    warning : words where a lever explains the readings nearly as well, or empty.
    """

    offset: Value
    lever_alone: Value
    offset_beside: Value | None
    lever_beside: Value | None
    cost_none: float
    cost_offset: float
    cost_lever: float
    cost_both: float
    biases: dict[str, float]
    sd: float
    rows: int
    blocks: int
    warning: str


def offset_of_ranges(ranges: Ranges, track: Stream, options: OffsetOptions | None = None) -> TimeOffset:
    """Return the time offset of ranges against a reference track.

    Parameters
    ----------
    ranges : calibrated, of one tag at the reference point as far as is known.
    track : (n, 3) positions [m] in the anchors' frame a.
    options : None for the defaults.

    Raises
    ------
    InputError : a track that is none, several tags, or too little motion in common.
    EstimatorError : a fit that does not converge within the offsets considered.

    References
    ----------
    Huber, Robust Statistics (1981), chapter 7; intervals from whole blocks of time as in ``calibrate.robust``.
    """
    if len(np.unique(ranges.tag)) > 1:
        raise InputError("time offset", got="ranges of several tags", expected="one tag", do="take one with where()")
    anchors = ranges.anchors.p_a[ranges.anchor]

    def predict(p: Array, rows: BoolArray) -> tuple[Array, Array]:
        away = p - anchors[rows]
        d = np.sqrt(np.einsum("ni,ni->n", away, away))
        return d, away / np.maximum(d, 1e-9)[:, None]

    given = Readings(ranges.t, ranges.distance, np.asarray(ranges.anchor, np.int64), ranges.anchors.ids, predict)
    return _estimate(given, track, options or OffsetOptions())


def offset_of_positions(positions: Stream, track: Stream, options: OffsetOptions | None = None) -> TimeOffset:
    """Return the time offset of a run's positions against a reference track.

    Parameters
    ----------
    positions, track : (n, 3) positions [m] in one frame; NaN rows of the positions are left out.
    options : None for the defaults; ``biases`` are of the three axes.

    Raises
    ------
    InputError : a track that is none, or too little motion in common.
    EstimatorError : a fit that does not converge within the offsets considered.
    """
    known = np.isfinite(positions.values).all(axis=1)
    t, values = positions.t[known], positions.values[known]
    if values.shape[1:] != (3,):
        raise InputError("positions", got=f"shape {positions.values.shape}", expected="shape (n, 3)")
    axis = np.tile(np.arange(3), len(t))

    def predict(p: Array, rows: BoolArray) -> tuple[Array, Array]:
        here = axis[rows]
        return p[np.arange(len(p)), here], np.eye(3)[here]

    given = Readings(np.repeat(t, 3), values.ravel(), axis, ("x", "y", "z"), predict)
    return _estimate(given, track, options or OffsetOptions())


def _estimate(given: Readings, track: Stream, options: OffsetOptions) -> TimeOffset:
    reference = Track(track, options.max_gap)
    rows = usable(given, reference, options)
    start = min(
        np.arange(-options.largest, options.largest + COARSE / 2, COARSE),
        key=lambda delta: cost_at(given, reference, rows, options, float(delta)),
    )
    alone = fit(given, reference, rows, options, (float(start), None))
    lever = fit(given, reference, rows, options, (None, 0.0))
    try:
        both: Fit | None = fit(given, reference, rows, options, (float(start), 0.0))
    except (InputError, EstimatorError):  # at one speed the two columns are one, or nearly
        both = None
    none = residuals(given, reference, rows, options, (0.0, 0.0))
    scale = both.sd if both is not None else alone.sd
    costs = [robust_cost(options.loss, e / scale) for e in (none, alone.e, lever.e)]
    if alone.delta is None or lever.lever is None:
        raise EstimatorError("time offset", got="no estimate", do="look at the track")
    return TimeOffset(
        offset=alone.delta,
        lever_alone=lever.lever,
        offset_beside=None if both is None else both.delta,
        lever_beside=None if both is None else both.lever,
        cost_none=costs[0],
        cost_offset=costs[1],
        cost_lever=costs[2],
        cost_both=float("nan") if both is None else robust_cost(options.loss, both.e / scale),
        biases=dict(zip(labels_of(given, rows), alone.biases.tolist(), strict=False)),
        sd=alone.sd,
        rows=int(np.count_nonzero(rows)),
        blocks=len(np.unique(blocks_of(given.t[rows], options))),
        warning=_warning(costs, alone.delta, None if both is None else both.delta),
    )


def _warning(costs: list[float], alone: Value, beside: Value | None) -> str:
    """Say where a lever explains the readings nearly as well as an offset."""
    none, offset, lever = costs
    if not offset < none:
        return "an offset explains no more than none does"
    share = (none - lever) / (none - offset)
    if beside is None:
        return "at one speed an offset and a forward lever arm are the same thing: change the speed, or measure the arm"
    apart = not beside.low <= alone.value <= beside.high
    if share > MIMIC or apart:
        return (
            f"a lever arm along the course explains {100 * min(share, 9.99):.0f} % of what the offset does; "
            f"with both, the offset is {beside.value:.3f} s ({beside.low:.3f} .. {beside.high:.3f})"
        )
    return ""
