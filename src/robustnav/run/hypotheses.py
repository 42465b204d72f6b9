"""One or two hypotheses of where a tag is, followed side by side until the readings prefer one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import SensorSeen
from robustnav.engine.smoothing import smooth
from robustnav.errors import EstimatorError
from robustnav.filter.steps import pack, unpack
from robustnav.frames import Array
from robustnav.records import BoolArray
from robustnav.run.loop import Start, stream
from robustnav.run.task import Task
from robustnav.run.tracking_task import TrackingTask
from robustnav.snapshot.window import DEGREES_OF_FREEDOM

SAID = tuple(field.name for field in fields(SensorSeen))
MERGED = 0.3  # standard deviations between two ways that are one
SETTLED = 4.5  # difference of costs at which one hypothesis is taken for true: chi-square difference of 9
FORETOLD = 16.3  # squared distance in standard deviations, 99.9 % of three coordinates
CLEARLY = 0.5  # the second hypothesis is shown only while it is ahead by this much


@dataclass(frozen=True)
class Way:
    """A filter from a row on: states ``x`` (m, nx) and packed covariances ``P``, what each sensor's readings said."""

    x: Array
    P: Array
    seen: tuple[SensorSeen | None, ...]

    @classmethod
    def follow(cls, task: Task, row: int, start: Start) -> Way:
        """Run the filter from a start at ``row`` to the end; readings up to there are taken as used."""
        feed, P0 = task.feed, pack(start.P)
        running = stream(task.estimator, start, backend=task.backend)
        running.restore((start.x, P0, float(np.nextafter(feed.t[row], np.inf)), 0.0))
        output = running.run(feed.t[row + 1 :], feed.u[row + 1 :], feed.sensors)
        if output.P is None:
            raise EstimatorError("tracking", got="a filter without covariance", expected="an EKF or a UKF")
        return cls(np.vstack([start.x, output.x]), np.vstack([P0, output.P]), output.seen)


