"""Follow a tag through its ranges: started without a prior, restarted when it is lost, smoothed if wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import SensorSeen
from robustnav.engine.smoothing import smooth as smooth_rows
from robustnav.errors import EstimatorError, InputError
from robustnav.filter.steps import pack, unpack
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.ranging import RangeDifferences, Ranges
from robustnav.records import IntArray, Log, Run, Stream
from robustnav.run.acquisition import BETTER, REFUSED_NIS, RIVAL, Acquisition, Events, lost_at, places, span, track_cost
from robustnav.run.estimators import EKF, UKF
from robustnav.run.feed import Feed, broken, deviations, events_of, feed_of, innovations_of, settings_of
from robustnav.run.loop import Start, stream
from robustnav.snapshot.window import DEGREES_OF_FREEDOM, Minimum

Readings = Ranges | RangeDifferences
_HEIGHT_EVERY = 0.1  # s, between two assertions of a known height


def track(
    estimator: EKF | UKF,
    readings: Readings | Sequence[Readings],
    *,
    log: Log | None = None,
    height: float | None = None,
    acquisition: Acquisition | None = None,
    smooth: bool = False,
    backend: str = "auto",
    max_gap: float = 1.0,
) -> Run:
    """Return where a tag was, from its ranges or range differences, without a prior.

    A short window of readings gives the first position (``snapshot.window``).  Where a mirror image explains them as
    well, both are followed until the readings decide, and the likelier one is reported meanwhile.  When most readings
    of a window are far off, the window is asked again; a place that explains it much better restarts the filter.  All
    of this is in the events.  Nothing looks ahead, unless ``smooth`` is asked for.

    Parameters
    ----------
    estimator : on a model of ``models.uwb``.
    readings : ranges, differences, or both, of one tag, in the axes of their anchors, z down.
    log : other streams the model knows: ``accel_n`` of a driven model, ``position``, ``height``.
    height : a known height of the tag [m], up; asserted ten times a second with the sd of the model's sensor.
    acquisition : how to start and restart; None: the defaults.
    smooth : smooth over the whole recording (Rauch-Tung-Striebel); a restart cuts it.
    backend : ``auto``, ``c``, ``float`` or ``numpy``.
    max_gap : longer silence [s] is named in the events.

    Returns
    -------
    Run : from the first position on; innovations of all readings, with NaN before.

    Raises
    ------
    InputError : a model that follows no tag, readings of several tags, or a height in a plane.
    EstimatorError : no window of readings tells a position.
    """
    task = _Task.of(estimator, readings, log, height, acquisition or Acquisition(), backend)
    row, found = task.first_place()
    course = _Course.empty(task)
    while True:
        course.add(task, row, found)
        again = task.next_place(course, row)
        if again is None:
            break
        row, found = again
    return _run(task, course, smooth=smooth, max_gap=max_gap)


@dataclass(frozen=True)
class _Task:
    """What stays the same while a recording is followed."""

    estimator: EKF | UKF
    log: Log
    feed: Feed
    events: Events
    order: IntArray  # of the sensors' readings, one sensor after the other, as events
    down: tuple[float, float] | None
    settings: Acquisition
    tau: float
    backend: str

    @classmethod
    def of(
        cls,
        estimator: EKF | UKF,
        readings: Readings | Sequence[Readings],
        log: Log | None,
        height: float | None,
        settings: Acquisition,
        backend: str,
    ) -> _Task:
        """Put readings and log together."""
        model = estimator.model
        if not {"p_n", "v_n"} <= set(model.state_slices) or model.rotation is not None:
            raise InputError(f"model {model.name!r}", expected="a model of models.uwb", do="use run for other models")
        given = [readings] if isinstance(readings, Ranges | RangeDifferences) else list(readings)
        streams, parts = dict(log.streams) if log is not None else {}, []
        for one in sorted(given, key=lambda r: isinstance(r, RangeDifferences)):  # as the model's sensors
            name = "range" if isinstance(one, Ranges) else "tdoa"
            if len(one.tags) > 1 or name in streams or not len(one):
                got = f"{len(one.tags)} tags, {len(one)} readings"
                raise InputError(f"{name} readings", got=got, expected="one table of a kind, of one tag, not empty")
            slots = model.state_slices.get("range_bias", slice(0, 0))
            streams[name] = one.stream(name, slots=slots.stop - slots.start)
            parts.append(Events.of(one, _sd(model, name)))
        if not parts:
            raise InputError("readings", got="none", expected="ranges or range differences")
        events = Events.joined(parts)
        down = _down(model, height)
        if height is not None:
            at = np.arange(events.t[0], events.t[-1], _HEIGHT_EVERY)
            streams["height"] = Stream("height", at, np.full((len(at), 1), height), "m", "n")
        whole = replace(log, streams=streams) if log is not None else Log(streams, "ranges")
        order = np.argsort(np.concatenate([p.t for p in parts]), kind="stable")
        tau = span(events, settings)
        return cls(estimator, whole, feed_of(model, whole), events, order, down, settings, tau, backend)

    @property
    def dimensions(self) -> int:
        """Coordinates of the position."""
        part = self.estimator.model.state_slices["p_n"]
        return part.stop - part.start

    def first_place(self) -> tuple[int, list[Minimum]]:
        """Return the first row at which readings tell a position, and the places it may be."""
        events, begin, last = self.events, self.events.t[0], -np.inf
        for row, now in enumerate(self.feed.t):
            if now - begin < 0.8 * self.tau or now - last < self.tau / 2:
                continue
            last = now
            rows = events.between(max(now - self.settings.patience, begin - 1e-9), now)
            if rows.stop - rows.start < 8:
                continue
            found = places(events, rows, self.down, self.settings)
            if found:
                return row, found
        raise EstimatorError(
            "no position to start from",
            place=self.log.source,
            got=f"{len(events.t)} readings of {events.anchors(slice(0, len(events.t)))} anchors",
            expected=f"{self.settings.patience:g} s of readings that fix it within {self.settings.limit_sd:g} m",
            do="look at the layout with: robustnav gdop",
        )

    def next_place(self, course: _Course, since: int) -> tuple[int, list[Minimum]] | None:
        """Return the next row at which the filter is lost and readings tell a better place, or None."""
        if not self.settings.restart:
            return None
        events, t, last = self.events, self.feed.t, -np.inf
        nis = np.concatenate([one.nis for one in course.ranging(self)])[self.order]
        off = np.nan_to_num(nis, nan=0.0) > REFUSED_NIS
        for k in lost_at(events, off, t[max(since, course.decided)], self.tau):
            row = int(np.searchsorted(t, events.t[k]))
            if events.t[k] - last < self.tau / 2 or row >= len(t) or not np.isfinite(course.x[row]).all():
                continue
            last = events.t[k]
            rows = events.between(max(last - self.tau, t[since]), t[row])
            p, v = self.place(course.x[row]), self.velocity(course.x[row])
            found = places(events, rows, self.down, self.settings, near=p)
            if found and found[0].cost < track_cost(events, rows, self.down, p, v) - BETTER:
                moved = np.linalg.norm(found[0].p - p)
                course.events.append(
                    f"lost at {t[row]:.2f} s and found again {moved:.1f} m away, sd {_size(found[0]):.2f} m"
                )
                return row, found
        return None

    def place(self, x: Array) -> Array:
        """Return the position (3,) of a state."""
        p = x[self.estimator.model.state_slices["p_n"]]
        return p if self.down is None or len(p) == 3 else np.append(p, self.down[0])

    def velocity(self, x: Array) -> Array:
        """Return the velocity (3,) of a state."""
        v = x[self.estimator.model.state_slices["v_n"]]
        return np.append(v, np.zeros(3 - len(v)))

    def start(self, found: Minimum) -> Start:
        """Return the start at a place, not moving, with the doubt of a tag that may move."""
        model, speed, n = self.estimator.model, self.settings.speed, self.dimensions
        x = model.nominal_state()
        x[model.state_slices["p_n"]] = found.p[:n]
        P = model.start_covariance()
        part, fast = model.error_slices["p_n"], model.error_slices["v_n"]
        P[part, part] = found.P[:n, :n] + (speed * self.tau / 2) ** 2 * np.eye(n)
        P[fast, fast] *= speed**2
        return Start(x, P)


@dataclass
class _Course:
    """What has been followed so far; rows before the first place are NaN."""

    x: Array
    P: Array
    seen: list[SensorSeen | None]
    starts: list[int]
    events: list[str]
    decided: int = 0
    kept: tuple[Array, Array] | None = None  # of the winner of two hypotheses, for the smoother

    @classmethod
    def empty(cls, task: _Task) -> _Course:
        """Return room for a whole recording."""
        model, feed = task.estimator.model, task.feed
        n, ne = len(feed.t), model.error_size
        whole = task.estimator.name == "ukf"
        rows = [s.size if whole else r for s, r in zip(model.sensors, functions_of(model).rows, strict=True)]
        seen = [SensorSeen.empty(len(d.t), m) if d else None for d, m in zip(feed.sensors, rows, strict=True)]
        return cls(np.full((n, model.state_size), np.nan), np.full((n, ne * (ne + 1) // 2), np.nan), seen, [], [])

    def copy(self) -> _Course:
        """Return a copy that can go another way."""
        seen = [None if s is None else SensorSeen(*(a.copy() for a in (s.nu, s.s, s.nis, s.weight))) for s in self.seen]
        return _Course(self.x.copy(), self.P.copy(), seen, list(self.starts), list(self.events), self.decided)

    def ranging(self, task: _Task) -> list[SensorSeen]:
        """Return what the ranging sensors' readings said, in the model's order."""
        names = [s.name for s in task.estimator.model.sensors]
        return [one for name in ("range", "tdoa") if (one := self.seen[names.index(name)]) is not None]

    def add(self, task: _Task, row: int, found: list[Minimum]) -> None:
        """Follow from a row on to the end, from the likeliest place, and beside it from its rival if there is one."""
        if not self.starts:
            self.events.append(f"started at {task.feed.t[row]:.2f} s, sd {_size(found[0]):.2f} m")
        rivals = [m for m in found[1:] if m.cost - found[0].cost < RIVAL]
        before = self.copy() if rivals else None
        self._follow(task, row, found[0])
        self.starts.append(row)
        if before is not None:
            before._follow(task, row, rivals[0])
            self._decide(task, row, before, (found[0], rivals[0]))

    def _follow(self, task: _Task, row: int, found: Minimum) -> None:
        start, feed = task.start(found), task.feed
        self.x[row], self.P[row] = start.x, pack(start.P)
        running = stream(task.estimator, start, backend=task.backend)
        running.restore((start.x, pack(start.P), float(np.nextafter(feed.t[row], np.inf)), 0.0))
        output = running.run(feed.t[row + 1 :], feed.u[row + 1 :], feed.sensors)
        if output.P is None:
            raise EstimatorError("tracking", got="a filter without covariance", expected="an EKF or a UKF")
        self.x[row + 1 :], self.P[row + 1 :] = output.x, output.P
        for data, mine, new in zip(feed.sensors, self.seen, output.seen, strict=True):
            if data is None or mine is None or new is None:
                continue
            later = data.t > feed.t[row]
            for name in ("nu", "s", "nis", "weight"):
                getattr(mine, name)[later] = getattr(new, name)[later]

    def _decide(self, task: _Task, row: int, rival: _Course, places: tuple[Minimum, Minimum]) -> None:
        """Carry two hypotheses until the readings prefer one; report the likelier meanwhile, then the winner."""
        t = task.feed.t
        lead = rival._evidence(task, t[row]) - self._evidence(task, t[row]) + places[1].cost - places[0].cost
        clear = np.flatnonzero((np.abs(lead) >= RIVAL) & (np.arange(len(t)) > row))
        end = int(clear[0]) if clear.size else len(t) - 1
        other = np.arange(len(t)) >= row
        ahead = np.where(np.arange(len(t)) < end, lead < 0, lead[end] < 0) & other  # where the rival leads
        mirror = ", ".join(f"{v:.2f}" for v in places[1].p)
        words = f"settled at {t[end]:.2f} s" if clear.size else "never settled"
        self.events.append(f"two places fit at {t[row]:.2f} s, the other ({mirror}) m: {words}")
        if lead[end] < 0:
            self.seen = rival.seen
            self.kept = (rival.x, rival.P)
        else:
            self.kept = (self.x.copy(), self.P.copy())
        self.x[ahead], self.P[ahead] = rival.x[ahead], rival.P[ahead]
        self.decided = end

    def _evidence(self, task: _Task, since: float) -> Array:
        """Return the cost of the readings since a time, summed up to each row (n,)."""
        t = task.feed.t
        out = np.zeros(len(t))
        for name, one in zip(("range", "tdoa"), self.seen, strict=False):
            data = task.feed.sensors[task.estimator.model.sensor_index(name)]
            if one is None or data is None:
                continue
            nu = DEGREES_OF_FREEDOM
            cost = 0.5 * (nu + 1) * np.log1p(one.nis / nu) + 0.5 * np.log(one.s).sum(axis=1)
            use = (data.t > since) & np.isfinite(cost)
            rows = np.searchsorted(t, data.t[use])
            np.add.at(out, rows[rows < len(t)], cost[use][rows < len(t)])
        total: Array = np.cumsum(out)
        return total


def _run(task: _Task, course: _Course, *, smooth: bool, max_gap: float) -> Run:
    model, feed = task.estimator.model, task.feed
    first = course.starts[0]
    x, P = course.x, course.P
    if smooth:
        if course.kept is not None and len(course.starts) == 1:
            x, P = course.kept
        breaks = [s - first for s in course.starts[1:]]
        functions = functions_of(model, task.backend)
        x, P = smooth_rows(functions, feed.t[first:], feed.u[first:], x[first:], P[first:], breaks)
    else:
        x, P = x[first:], P[first:]
    gaps = np.flatnonzero(np.diff(task.events.t) > max_gap)[:20]
    silence = [f"no ranges from {task.events.t[k]:.2f} to {task.events.t[k + 1]:.2f} s" for k in gaps]
    followed = replace(feed, t=feed.t[first + 1 :], u=feed.u[first + 1 :])
    words = (*course.events, *silence, *events_of(model, _heard(task), feed, np.inf))
    words += broken(model, followed, course.seen)
    return Run(
        estimator=task.estimator.name + ("-rts" if smooth else ""),
        model=model.name,
        t=feed.t[first:],
        state={name: x[:, part] for name, part in model.state_slices.items()},
        sd=deviations(model, unpack(P)),
        innovations=innovations_of(model, feed, course.seen),
        events=words,
        settings=settings_of(model, task.backend) | {"acquisition window [s]": task.tau},
    )


def _heard(task: _Task) -> Log:
    """Return the log with an empty stream for each sensor it does not have: a tag needs only one of them."""
    model = task.estimator.model
    none = {s.name: Stream(s.name, np.zeros(0), np.zeros((0, s.width)), s.unit, "a") for s in model.sensors}
    return replace(task.log, streams={**none, **task.log.streams})


def _sd(model: Model, sensor: str) -> float:
    """Return the sd of a reading that a window should reckon with: white noise and what biases add to it [m]."""
    bias = float(np.max(model.start_sd.get("range_bias", 0.0)))
    return float(np.hypot(model.sensors[model.sensor_index(sensor)].sd, bias))


def _down(model: Model, height: float | None) -> tuple[float, float] | None:
    if "tag_down" in model.parameters:
        if height is not None:
            raise InputError("height", got=f"{height} m", expected="none in a plane", do="give the model tag_down")
        return model.parameters["tag_down"], 0.0
    if height is None:
        return None
    return -height, model.sensors[model.sensor_index("height")].sd


def _size(found: Minimum) -> float:
    return float(np.sqrt(np.trace(found.P)))
