"""Before measuring: maps of the dilution of precision, and where one more anchor helps most."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.records import Array
from robustnav.snapshot.geometry import Sensing, dop
from robustnav.snapshot.readings import anchor_array
from robustnav.snapshot.record import Dop

RANGES = Sensing()


class Grid(NamedTuple):
    """A level slice: coordinates ``x`` (nx,) and ``y`` (ny,) [m], and its third coordinate ``z`` [m], None in 2D."""

    x: ArrayLike
    y: ArrayLike
    z: float | None = None


class ExtraAnchor(NamedTuple):
    """The best place for one more anchor.

    ``row`` and ``position`` (d,) of the candidate; ``scores`` (c,) GDOP over the region with each candidate,
    ``before`` without any; ``blind`` (c,) points of the region that stay unobservable, left out of a mean.
    """

    row: int
    position: Array
    scores: Array
    before: float
    blind: Array


def dop_at(anchors: ArrayLike, p: ArrayLike, sensing: Sensing = RANGES) -> Dop:
    """Return the dilution of precision at positions.

    Parameters
    ----------
    anchors : (k, d) surveyed positions [m].
    p : (n, d) tag positions [m] in the same frame.
    sensing : ranges or differences, height known or not.

    Returns
    -------
    dop : arrays (n,); times the sd of one range it is the sd of the position.

    Raises
    ------
    InputError : shapes do not fit, or a height is known in 2D.
    """
    a = anchor_array(anchors)
    return dop(_points(p, a, "positions"), a, _checked(sensing, a))


def gdop_map(anchors: ArrayLike, grid: Grid, sensing: Sensing = RANGES, one_out: bool = False) -> Dop:
    """Return the dilution of precision over a grid.

    Parameters
    ----------
    anchors : (k, d) surveyed positions [m].
    grid : where the tag may be.
    sensing : ranges or differences, height known or not.
    one_out : take at each point the worst of the layouts with one anchor missing.

    Returns
    -------
    dop : arrays (ny, nx), infinite where a direction is not observable.

    Raises
    ------
    InputError : shapes do not fit, a grid without height for 3D anchors, one anchor alone with ``one_out``.
    """
    a = anchor_array(anchors)
    x, y = np.asarray(grid.x, float), np.asarray(grid.y, float)
    if x.ndim != 1 or y.ndim != 1:
        raise InputError("grid", got=f"x of shape {x.shape}, y of shape {y.shape}", expected="shapes (nx,) and (ny,)")
    if (grid.z is None) != (a.shape[1] == 2):
        raise InputError("grid height", got=str(grid.z), expected="a height for 3D anchors, None for 2D")
    level = [] if grid.z is None else [np.full(x.size * y.size, float(grid.z))]
    p = _points(np.column_stack([np.tile(x, y.size), np.repeat(y, x.size), *level]), a, "grid")
    sensing = _checked(sensing, a)
    if not one_out:
        return Dop(*(part.reshape(y.size, x.size) for part in dop(p, a, sensing)))
    if len(a) < 2:
        raise InputError("anchors", got="1", expected="at least 2 to leave one out")
    layouts = [dop(p, np.delete(a, row, axis=0), sensing) for row in range(len(a))]
    return Dop(*(np.max(part, axis=0).reshape(y.size, x.size) for part in zip(*layouts, strict=True)))


def best_extra_anchor(
    anchors: ArrayLike,
    region: ArrayLike,
    candidates: ArrayLike,
    sensing: Sensing = RANGES,
    goal: Literal["mean", "worst"] = "mean",
) -> ExtraAnchor:
    """Find where one more anchor lowers the GDOP over a region most.

    Candidates that leave the fewest points unobservable come first; among them the lowest mean or worst GDOP wins.

    Parameters
    ----------
    anchors : (k, d) anchors that stand [m].
    region : (n, d) points where the tag has to be found [m].
    candidates : (c, d) places an anchor could take [m].
    sensing : ranges or differences, height known or not.
    goal : ``mean`` or ``worst`` GDOP over the region.

    Returns
    -------
    extra : the candidate and the scores of all.

    Raises
    ------
    InputError : shapes do not fit, nothing to choose from, an unknown goal.
    """
    a = anchor_array(anchors)
    points, places = _points(region, a, "region"), _points(candidates, a, "candidates")
    if goal not in ("mean", "worst"):
        raise InputError("goal of the extra anchor", got=repr(goal), expected="mean or worst")
    sensing = _checked(sensing, a)
    scored = [_score(dop(points, np.vstack([a, place]), sensing).gdop, goal) for place in places]
    scores, blind = np.array([s for s, _ in scored]), np.array([b for _, b in scored])
    row = int(np.lexsort((scores, blind))[0])
    before = _score(dop(points, a, sensing).gdop, goal)[0]
    return ExtraAnchor(row, places[row], scores, before, blind)


def _score(gdop: Array, goal: str) -> tuple[float, int]:
    """Return the score over the observable points, infinite without any or for the worst, and the number of others."""
    seen = gdop[np.isfinite(gdop)]
    blind = gdop.size - seen.size
    if goal == "worst" or not seen.size:
        return float(gdop.max()), blind
    return float(seen.mean()), blind


def _points(p: ArrayLike, anchors: Array, thing: str) -> Array:
    out = np.asarray(p, float)
    if out.ndim != 2 or out.shape[1] != anchors.shape[1] or not len(out):
        raise InputError(thing, got=f"shape {out.shape}", expected=f"shape (n, {anchors.shape[1]}), n at least 1")
    bad = np.flatnonzero(~np.isfinite(out).all(axis=1))
    if bad.size:
        raise InputError(thing, place=f"row {bad[0]}", got=str(out[bad[0]]), expected="finite coordinates in m")
    return out


def _checked(sensing: Sensing, anchors: Array) -> Sensing:
    if sensing.kind not in ("ranges", "differences"):
        raise InputError("sensing", got=repr(sensing.kind), expected="ranges or differences")
    if sensing.height_known and anchors.shape[1] != 3:
        raise InputError("known height", got="2D anchors", expected="anchors (k, 3)", do="leave the height out in 2D")
    return sensing
