"""Where a tag is without having been told: from a short window of its readings, and when to ask again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.engine import snapshot_window
from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.ranging import RangeDifferences, Ranges
from robustnav.records import BoolArray, IntArray
from robustnav.snapshot.window import Minimum, WindowReadings, robust_cost, robust_minima

REFUSED_NIS = 8.8  # a reading with its stated noise exceeds it in 0.3 %: off, whatever rule weighs it
RIVAL = 4.5  # a minimum whose cost an anchor is within this of the lowest: chi-square difference of 9
SILENCE = 4.0  # windows without a reading after which a filter's place is looked at again
LASTING = 3.0  # s, for which the error of a range lasts: readings of an anchor within it repeat each other
BETTER = 10.0  # what a new place must gain in cost over the track


@dataclass(frozen=True)
class Acquisition:
    """How a filter is started, and restarted when it has lost the tag.

    Parameters
    ----------
    window : readings this young are used together [s]; longer where they come slowly.
    patience : a start waits this long for readings that tell the position [s], then takes what slides by.
    speed : typical speed of the tag [m/s]: it may move this fast through the window, and starts with this doubt.
    limit_sd : a place with a larger standard deviation, all axes together [m], is none.
    box : corners (2, 3) [m] outside of which nothing is believed, or None.
    restart : whether a lost filter is started again.

    Raises
    ------
    InputError : a number that is not positive, or a box turned inside out.
    """

    window: float = 0.5
    patience: float = 3.0
    speed: float = 1.0
    limit_sd: float = 5.0
    box: Array | None = None
    restart: bool = True

    def __post_init__(self) -> None:
        for name in ("window", "patience", "speed", "limit_sd"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"acquisition {name}", got=str(value), expected="a number above zero")
        if self.box is not None:
            box = np.asarray(self.box, float)
            if box.shape != (2, 3) or not (box[0] < box[1]).all():
                raise InputError("acquisition box", got=str(self.box), expected="lowest and highest corner, (2, 3)")
            object.__setattr__(self, "box", box)


@dataclass(frozen=True)
class Events:
    """Ranging readings of all kinds in time order: columns of ``WindowReadings`` with stamps ``t`` (n,) [s].

    ``down`` is the third coordinate of the tag and its sd [m], or None.
    """

    t: Array
    value: Array
    first: Array
    second: Array
    pairs: BoolArray
    sd: Array
    down: tuple[float, float] | None = None

    @classmethod
    def of(cls, readings: Ranges | RangeDifferences, sd: float) -> Events:
        """Return ranges or differences as events, with their standard deviation [m]."""
        p_a = readings.anchors.p_a
        n = len(readings.t)
        if isinstance(readings, Ranges):
            first = second = p_a[readings.anchor]
            return cls(readings.t, readings.distance, first, second, np.zeros(n, bool), np.full(n, sd))
        first, second = p_a[readings.first], p_a[readings.second]
        return cls(readings.t, readings.difference, first, second, np.ones(n, bool), np.full(n, sd))

    @classmethod
    def joined(cls, parts: list[Events], down: tuple[float, float] | None) -> Events:
        """Return all parts in time order, with what is known of the third coordinate."""
        t = np.concatenate([p.t for p in parts])
        order = np.argsort(t, kind="stable")
        columns = [np.concatenate([getattr(p, name) for p in parts])[order] for name in ("value", "first", "second")]
        pairs, sd = np.concatenate([p.pairs for p in parts]), np.concatenate([p.sd for p in parts])
        return cls(t[order], columns[0], columns[1], columns[2], pairs[order], sd[order], down)

    def between(self, begin: float, end: float) -> slice:
        """Return the rows with begin < t <= end."""
        first, stop = np.searchsorted(self.t, [begin, end], side="right")
        return slice(int(first), int(stop))

    def window(self, rows: slice) -> WindowReadings:
        """Return some rows for the solver."""
        place, sd = self.down if self.down is not None else (None, 0.0)
        ends = self.first[rows], self.second[rows]
        return WindowReadings(self.value[rows], *ends, self.pairs[rows], self.sd[rows], place, sd)

    def anchors(self, rows: slice) -> int:
        """Return how many anchors some rows come from."""
        ends = np.vstack([self.first[rows], self.second[rows]])
        return len(np.unique(ends, axis=0))


def places(
    events: Events, rows: slice, settings: Acquisition, near: Array | None = None, *, compiled: bool = True
) -> list[Minimum]:
    """Return where the tag may be by some rows of events, the likeliest first: minima that pass box and limit.

    ``near`` (3,) is tried as a start too; ``compiled`` solves in the kernel where the rows fit into it.
    """
    readings = events.window(rows)
    least = 4 if readings.pairs.any() else 3
    count = events.anchors(rows)
    if count < least or len(readings.value) < 8:
        return []
    fits = len(readings.value) <= snapshot_window.MAX_READINGS and count <= snapshot_window.MAX_ANCHORS
    search = snapshot_window.robust_minima if compiled and fits else robust_minima
    found = search(readings, None if near is None else near[None])
    if settings.box is not None:
        low, high = settings.box
        found = [m for m in found if (m.p >= low).all() and (m.p <= high).all()]
    if not found or np.sqrt(np.trace(found[0].P)) > settings.limit_sd:
        return []
    return found


def rivals(events: Events, rows: slice, found: list[Minimum]) -> list[Minimum]:
    """Return the places beside the likeliest that some rows do not rule out, with costs as if each anchor spoke once.

    Errors of ranges last longer than a window, so many readings of one anchor weigh little more than one.
    """
    share = events.anchors(rows) / (rows.stop - rows.start)
    return [
        m._replace(cost=share * (m.cost - found[0].cost)) for m in found[1:] if share * (m.cost - found[0].cost) < RIVAL
    ]


def news_of(readings: Ranges | RangeDifferences) -> Array:
    """Return what share (n,) of each reading is news: how long its anchors were silent, of the time an error lasts."""
    ends = [readings.anchor] if isinstance(readings, Ranges) else [readings.first, readings.second]
    key = np.stack(ends, axis=1)
    order = np.lexsort((np.arange(len(key)), *key.T))
    again = (np.diff(key[order], axis=0) == 0).all(axis=1)
    silent = np.full(len(key), np.inf)
    silent[order[1:]] = np.where(again, np.diff(readings.t[order]), np.inf)
    return np.minimum(silent / LASTING, 1.0)


def track_cost(events: Events, rows: slice, p: Array, v: Array) -> float:
    """Return the cost of some rows for a track that is at ``p`` (3,) with ``v`` (3,) at the last of them."""
    readings = events.window(rows)
    at = p + v * (events.t[rows] - events.t[rows.stop - 1])[:, None]
    return float(robust_cost(readings, at))


def span(events: Events, settings: Acquisition) -> float:
    """Return the window [s] for the rate at which readings come: about a dozen of them, at most the patience.

    The rate is that of the readings up to the first time that lies a window behind the beginning.
    """
    t, counts = np.unique(events.t[events.t <= events.t[0] + settings.patience], return_counts=True)
    k = 1 if len(t) > 1 else 0
    while k and k < len(t):
        needed = 12.0 * float(np.median(np.diff(t[: k + 1]))) / float(np.mean(counts[: k + 1]))
        tau = min(max(settings.window, needed), settings.patience)
        reached = int(np.searchsorted(t, t[0] + 0.8 * tau))
        if reached <= k:
            return tau
        k = reached
    return settings.patience


def lost_at(events: Events, off: BoolArray, since: float, tau: float) -> IntArray:
    """Return the rows at which a filter may be lost: most readings of the last ``tau`` seconds were off.

    Also those a little after a long silence: linearised far from where the tag is, a filter may settle elsewhere.

    Parameters
    ----------
    events : all readings.
    off : (n,) whether each was off.
    since : the filter's start [s]; earlier readings do not count.
    tau : the window [s].
    """
    last = np.arange(len(events.t))
    begin = np.searchsorted(events.t, np.maximum(events.t - tau, since), side="right")
    sums = np.concatenate([[0], np.cumsum(off)])
    total, refused = last + 1 - begin, sums[last + 1] - sums[begin]
    whole = events.t - events.t[np.minimum(begin, last)] >= 0.8 * tau
    some = (total >= 8) & (events.t > since)
    returned = events.t[1:][np.diff(events.t) > SILENCE * tau]
    back = (
        events.t - returned[np.maximum(np.searchsorted(returned, events.t, side="right") - 1, 0)]
        if len(returned)
        else -1
    )
    fresh = (back >= tau) & (back <= 2 * tau)
    candidates: IntArray = np.flatnonzero(some & ((off & whole & (2 * refused >= total)) | fresh))
    return candidates
