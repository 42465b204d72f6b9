"""What a layout of anchors can give at one height, before anything is flown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Anchors, Array
from robustnav.snapshot import (
    Dop,
    Height,
    Sensing,
    best_extra_anchor,
    dop_at,
    gdop_map,
    solve_differences,
    solve_ranges,
)
from robustnav.snapshot import Grid as Slice

POOR, BAD = 20.0, 50.0  # a filter still works; no single fix is to be believed
SAMPLED = 7  # points along each side where a fix is tried
REGION = 15  # points along each side for the place of one more anchor
PLACES = 7  # of one more anchor along each side
LARGEST = 250_000  # points of a map


class Box(NamedTuple):
    """Where the tag may be, level, in frame a: from ``x0`` to ``x1`` and from ``y0`` to ``y1`` [m]."""

    x0: float
    x1: float
    y0: float
    y1: float


@dataclass(frozen=True)
class Flight:
    """Where and how a tag is to be found.

    Parameters
    ----------
    z : of the tag in frame a [m], z down: minus its height.
    box : where it may be, or None: the anchors' own rectangle.
    grid : distance of the points [m].
    sd : of a range [m], for the fixes that are tried.
    sensing : ranges or differences, height known or not.
    """

    z: float
    box: Box | None
    grid: float
    sd: float
    sensing: Sensing

    def __post_init__(self) -> None:
        b = self.box
        if b is not None and not (np.isfinite(b).all() and b.x0 < b.x1 and b.y0 < b.y1):
            raise InputError("box", got=str(tuple(b)), expected="finite metres, x0 < x1 and y0 < y1")
        for name in ("grid", "sd"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise InputError(name, got=str(getattr(self, name)), expected="a finite number above 0 m")
        if not np.isfinite(self.z):
            raise InputError("height", got=str(-self.z), expected="a finite number of metres")


class Figures(NamedTuple):
    """Numbers over a map: ``median`` and ``worst`` (infinite where a point is blind), and the shares [0 to 1] beyond
    20 and 50 and not observable at all.
    """

    median: float
    worst: float
    beyond_20: float
    beyond_50: float
    blind: float


@dataclass(frozen=True)
class Plan:
    """How good a layout is.

    Parameters
    ----------
    x, y : (nx,), (ny,) m, the grid.
    dop, one_out : maps (ny, nx), and the worst with one anchor missing, None for a single anchor.
    verdicts : share of the fixes tried, with ranges that are exact, by the verdict they got.
    flatness : rms distance of the anchors from their best plane [m].
    extra : (3,) the place for one more anchor that lowers the mean GDOP most; ``extra_gdop`` before and with it, over
        the points that can be observed, and ``extra_blind`` shares of those that cannot.
    """

    x: Array
    y: Array
    dop: Dop
    one_out: Dop | None
    verdicts: dict[str, float]
    flatness: float
    extra: Array
    extra_gdop: tuple[float, float]
    extra_blind: tuple[float, float]


def plan_layout(anchors: Anchors, flight: Flight) -> Plan:
    """Return maps of the dilution of precision, verdicts of fixes, and where one more anchor helps most.

    Raises
    ------
    InputError : a box that no grid fits in, a map too large, or one anchor's rectangle without a box.
    """
    p = anchors.p_a
    box = flight.box or Box(*np.stack([p.min(axis=0), p.max(axis=0)], axis=1)[:2].ravel().tolist())
    if not (box.x0 < box.x1 and box.y0 < box.y1):
        raise InputError("box", got="anchors in a row", expected="a rectangle", do="give the box to fly in")
    x, y = _points(box.x0, box.x1, flight.grid), _points(box.y0, box.y1, flight.grid)
    if x.size * y.size > LARGEST:
        raise InputError("grid", got=f"{x.size * y.size} points", expected=f"{LARGEST} or fewer", do="widen the grid")
    level = Slice(x, y, flight.z)
    region = _region(box, REGION, flight.z)
    extra = best_extra_anchor(p, region, _candidates(box, anchors), flight.sensing)
    now = dop_at(p, region, flight.sensing).gdop
    return Plan(
        x=x,
        y=y,
        dop=gdop_map(p, level, flight.sensing),
        one_out=gdop_map(p, level, flight.sensing, one_out=True) if len(p) > 1 else None,
        verdicts=_verdicts(p, _region(box, SAMPLED, flight.z), flight),
        flatness=float(np.linalg.svd(p - p.mean(axis=0))[1][-1] / np.sqrt(len(p))) if len(p) > 3 else 0.0,
        extra=extra.position,
        extra_gdop=(extra.before, float(extra.scores[extra.row])),
        extra_blind=(float(np.mean(~np.isfinite(now))), float(extra.blind[extra.row] / len(region))),
    )


def figures_of(values: Array) -> Figures:
    """Return the numbers over a map."""
    return Figures(
        float(np.median(values)),
        float(values.max()),
        float(np.mean(values > POOR)),
        float(np.mean(values > BAD)),
        float(np.mean(~np.isfinite(values))),
    )


def _points(low: float, high: float, step: float) -> Array:
    return np.linspace(low, high, max(2, 1 + round((high - low) / step)))


def _region(box: Box, count: int, z: float) -> Array:
    """Return count^2 points inside the box: centres of equal cells, so that none lies on a symmetry by chance alone."""
    share = (np.arange(count) + 0.5) / count
    x, y = box.x0 + share * (box.x1 - box.x0), box.y0 + share * (box.y1 - box.y0)
    return np.column_stack([np.tile(x, count), np.repeat(y, count), np.full(count**2, z)])


def _candidates(box: Box, anchors: Anchors) -> Array:
    """Return places for one more anchor: over box and anchors, at the lowest and highest anchor and at z = 0."""
    low = np.minimum(anchors.p_a.min(axis=0)[:2], [box.x0, box.y0])
    high = np.maximum(anchors.p_a.max(axis=0)[:2], [box.x1, box.y1])
    x, y = np.linspace(low[0], high[0], PLACES), np.linspace(low[1], high[1], PLACES)
    heights = np.unique([*anchors.p_a[:, 2][[anchors.p_a[:, 2].argmin(), anchors.p_a[:, 2].argmax()]], 0.0])
    return np.array([[a, b, z] for z in heights for b in y for a in x])


def _verdicts(p: Array, points: Array, flight: Flight) -> dict[str, float]:
    """Return the share of each verdict over fixes from exact ranges to points (n, 3)."""
    height = Height(flight.z, flight.sd) if flight.sensing.height_known else None
    found: dict[str, int] = {}
    for point in points:
        r = np.linalg.norm(p - point, axis=1)
        if flight.sensing.kind == "differences":
            verdict = solve_differences(p, r[1:] - r[0], flight.sd, height).verdict
        else:
            verdict = solve_ranges(p, r, flight.sd, height).verdict
        found[verdict] = found.get(verdict, 0) + 1
    return {verdict: count / len(points) for verdict, count in sorted(found.items(), key=lambda one: -one[1])}