@dataclass
class Leg:
    """From one start to the next, rows ``row`` to ``stop`` (exclusive), on one way or two.

    ``lead`` (m,) is by how much the first way's readings cost less than the second's; at row ``end`` it is settled,
    ``end == n`` if never; ``merged`` says that the two ways came together there.  ``continues`` says that the first way
    goes on where the last leg led, ``second_look`` that it began away from the anchors' plane, after two ways met.
    """

    row: int
    stop: int
    ways: tuple[Way, ...]
    lead: Array
    end: int
    continues: bool = False
    merged: bool = False
    second_look: bool = False

    @classmethod
    def begin(
        cls, task: TrackingTask, row: int, starts: Sequence[Start], handicap: float, *, continues: bool = False
    ) -> Leg:
        """Follow one start or two; the second one's place cost ``handicap`` more."""
        n = len(task.feed.t)
        ways = tuple(Way.follow(task, row, one) for one in starts)
        if len(ways) == 1:
            return cls(row, n, ways, np.full(n - row, np.inf), row, continues)
        lead = evidence(task, row, ways[1]) - evidence(task, row, ways[0]) + handicap
        same = _same(task, *ways)
        clear = np.flatnonzero((np.abs(lead) >= SETTLED)[1:] | same[1:]) + 1
        end = row + int(clear[0]) if clear.size else n
        lead[end - row :] = np.inf if end < n and (same[end - row] or lead[end - row] > 0) else -np.inf
        return cls(row, n, ways, lead, end, continues, merged=end < n and bool(same[end - row]))

    @property
    def settled(self) -> bool:
        """Whether one way was taken for true before the next start."""
        return self.end < self.stop

    def second(self) -> BoolArray:
        """Return where (m,) the second way leads."""
        return self.lead < -CLEARLY

    def at(self, row: int) -> list[Array]:
        """Return the states (nx,) that are possible at a row, the one shown first."""
        k = row - self.row
        if len(self.ways) == 1:
            return [self.ways[0].x[k]]
        first = int(self.second()[k])
        both = [self.ways[first].x[k], self.ways[1 - first].x[k]]
        return both if row < self.end else both[:1]

    def way(self, which: int) -> tuple[Array, Array]:
        """Return states and packed covariances of one way up to the next start."""
        m, one = self.stop - self.row, self.ways[which]
        return one.x[:m], one.P[:m]

    def shown(self, rows: slice) -> tuple[Array, Array]:
        """Return states and packed covariances of the way that leads, at rows counted from the leg's own."""
        one = self.ways[0]
        if len(self.ways) == 1:
            return one.x[rows], one.P[rows]
        two, second = self.ways[1], self.second()[rows, None]
        return np.where(second, two.x[rows], one.x[rows]), np.where(second, two.P[rows], one.P[rows])

    def reported(self) -> tuple[Array, Array]:
        """Return states (k, nx) and packed covariances of the leg; the doubt between two ways is in the covariance."""
        whole = slice(0, self.stop - self.row)
        x, P = self.shown(whole)
        if len(self.ways) == 1:
            return x, P
        share = 1 / (1 + np.exp(np.clip(self.lead[whole], -700, 700)))
        return x, mixed((x, P), self.way(0), self.way(1), share)

    def said(self, t: Array, times: Sequence[Array | None]) -> tuple[SensorSeen | None, ...]:
        """Return what the readings, stamped ``times``, said to the way that leads; ``t`` (n,) the rows' times [s]."""
        if len(self.ways) == 1:
            return self.ways[0].seen
        out: list[SensorSeen | None] = []
        for one, two, at in zip(self.ways[0].seen, self.ways[1].seen, times, strict=True):
            if one is None or two is None or at is None:
                out.append(None)
                continue
            rows = np.clip(np.searchsorted(t, at) - self.row, 0, len(self.lead) - 1)
            s = self.second()[rows]
            arrays = [(getattr(one, name), getattr(two, name)) for name in SAID]
            out.append(SensorSeen(*(np.where(s if a.ndim == 1 else s[:, None], b, a) for a, b in arrays)))
        return tuple(out)


def mixed(shown: tuple[Array, Array], one: tuple[Array, Array], two: tuple[Array, Array], share: Array) -> Array:
    """Return packed covariances about the states ``shown`` of a mixture, ``share`` (m,) of which is the second."""
    out = shown[1].copy()
    rows = np.flatnonzero((share > 0) & (share < 1))
    total = np.zeros((len(rows), shown[0].shape[1], shown[0].shape[1]))
    for (x, P), weight in ((one, 1 - share), (two, share)):
        d = x[rows] - shown[0][rows]
        total += weight[rows, None, None] * (unpack(P[rows]) + d[:, :, None] * d[:, None, :])
    if rows.size:
        out[rows] = np.array([pack(P) for P in total])
    return out


def smoothed(task: TrackingTask, legs: Sequence[Leg]) -> tuple[Array, Array]:
    """Return smoothed states and packed covariances of all legs.

    A new start cuts, unless the old way had said that it might be there: after a silence, the path between is then
    told by both ends.  A leg that continues does not cut.
    """
    begun = {leg.row for leg in legs if not leg.continues}
    legs = [leg for leg in legs if leg.stop > leg.row]  # one that went on where it began says nothing itself
    feed, first = task.feed, legs[0].row
    functions = functions_of(task.estimator.model, task.backend)
    chosen = [int(leg.second()[leg.stop - leg.row - 1]) for leg in legs]
    parts = [leg.way(c) for leg, c in zip(legs, chosen, strict=True)]
    breaks = [leg.row - first for leg, c in zip(legs, chosen, strict=True) if leg.row in begun or c == 1][1:]
    stacked = np.vstack([x for x, _ in parts]), np.vstack([P for _, P in parts])
    for start in breaks.copy():
        own = _foretold(task, first, start, stacked, task.tau if start + first in begun else 0.0)
        breaks = [b for b in breaks if not own < b <= start]
    x, P = smooth(functions, feed.t[first:], feed.u[first:], *stacked, breaks)
    for leg, c in zip(legs, chosen, strict=True):
        if len(leg.ways) == 1 or leg.settled:
            continue
        rows, at = slice(leg.row - first, leg.stop - first), slice(leg.row, leg.stop)
        rival = smooth(functions, feed.t[at], feed.u[at], *leg.way(1 - c))
        shown = x[rows], P[rows]
        share = 1 / (1 + np.exp(abs(leg.lead[leg.stop - leg.row - 1])))
        P[rows] = mixed(shown, shown, rival, np.full(leg.stop - leg.row, share))
    return x, P


