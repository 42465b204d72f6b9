"""What stays the same while a tag is followed: readings, settings, how a filter starts at a place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.filter.steps import unpack
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.ranging import RangeDifferences, Ranges
from robustnav.records import BoolArray, IntArray, Log, Stream
from robustnav.run.acquisition import Acquisition, Events, news_of, places, span
from robustnav.run.estimators import EKF, UKF
from robustnav.run.feed import Feed, feed_of
from robustnav.run.loop import Start
from robustnav.run.task import Task
from robustnav.snapshot.window import Minimum

Readings = Ranges | RangeDifferences
RANGING = ("range", "tdoa")  # sensors, in the order of the models
_HEIGHT_EVERY = 0.1  # s, between two assertions of a known height


@dataclass(frozen=True)
class Source:
    """What is given: ``readings`` of one tag, other streams in ``log``, and a known ``height`` [m], up, or None."""

    readings: Readings | Sequence[Readings]
    log: Log | None = None
    height: float | None = None

    def tables(self) -> list[Readings]:
        """Return the tables of readings, in the order of the models' sensors."""
        given = [self.readings] if isinstance(self.readings, Ranges | RangeDifferences) else list(self.readings)
        return sorted(given, key=lambda one: isinstance(one, RangeDifferences))


@dataclass(frozen=True)
class Plane:
    """The plane anchors come nearest to: a point on it (3,), its unit normal (3,), their rms distance from it [m]."""

    point: Array
    normal: Array
    spread: float

    @classmethod
    def of(cls, p_a: Array) -> Plane:
        """Return the plane of anchors (k, 3)."""
        point = p_a.mean(axis=0)
        values, vectors = np.linalg.svd(p_a - point)[1:]
        flat = len(values) < 3
        return cls(point, vectors[2], 0.0 if flat else float(values[2] / np.sqrt(len(p_a))))


