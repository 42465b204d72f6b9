"""Attitude and position of a carrier from its inertial unit and ranges, started without a prior, at rest or moving."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import SensorSeen
from robustnav.errors import InputError
from robustnav.filter.steps import unpack
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.ranging import RangeDifferences
from robustnav.records import Log, Run, Stream
from robustnav.run.acquisition import BETTER, REFUSED_NIS, Events, lost_at, news_of, places, span, track_cost
from robustnav.run.estimators import EKF
from robustnav.run.feed import broken, deviations, events_of, feed_of, innovations_of, settings_of
from robustnav.run.hypotheses import SAID, Way
from robustnav.run.inertial_bank import Search, search
from robustnav.run.inertial_start import InertialStart, heading_starts
from robustnav.run.loop import Start
from robustnav.run.smoothing import smooth as smooth_log
from robustnav.run.tracking_task import RANGING, Plane, Readings, Source, TrackingTask, window_sd
from robustnav.snapshot.window import Minimum
from robustnav.units import DEG

_LIKELY = 0.01  # share of a heading that is named among those left


def run_inertial(
    estimator: EKF,
    readings: Readings | Sequence[Readings],
    log: Log,
    settings: InertialStart | None = None,
    *,
    smooth: bool = False,
    backend: str = "auto",
) -> Run:
    """Return attitude and position of a carrier from gyro, accelerometer and ranges or differences, without a prior.

    The tag's place comes from a short window of readings, the tilt from the median specific force.  The heading shows
    only when the carrier accelerates sideways or turns: filters with headings all round are followed, and the best one
    so far is reported with a covariance that reaches to the others.  When most readings of a window are far off and
    another place explains them much better, everything is started again.  The events say when and what.  Nothing looks
    ahead, unless ``smooth`` is asked for.  A start in a steep manoeuvre is linearised many degrees off: its standard
    deviations are then too small by up to a third for some ten seconds.

    Parameters
    ----------
    estimator : on a model of ``models.inertial``.
    readings : ranges, differences or both, of one tag, in the axes of their anchors, z down; their ``lever_b`` is
        where the tag sits on the body.
    log : streams ``gyro`` and ``accel`` of common times; others that the model knows are fused, ``heading`` or
        ``height`` say, from the start on.
    settings : how to start and restart; None: the defaults.
    smooth : smooth over the whole recording; a restart cuts it.
    backend : ``auto``, ``c``, ``float`` or ``numpy``.

    Returns
    -------
    Run : from the first position on, at the times of the inputs; innovations of all readings, with NaN before.

    Raises
    ------
    InputError : another model, readings of several tags, or as ``run``.
    EstimatorError : no window of readings tells a position, or no input comes before it.
    """
    settings = settings or InertialStart()
    task = _task(estimator, Source(readings, log), settings, backend)
    course = _Course(task, settings, [], [], _nothing_said(task))
    row, found = task.first_place()
    course.set_out(row, found[0], "started")
    while course.go_on():
        pass
    return _run(course, smooth=smooth)


@dataclass
class _Leg:
    """From a start at ``row`` to ``stop`` (exclusive): states and packed covariances of its rows, the chosen start."""

    row: int
    stop: int
    settled: int
    start: Start
    x: Array
    P: Array


@dataclass
class _Course:
    """What has been followed so far: legs, events in words, and what each sensor's readings said."""

    task: TrackingTask
    settings: InertialStart
    legs: list[_Leg]
    events: list[str]
    seen: list[SensorSeen | None]

    def set_out(self, row: int, found: Minimum, word: str) -> None:
        """Begin a leg at a place with headings all round, and follow the one that the readings choose."""
        task, t = self.task, self.task.feed.t
        starts = heading_starts(task, row, found, self.settings)
        tilt = np.sqrt(starts[0].P[0, 0]) / DEG
        size = np.sqrt(np.trace(found.P))
        self.events.append(f"{word} at {t[row]:.2f} s, sd {size:.2f} m and {tilt:.1f} deg of tilt, heading unknown")
        result = search(task, row, starts, self.settings.found_sd)
        self.events.append(_heading_words(t[result.end], result))
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
        self.legs.append(_Leg(row, len(t), result.end, result.start, np.vstack(x), np.vstack(P)))

    def go_on(self) -> bool:
        """Begin again where the last leg is lost; return whether it was."""
        lost = self._lost(self.legs[-1])
        if lost is not None:
            row, found = lost
            self.set_out(row, found, "lost and started again")
        return lost is not None

    def _hear(self, row: int, seen: Sequence[SensorSeen | None]) -> None:
        after = self.task.feed.t[row]
        for data, mine, new in zip(self.task.feed.sensors, self.seen, seen, strict=True):
            if data is None or mine is None or new is None:
                continue
            later = data.t > after
            for name in SAID:
                getattr(mine, name)[later] = getattr(new, name)[later]

    def _lost(self, leg: _Leg) -> tuple[int, Minimum] | None:
        """Return the next row at which the readings tell a place much better than the filter's, or None."""
        task, events, t, last = self.task, self.task.events, self.task.feed.t, -np.inf
        if not task.settings.restart:
            return None
        names = [s.name for s in task.estimator.model.sensors]
        ranging = [one for name in RANGING if (one := self.seen[names.index(name)]) is not None]
        nis = np.concatenate([one.nis for one in ranging])[task.order]
        off = np.nan_to_num(nis, nan=0.0) > REFUSED_NIS
        for k in lost_at(events, off, t[leg.settled], task.tau):
            row = int(np.searchsorted(t, events.t[k]))
            if events.t[k] - last < task.tau / 2 or row >= len(t) - 1:
                continue
            last = events.t[k]
            rows = events.between(max(last - task.tau, t[leg.row]), t[row])
            x = leg.x[row - leg.row]
            p = task.place(x)
            found = places(events, rows, task.settings, p, compiled=task.backend != "numpy")
            if found and found[0].cost < track_cost(events, rows, p, task.velocity(x)) - BETTER:
                return row, found[0]
        return None