def _foretold(task: TrackingTask, first: int, start: int, whole: tuple[Array, Array], since: float) -> int:
    """Return the row from which a filter could foretell where it was started anew at ``start``, else ``start``.

    ``whole``: states and packed covariances from row ``first`` on.  What the readings of the last ``since`` seconds,
    which found the new place, had done to the old way is undone, if so: it is carried on without them.
    """
    functions, feed = functions_of(task.estimator.model, task.backend), task.feed
    t = feed.t[first:]
    own = int(np.searchsorted(t, t[start] - since)) - 1
    if own < 0:
        return start
    x, P = whole[0][own], unpack(whole[1][own])
    states, covariances = [], []
    for k in range(own + 1, start + 1):
        F, Q = functions.transition(x, feed.u[first + k], t[k] - t[k - 1])
        x, P = functions.propagate(x, feed.u[first + k], t[k] - t[k - 1]), F @ P @ F.T + Q
        states.append(x)
        covariances.append(pack(P))
    part = task.estimator.model.error_slices["p_n"]
    off = whole[0][start, part] - x[part]
    both = P[part, part] + unpack(whole[1][start])[part, part]
    if not off @ np.linalg.solve(both, off) < FORETOLD:
        return start
    for k, (state, covariance) in enumerate(zip(states[:-1], covariances[:-1], strict=True), own + 1):
        whole[0][k], whole[1][k] = state, covariance
    return own


def _same(task: Task, one: Way, two: Way) -> BoolArray:
    """Return where (m,) two ways have come together."""
    slices, sd = task.estimator.model.error_slices, np.sqrt(np.diagonal(unpack(one.P), axis1=-2, axis2=-1))
    near = [
        np.linalg.norm((two.x - one.x)[:, p], axis=1) < MERGED * sd[:, p].min(axis=1)
        for p in (slices["p_n"], slices["v_n"])
    ]
    out: BoolArray = near[0] & near[1]
    return out


def hear(
    seen: Sequence[SensorSeen | None],
    new: Sequence[SensorSeen | None],
    times: Sequence[Array | None],
    after: float,
) -> None:
    """Write into ``seen`` what readings, stamped ``times``, said later than ``after`` [s]."""
    for at, mine, one in zip(times, seen, new, strict=True):
        if at is None or mine is None or one is None:
            continue
        later = at > after
        for name in SAID:
            getattr(mine, name)[later] = getattr(one, name)[later]


def evidence(task: Task, row: int, way: Way) -> Array:
    """Return the cost of the readings behind a row for a way, summed up to each of its rows (m,)."""
    t = task.feed.t[row:]
    out = np.zeros(len(t))
    for j, share in task.news.items():
        one, data = way.seen[j], task.feed.sensors[j]
        if one is None or data is None:
            continue
        nu = DEGREES_OF_FREEDOM
        cost = 0.5 * (nu + one.s.shape[1]) * np.log1p(one.nis / nu) + 0.5 * np.log(one.s).sum(axis=1)
        cost = cost * share
        use = (data.t > t[0]) & (data.t <= t[-1]) & np.isfinite(cost)
        np.add.at(out, np.searchsorted(t, data.t[use]), cost[use])
    total: Array = np.cumsum(out)
    return total
