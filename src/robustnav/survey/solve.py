"""Positions of anchors from ranges between them and to a moving tag, with a verdict."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array
from robustnav.snapshot.core import covariance_of
from robustnav.snapshot.honest import quantile
from robustnav.survey import words
from robustnav.survey.build import Task, build
from robustnav.survey.faults import Repair, repair
from robustnav.survey.inner import inner_covariance
from robustnav.survey.judge import Bound, bound, parted, spare
from robustnav.survey.minima import MOST, minima, mirrored
from robustnav.survey.network import End, Network, anchor_information, residuals
from robustnav.survey.record import AnchorSurvey, Frame, Known, Layout, Measured, Options, Suspect, Verdict, Weak
from robustnav.survey.starts import connected

CLEAR = 4.0  # sds an anchor must stand off the plane for its side to tell two mirror images apart


class _Place(NamedTuple):
    """All nodes (n, 3) of one layout and the covariance (3k, 3k) of its anchors."""

    p: Array
    covariance: Array


class _Layouts(NamedTuple):
    """The best layout, the others that fit, and what was said of them."""

    best: End
    others: list[_Place]
    bound: Bound
    verdict: Verdict
    reason: str


class _Doubt(NamedTuple):
    """The verdict on the whole and what it rests on."""

    verdict: Verdict
    reason: str
    suspects: tuple[Suspect, ...]
    isolated: bool
    cost: float
    dof: int
    scale: float


def survey_anchors(
    measured: Measured, known: Known | None = None, frame: Frame | None = None, options: Options | None = None
) -> AnchorSurvey:
    """Find where anchors stand, and say whether to believe it.

    Parameters
    ----------
    measured : calibrated ranges between anchors, to a moving tag, or both.
    known : positions known before, in whole or in part; None for none.
    frame : how the frame is laid where no x and y are known; None for the first three anchors.
    options : levels of the tests, robust loss, the tag's track; None for the defaults.

    Returns
    -------
    survey : positions in frame a, covariance, verdict and the reason for it.

    Raises
    ------
    InputError : known positions that do not fit the ids, a frame of anchors that are not there, ranges that say
        nothing of the anchors.

    References
    ----------
    Torgerson, Psychometrika 17 (1952), for the start; docs/survey.md for the tests.
    """
    options, frame = options or Options(), frame or Frame()
    task = build(measured, known, frame, options)
    sign = _side(measured.ids, frame, task)
    if not len(task.network.ends):
        raise InputError(
            "survey", got="no stamp with enough ranges", expected="four ranges of one stamp", do="give --knot"
        )
    groups = connected(task)
    if len(np.unique(groups)) > 1:
        return _apart(measured, task, words.apart(measured.ids, groups))
    ends = minima(task, options.confidence)
    cost, dof = ends[0].cost, task.network.dof
    if cost > quantile(options.confidence, dof):
        dof = spare(ends[0], task.network)
    limit = quantile(options.confidence, dof)
    if cost <= limit:
        found = _layouts(task, ends, sign, options, measured.ids)
        return _record(measured, task, found, _Doubt(found.verdict, found.reason, (), False, cost, dof, 1.0))
    mended = repair(task, ends, options)
    found = _layouts(mended.task, mended.ends, sign, options, measured.ids)
    for _, end in mended.rivals:
        found.others.extend(_images(end, task, sign))
    suspects = _suspects(measured, task, mended, found.best)
    isolated = mended.tried and not mended.rivals
    reason = words.inconsistent((cost, limit, dof), suspects, isolated, mended.scale)
    reason = f"{reason} Without: {found.reason}"
    doubt = _Doubt("inconsistent", reason, suspects, isolated, cost, dof, mended.scale)
    return _record(measured, mended.task, found, doubt)


def _side(ids: tuple[str, ...], frame: Frame, task: Task) -> tuple[int, float] | None:
    """Return the anchor whose side is told and the sign of its z."""
    if frame.side is None:
        return None
    name, side = frame.side
    free = task.first is not None and not task.level
    if not free or name not in ids or side not in ("+z", "-z") or ids.index(name) in (task.first or ()):
        got = f"{name} {side}" + ("" if free else " where known positions lay the frame")
        raise InputError("side of the frame", got=got, expected="another anchor than the three, and +z or -z")
    return ids.index(name), 1.0 if side == "+z" else -1.0


def _images(end: End, task: Task, sign: tuple[int, float] | None) -> list[_Place]:
    """Return the layouts that a minimum stands for: with the mirror image where no range tells it apart.

    Where the side of one anchor is told, and it stands clear of the plane, the image on that side.
    """
    network = task.network
    covariance = _whole(covariance_of(anchor_information(end.p, network))[0], network)
    straight = _Place(end.p, covariance)
    if task.first is None or task.level:
        return [straight]
    signs = np.tile([1.0, 1.0, -1.0], network.anchors)
    both = [straight, _Place(mirrored(end.p), covariance * np.outer(signs, signs))]
    if sign is None:
        return both
    row, wanted = sign
    height, variance = wanted * end.p[row, 2], covariance[3 * row + 2, 3 * row + 2]
    ordered = both if height >= 0 else both[::-1]
    return ordered[:1] if abs(height) > CLEAR * np.sqrt(variance) else ordered


def _whole(covariance: Array, network: Network) -> Array:
    """Return the covariance (3k, 3k) of all coordinates from that of the unknown ones."""
    k = network.anchors
    free = np.flatnonzero(network.free[:k])
    out = np.zeros((3 * k, 3 * k))
    out[np.ix_(free, free)] = covariance
    return out


def _layouts(
    task: Task, ends: list[End], sign: tuple[int, float] | None, options: Options, ids: tuple[str, ...]
) -> _Layouts:
    """Return the best layout with what binds it, and the others."""
    network, k = task.network, task.network.anchors
    places = [place for end in ends for place in _images(end, task, sign)]
    best = ends[0]._replace(p=places[0].p)
    fit = bound(best, network, options)
    cause = fit.cause or ("" if best.settled else "the search did not settle")
    cause = cause or (f"{MOST} layouts or more fit alike" if len(ends) >= MOST else "")
    near = [place.p for place in places[1:]]
    near += [mirrored(best.p)] if task.first is not None and not task.level else []
    near = [p for p in near if not parted(best.p, p, network, options.confidence)]
    if near and not cause:
        cause = "several layouts run into one long region"
        direction = (near[0] - best.p)[:k][network.free[:k]]
        fit = fit._replace(direction=direction / max(float(np.linalg.norm(direction)), 1e-12))
    others = places[1:]
    if cause:
        return _Layouts(best, others, fit, "degenerate", words.degenerate(_weak(fit, network, ids), cause))
    if others:
        mirror = task.first is not None and not task.level and len(others) == 1
        reason = words.ambiguous(best.p, [other.p for other in others], ids, mirror)
        return _Layouts(best, others, fit, "ambiguous", reason)
    return _Layouts(best, others, fit, "unique", words.unique(fit.sd, network.dof))


def _weak(fit: Bound, network: Network, ids: tuple[str, ...]) -> Weak:
    moved = np.zeros((network.anchors, 3))
    moved[network.free[: network.anchors]] = fit.direction
    size = np.linalg.norm(moved, axis=1)
    most = int(size.argmax())
    moving = tuple(name for name, one in zip(ids, size, strict=True) if one > 0.5 * size[most] > 0)
    return Weak(ids[most], moved[most] / max(float(size[most]), 1e-12), fit.sd * float(size[most]), moving)


def _suspects(measured: Measured, task: Task, mended: Repair, best: End) -> tuple[Suspect, ...]:
    network = task.network
    e = residuals(best.p, network)[0]
    rows = [*mended.left_out.tolist(), *(row for row, _ in mended.rivals)]
    found = []
    for row in rows:
        end = next((end for rival, end in mended.rivals if rival == row), None)
        error = float(e[row] if end is None else residuals(end.p, network)[0][row])
        sds = abs(error) * float(np.sqrt(network.info[row]))
        found.append(Suspect(*_place(measured, task, row), error, sds))
    return tuple(sorted(found, key=lambda one: -one.sds))


def _place(measured: Measured, task: Task, row: int) -> tuple[str, int, str]:
    """Return kind, row there and ends of a range of the network."""
    links = 0 if measured.links is None else len(measured.links.first)
    near = measured.ids[task.network.ends[row, 0]]
    if row < links:
        return "link", row, f"{near} - {measured.ids[task.network.ends[row, 1]]}"
    there = int(task.tag_rows[row - links])
    t = measured.tag.t[there] if measured.tag is not None else np.nan
    return "tag", there, f"{near} - tag at {t:.3f} s"


def _record(measured: Measured, task: Task, found: _Layouts, doubt: _Doubt) -> AnchorSurvey:
    network, k = task.network, task.network.anchors
    covariance = _whole(found.bound.covariance, network) * doubt.scale**2
    p = found.best.p[:k]
    whole = covariance if task.first is None else inner_covariance(p, np.nan_to_num(covariance), task.level)
    sd = np.sqrt(np.maximum(np.diag(whole), 0.0)).reshape(k, 3)
    if np.isnan(covariance).any():
        sd = np.full((k, 3), np.nan)
    link_e, tag_e = _residuals(measured, task, found.best.p)
    return AnchorSurvey(
        verdict=doubt.verdict,
        geometry=found.verdict,
        reason=doubt.reason,
        ids=measured.ids,
        p_a=p,
        covariance=covariance,
        sd=sd,
        alternatives=tuple(Layout(other.p[:k], other.covariance * doubt.scale**2) for other in found.others),
        weak=_weak(found.bound, network, measured.ids) if found.bound.direction.size else None,
        suspects=doubt.suspects,
        isolated=doubt.isolated,
        cost=doubt.cost,
        dof=doubt.dof,
        scale=doubt.scale,
        link_residuals=link_e,
        tag_residuals=tag_e,
    )


def _residuals(measured: Measured, task: Task, p: Array) -> tuple[Array, Array]:
    e = residuals(p, task.network)[0]
    links = 0 if measured.links is None else len(measured.links.first)
    tag = np.full(0 if measured.tag is None else len(measured.tag.t), np.nan)
    tag[task.tag_rows] = e[links:]
    return e[:links], tag


def _apart(measured: Measured, task: Task, reason: str) -> AnchorSurvey:
    """Return the survey of anchors that no chain of ranges ties together: no layout at all."""
    k = len(measured.ids)
    nothing = np.full((k, 3), np.nan)
    links, tag = _residuals(measured, task, np.full_like(task.network.known, np.nan))
    return AnchorSurvey(
        "degenerate", "degenerate", reason, measured.ids, nothing, np.full((3 * k, 3 * k), np.nan), nothing, (), None,
        (), False, float("nan"), task.network.dof, 1.0, links, tag,
    )  # fmt: skip