def _heading_words(t: float, result: Search) -> str:
    best = int(np.argmax(result.shares))
    if result.found:
        return f"heading found at {t:.2f} s: {result.headings[best] / DEG:.0f} deg"
    left = sorted(round(h / DEG) for h, s in zip(result.headings, result.shares, strict=True) if s > _LIKELY)
    return f"heading not found by {t:.2f} s, left: {', '.join(f'{h}' for h in left)} deg"


def _task(estimator: EKF, source: Source, settings: InertialStart, backend: str) -> TrackingTask:
    model, log = estimator.model, source.log
    if not {"q_nb", "v_n", "p_n", "gyro_bias", "accel_bias"} <= set(model.state_slices) or log is None:
        raise InputError(f"model {model.name!r}", expected="a model of models.inertial", do="use run for other models")
    streams, parts, news = dict(log.streams), [], {}
    tables = source.tables()
    for one in tables:
        name = RANGING[isinstance(one, RangeDifferences)]
        if len(one.tags) > 1 or name in streams or not len(one):
            got = f"{len(one.tags)} tags, {len(one)} readings"
            raise InputError(f"{name} readings", got=got, expected="one table of a kind, of one tag, not empty")
        streams[name] = _stream(model, one, name)
        parts.append(Events.of(one, window_sd(model, name)))
        # errors that last are in the state, or else in the count of readings
        news[model.sensor_index(name)] = np.ones(len(one)) if "range_bias" in model.state_slices else news_of(one)
    if not parts:
        raise InputError("readings", got="none", expected="ranges or range differences")
    events = Events.joined(parts, None)
    order = np.argsort(np.concatenate([p.t for p in parts]), kind="stable")
    plane = Plane.of(np.unique(np.vstack([one.anchors.p_a for one in tables]), axis=0))
    whole, tau = replace(log, streams=streams), span(events, settings.acquisition)
    feed = feed_of(model, whole)
    return TrackingTask(estimator, whole, feed, events, order, settings.acquisition, tau, plane, news, backend)


def _stream(model: Model, readings: Readings, name: str) -> Stream:
    known = {k.name: k for k in model.sensors[model.sensor_index(name)].known}
    slots = known[f"{name}_slot"].size if f"{name}_slot" in known else 0
    return readings.stream(name, slots=slots, lever=True)


def _nothing_said(task: TrackingTask) -> list[SensorSeen | None]:
    rows = functions_of(task.estimator.model).rows
    return [SensorSeen.empty(len(d.t), m) if d else None for d, m in zip(task.feed.sensors, rows, strict=True)]


def _run(course: _Course, *, smooth: bool) -> Run:
    task, legs = course.task, course.legs
    model, feed, first = task.estimator.model, task.feed, legs[0].row
    parts = [(leg.x[: leg.stop - leg.row], leg.P[: leg.stop - leg.row]) for leg in legs]
    x, sd = np.vstack([x for x, _ in parts]), deviations(model, unpack(np.vstack([P for _, P in parts])))
    state = {name: x[:, part] for name, part in model.state_slices.items()}
    if smooth:
        runs = [_smoothed(task, leg) for leg in legs]
        state = {name: np.vstack([one.state[name] for one in runs]) for name in state}
        sd = {name: np.vstack([one.sd[name] for one in runs]) for name in sd}
    followed = replace(feed, t=feed.t[first + 1 :], u=feed.u[first + 1 :])
    words = (*course.events, *events_of(model, task.log, feed, 1.0), *broken(model, followed, course.seen))
    return Run(
        estimator=task.estimator.name + ("-rts" if smooth else ""),
        model=model.name,
        t=feed.t[first:],
        state=state,
        sd=sd,
        innovations=innovations_of(model, feed, course.seen),
        events=words,
        settings=settings_of(model, task.backend) | {"acquisition window [s]": task.tau},
    )


def _smoothed(task: TrackingTask, leg: _Leg) -> Run:
    """Smooth over one leg from the start that was chosen."""
    begin, end = task.feed.t[leg.row], task.feed.t[leg.stop - 1]
    inputs = {b.name for b in task.estimator.model.inputs}
    streams = {
        name: one.between(begin if name in inputs else np.nextafter(begin, np.inf), end)
        for name, one in task.log.streams.items()
    }
    return smooth_log(task.estimator, replace(task.log, streams=streams), leg.start, backend=task.backend)