@dataclass(frozen=True)
class TrackingTask(Task):
    """A task with ranges or differences of one tag.

    ``order`` sorts the sensors' readings, one sensor after the other, as ``events``; ``tau`` is the window of readings
    that are used together [s].
    """

    events: Events
    order: IntArray
    settings: Acquisition
    tau: float
    plane: Plane

    @classmethod
    def of(cls, estimator: EKF | UKF, source: Source, settings: Acquisition, backend: str) -> TrackingTask:
        """Put estimator, readings and log together.

        Raises
        ------
        InputError : readings of several tags, none at all, or a height in a plane.
        """
        model, tables = estimator.model, source.tables()
        log = source.log if source.log is not None else Log({}, "ranges")
        streams, parts, news = dict(log.streams), [], {}
        for one in tables:
            name = RANGING[isinstance(one, RangeDifferences)]
            if len(one.tags) > 1 or name in streams or not len(one):
                got = f"{len(one.tags)} tags, {len(one)} readings"
                raise InputError(f"{name} readings", got=got, expected="one table of a kind, of one tag, not empty")
            streams[name] = _stream(model, one, name)
            parts.append(Events.of(one, window_sd(model, name)))
            news[model.sensor_index(name)] = news_of(one)
        if not parts:
            raise InputError("readings", got="none", expected="ranges or range differences")
        events = Events.joined(parts, _down(model, source.height))
        if source.height is not None:
            at = np.arange(events.t[0], events.t[-1], _HEIGHT_EVERY)
            streams["height"] = Stream("height", at, np.full((len(at), 1), source.height), "m", "n")
        log = replace(log, streams=streams)
        longest = estimator.longest_step if isinstance(estimator, EKF) else np.inf
        return cls(
            estimator=estimator,
            log=log,
            feed=_with_pauses(feed_of(model, log), longest),
            news=news,
            backend=backend,
            events=events,
            order=np.argsort(np.concatenate([p.t for p in parts]), kind="stable"),
            settings=settings,
            tau=span(events, settings),
            plane=Plane.of(np.unique(np.vstack([one.anchors.p_a for one in tables]), axis=0)),
        )

    def first_place(self) -> tuple[int, list[Minimum]]:
        """Return the first row at which readings tell a position, and the places it may be.

        Raises
        ------
        EstimatorError : there is none.
        """
        events, begin, last = self.events, self.events.t[0], -np.inf
        for row, now in enumerate(self.feed.t):
            if now - begin < 0.8 * self.tau or now - last < self.tau / 2:
                continue
            last = now
            rows = events.between(max(now - self.settings.patience, begin - 1e-9), now)
            found = places(events, rows, self.settings, compiled=self.backend != "numpy")
            if found:
                return row, found
        raise EstimatorError(
            "no position to start from",
            place=self.log.source,
            got=f"{len(events.t)} readings of {events.anchors(slice(0, len(events.t)))} anchors",
            expected=f"{self.settings.patience:g} s of readings that fix it within {self.settings.limit_sd:g} m",
            do="look at the layout with: robustnav gdop",
        )

    def start(self, found: Minimum) -> Start:
        """Return the start at a place, not moving, with the doubt of a tag that may move."""
        model, speed = self.estimator.model, self.settings.speed
        part, fast = model.error_slices["p_n"], model.error_slices["v_n"]
        n = part.stop - part.start
        x = model.nominal_state()
        x[model.state_slices["p_n"]] = found.p[:n]
        P = model.start_covariance()
        P[part, part] = found.P[:n, :n] + (speed * self.tau / 2) ** 2 * np.eye(n)
        P[fast, fast] *= speed**2
        return Start(x, P)

    def mirrored(self, x: Array, P: Array) -> Start:
        """Return the mirror image of a state (nx,) and its packed covariance across the anchors' plane, in space."""
        normal = self.plane.normal
        turn, moved = np.eye(len(x)), x.copy()
        for name in ("p_n", "v_n"):
            part = self.estimator.model.state_slices[name]
            turn[part, part] -= 2 * np.outer(normal, normal)
        part = self.estimator.model.state_slices["p_n"]
        moved[part] -= self.plane.point
        moved = turn @ moved
        moved[part] += self.plane.point
        return Start(moved, turn @ unpack(P) @ turn.T)

    def sides(self, x: Array, P: Array) -> tuple[BoolArray, BoolArray]:
        """Return where states (n, nx) with covariances (n, ne, ne) may be on either side, and clearly are on one.

        Either side of the anchors' plane: it, and the anchors beside it, are within three standard deviations.  Clearly
        on one: a state and its mirror image are more than a standard deviation apart.
        """
        part = self.estimator.model.state_slices["p_n"]
        if self.events.down is not None or part.stop - part.start == 2:
            return np.zeros(len(x), bool), np.zeros(len(x), bool)
        height = (x[:, part] - self.plane.point) @ self.plane.normal
        doubt = 3 * np.sqrt(np.einsum("i,nij,j->n", self.plane.normal, P[:, part, part], self.plane.normal))
        either: BoolArray = (np.abs(height) < doubt) & (self.plane.spread < doubt)
        clearly: BoolArray = np.abs(height) > doubt / 6
        return either, clearly

    def place(self, x: Array) -> Array:
        """Return the position (3,) of a state."""
        p = x[self.estimator.model.state_slices["p_n"]]
        return p if self.events.down is None or len(p) == 3 else np.append(p, self.events.down[0])

    def velocity(self, x: Array) -> Array:
        """Return the velocity (3,) of a state."""
        v = x[self.estimator.model.state_slices["v_n"]]
        return np.append(v, np.zeros(3 - len(v)))


def _stream(model: Model, readings: Readings, name: str) -> Stream:
    known = {k.name: k for k in model.sensors[model.sensor_index(name)].known}
    slots = known[f"{name}_slot"].size if f"{name}_slot" in known else 0
    return readings.stream(name, slots=slots, lever=f"{name}_lever_b" in known)


def _with_pauses(feed: Feed, longest: float) -> Feed:
    """Return the feed of a model without inputs with rows in its pauses, where the filter divides a long step.

    A smoother then goes back over the steps that the filter made.
    """
    if feed.u.shape[1] or not np.isfinite(longest):
        return feed
    steps = np.diff(feed.t)
    parts = np.maximum(1, np.ceil(steps / longest)).astype(int)
    within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    t = np.append(np.repeat(feed.t[:-1], parts) + within * np.repeat(steps / parts, parts), feed.t[-1])
    return Feed(t, np.zeros((len(t), 0)), feed.sensors)


def window_sd(model: Model, sensor: str) -> float:
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
