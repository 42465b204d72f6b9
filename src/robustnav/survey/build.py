"""From what was ranged and what is known to the arrays of a network, with the frame laid where nothing fixes it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array, IntArray
from robustnav.survey.network import Network
from robustnav.survey.record import Frame, Known, Measured, Options, TagRanges


class Task(NamedTuple):
    """A network and how its frame is laid.

    ``first``: rows of the three anchors that lay it, None where known positions do; ``level``: heights are known, of
    all anchors where known positions lay the frame, else of one at least, so that only x and y were free to lay;
    ``tag_rows``: which of the tag's ranges are in the network, behind the links.
    """

    network: Network
    first: tuple[int, int, int] | None
    level: bool
    tag_rows: IntArray


def build(measured: Measured, known: Known | None, frame: Frame, options: Options) -> Task:
    """Return the task of a survey.

    Raises
    ------
    InputError : known positions for another number of anchors, or three anchors of the frame that are not there.
    """
    k = len(measured.ids)
    if known is not None and len(known.p_a) != k:
        raise InputError("known positions", got=f"{len(known.p_a)}", expected=f"one row for each of {k} anchors")
    position = np.full((k, 3), np.nan) if known is None else known.p_a.copy()
    info = np.where(np.isnan(position), 0.0, np.inf)
    if known is not None and known.sd is not None:
        info = np.where(np.isnan(position), 0.0, known.sd**-2.0)
    level = bool(np.isfinite(position[:, 2]).any())
    if known is not None and known.tag_z is not None and not level:
        do = "give the height of an anchor too, best of all"
        raise InputError("height of the tag", got="no height of an anchor", expected="heights above one level", do=do)
    first = None
    if np.isnan(position[:, :2]).all():
        first = _first(measured.ids, frame)
        _lay(position, info, first, level)
    else:
        level = bool(np.isfinite(position[:, 2]).all())
    ends, share, distance, sd, tag_rows, knots = _ranges(measured, options, _needed(known))
    held = np.concatenate([position, np.full((len(knots), 3), np.nan)])
    held_info = np.concatenate([info, np.zeros((len(knots), 3))])
    if known is not None and known.tag_z is not None:
        held[k:, 2], held_info[k:, 2] = known.tag_z, known.tag_z_sd**-2.0
    if np.isinf(held_info[:k]).all():
        raise InputError("survey", got="every coordinate known exactly", expected="something to find")
    bends, weights, bend_info = _bends(k, knots, options)
    network = Network(
        anchors=k,
        ends=ends,
        share=share,
        distance=distance,
        info=sd**-2.0,
        known=np.nan_to_num(held),
        known_info=held_info,
        bends=bends,
        bend_weights=weights,
        bend_info=bend_info,
    )
    return Task(network, first, level, tag_rows)


def _first(ids: tuple[str, ...], frame: Frame) -> tuple[int, int, int]:
    names = frame.first or ids[:3]
    if len(set(names)) != 3 or not set(names) <= set(ids):
        do = "name three anchors, best far apart and not in a row"
        raise InputError("frame", got=", ".join(names), expected=f"three of {', '.join(ids)[:200]}", do=do)
    a, b, c = (ids.index(name) for name in names)
    return a, b, c


def _lay(position: Array, info: Array, first: tuple[int, int, int], level: bool) -> None:
    """Fix the coordinates that no range can tell: origin, direction of x, and with no height known the plane."""
    origin, axis, plane = first
    held = [(origin, 0), (origin, 1), (axis, 1)]
    held += [] if level else [(origin, 2), (axis, 2), (plane, 2)]
    for row, column in held:
        position[row, column], info[row, column] = 0.0, np.inf


def _needed(known: Known | None) -> int:
    """Return the unknowns of a tag at one stamp: as many ranges alone say nothing of the anchors."""
    return 3 if known is None or known.tag_z is None else 2


def _ranges(measured: Measured, options: Options, needed: int) -> tuple[IntArray, Array, Array, Array, IntArray, Array]:
    """Return ends, shares, distances and sds of all ranges, the tag's rows among them, and the knots [s]."""
    k, links, tag = len(measured.ids), measured.links, measured.tag
    no_rows, nothing = np.zeros(0, np.int64), np.zeros(0)
    ends, share, distance, sd = np.zeros((0, 3), np.int64), nothing, nothing, nothing
    if links is not None:
        ends = np.column_stack([links.first, links.second, links.second])
        share, distance, sd = np.zeros(len(ends)), links.distance, links.sd
    if tag is None:
        return ends, share, distance, sd, no_rows, nothing
    rows, knots, start, along = _track(tag, options.knot_s, needed)
    last = np.minimum(start + 1, len(knots) - 1)
    tag_ends = np.column_stack([tag.anchor[rows], k + start, k + np.where(along > 0, last, start)])
    return (
        np.concatenate([ends, tag_ends]),
        np.concatenate([share, along]),
        np.concatenate([distance, tag.distance[rows]]),
        np.concatenate([sd, tag.sd[rows]]),
        rows,
        knots,
    )


def _track(tag: TagRanges, knot_s: float | None, needed: int) -> tuple[IntArray, Array, IntArray, Array]:
    """Return the rows in use, the times of the knots [s], and for each row the knot before and the share beyond it."""
    if knot_s is None:
        stamps, index, count = np.unique(tag.t, return_inverse=True, return_counts=True)
        good = count > needed
        number = np.cumsum(good) - 1
        rows = np.flatnonzero(good[index])
        return rows, stamps[good], number[index][rows], np.zeros(len(rows))
    spans = max(1, int(np.ceil((tag.t[-1] - tag.t[0]) / knot_s)))
    knots = tag.t[0] + knot_s * np.arange(spans + 1)
    at = (tag.t - tag.t[0]) / knot_s
    start = np.minimum(at.astype(np.int64), spans - 1)
    return np.arange(len(tag.t)), knots, start, np.clip(at - start, 0.0, 1.0)


def _bends(k: int, knots: Array, options: Options) -> tuple[IntArray, Array, Array]:
    """Return the accelerations at inner knots: nodes, weights [1/s^2] and information."""
    if options.knot_s is None or len(knots) < 3:
        return np.zeros((0, 3), np.int64), np.zeros((0, 3)), np.zeros(0)
    inner = np.arange(1, len(knots) - 1)
    bends = k + np.stack([inner - 1, inner, inner + 1], axis=1)
    weights = np.tile([1.0, -2.0, 1.0], (len(inner), 1)) / options.knot_s**2
    return bends, weights, np.full(len(inner), options.acceleration_sd**-2.0)
