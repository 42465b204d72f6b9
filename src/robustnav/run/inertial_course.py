"""An inertial filter from start to start: a bank of headings, the one it chose, what it said, smoothed if wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robustnav.engine.filters import SensorSeen
from robustnav.filter.steps import unpack
from robustnav.frames import Array
from robustnav.records import Log, Run
from robustnav.run.feed import broken, deviations, events_of, innovations_of, settings_of
from robustnav.run.hypotheses import Way, hear
from robustnav.run.inertial_bank import Search, search
from robustnav.run.loop import Start
from robustnav.run.smoothing import smooth as smooth_log
from robustnav.run.task import Task
from robustnav.units import DEG

_FOUND = "heading found at"
_LIKELY = 0.01  # share of a heading that is named among those left
_MAX_GAP = 1.0  # a longer pause of the input [s] is named in the events


@dataclass
class InertialLeg:
    """From a start at ``row`` to ``stop`` (exclusive): states and packed covariances of its rows, the chosen start.

    From row ``settled`` on one filter was followed.
    """

    row: int
    stop: int
    settled: int
    start: Start
    x: Array
    P: Array


@dataclass
class InertialCourse:
    """What has been followed so far: legs, events in words, and what each sensor's readings said."""

    task: Task
    found_sd: float
    seen: list[SensorSeen | None]
    legs: list[InertialLeg] = field(default_factory=list)
    events: list[str] = field(default_factory=list)

    def set_out(self, row: int, starts: Sequence[Start], words: str) -> None:
        """Begin a leg with headings all round, and follow the one that the readings choose; ``words`` say why."""
        task, t = self.task, self.task.feed.t
        tilt = np.sqrt(starts[0].P[0, 0]) / DEG
        self.events.append(f"{words} and {tilt:.1f} deg of tilt, heading unknown")
        result = search(task, row, starts, self.found_sd)
        self.events.append(_heading_words(t, result))
        for begin, seen in result.pieces:
            self._hear(begin, seen)
        x, P = [result.x], [result.P]
        if result.end < len(t) - 1:
            way = Way.follow(task, result.end, result.last)
            self._hear(result.end, way.seen)
            x.append(way.x[1:])
            P.append(way.P[1:])
        if self.legs:
            self.legs[-1].stop = row
        self.legs.append(InertialLeg(row, len(t), result.end, result.start, np.vstack(x), np.vstack(P)))

    def _hear(self, row: int, seen: Sequence[SensorSeen | None]) -> None:
        feed = self.task.feed
        hear(self.seen, seen, [None if d is None else d.t for d in feed.sensors], feed.t[row])

    def report(self, log: Log, settings: dict[str, object], *, smooth: bool) -> Run:
        """Return the run from the first start on; ``log`` has a stream for each sensor that is owed one."""
        task, legs = self.task, self.legs
        model, feed, first = task.estimator.model, task.feed, legs[0].row
        parts = [(leg.x[: leg.stop - leg.row], leg.P[: leg.stop - leg.row]) for leg in legs]
        x, sd = np.vstack([x for x, _ in parts]), deviations(model, unpack(np.vstack([P for _, P in parts])))
        state = {name: x[:, part] for name, part in model.state_slices.items()}
        if smooth:
            runs = [_smoothed(task, leg) for leg in legs]
            state = {name: np.vstack([one.state[name] for one in runs]) for name in state}
            sd = {name: np.vstack([one.sd[name] for one in runs]) for name in sd}
        followed = replace(feed, t=feed.t[first + 1 :], u=feed.u[first + 1 :])
        words = (*self.events, *events_of(model, log, feed, _MAX_GAP), *broken(model, followed, self.seen))
        return Run(
            estimator=task.estimator.name + ("-rts" if smooth else ""),
            model=model.name,
            t=feed.t[first:],
            state=state,
            sd=sd,
            innovations=innovations_of(model, feed, self.seen),
            events=words,
            settings=settings_of(model, task.backend) | settings,
        )


def found_at(events: Sequence[str]) -> list[float]:
    """Return the times [s] at which a run's events say that the heading was found, one a start at most."""
    return [float(words.removeprefix(_FOUND).split()[0]) for words in events if words.startswith(_FOUND)]


def _heading_words(t: Array, result: Search) -> str:
    best = int(np.argmax(result.shares))
    if result.found is not None:
        return f"{_FOUND} {t[result.found]:.2f} s: {result.headings[best] / DEG:.0f} deg"
    left = sorted(round(h / DEG) for h, s in zip(result.headings, result.shares, strict=True) if s > _LIKELY)
    return f"heading not found by {t[result.end]:.2f} s, left: {', '.join(f'{h}' for h in left)} deg"


def _smoothed(task: Task, leg: InertialLeg) -> Run:
    """Smooth over one leg from the start that was chosen."""
    begin, end = task.feed.t[leg.row], task.feed.t[leg.stop - 1]
    inputs = {b.name for b in task.estimator.model.inputs}
    streams = {
        name: one.between(begin if name in inputs else np.nextafter(begin, np.inf), end)
        for name, one in task.log.streams.items()
    }
    return smooth_log(task.estimator, replace(task.log, streams=streams), leg.start, backend=task.backend)
