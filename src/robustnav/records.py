"""What travels between the stages: sensor streams, logs, reference truth, estimates and scores.

Arrays only; pandas appears nowhere here.  All records are frozen and checked when they are made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from robustnav.errors import InputError

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


def check_time(t: Array, thing: str) -> None:
    """Raise ``InputError`` unless ``t`` (n,) is finite and never decreases; the message names the row."""
    if t.ndim != 1:
        raise InputError(f"time of {thing}", got=f"shape {t.shape}", expected="shape (n,)")
    bad = np.flatnonzero(~np.isfinite(t))
    if bad.size:
        raise InputError(
            f"time of {thing}",
            place=f"row {bad[0]}",
            got=str(t[bad[0]]),
            expected="a finite number of seconds",
        )
    back = np.flatnonzero(np.diff(t) < 0)
    if back.size:
        k = int(back[0]) + 1
        raise InputError(
            f"time goes backwards in {thing}",
            place=f"row {k}",
            got=f"{t[k]:.6f} s after {t[k - 1]:.6f} s",
            expected="times that never decrease",
            do="sort or cut the recording, or drop the stream",
        )


def check_names(names: tuple[str, ...], thing: str) -> None:
    """Raise ``InputError`` unless there are names, all of them printable, not empty and different."""
    wrong = [name for name in names if not name or not name.isprintable() or name != name.strip()]
    twice = [name for name in names if names.count(name) > 1]
    if not names or wrong or twice:
        got = f"{twice[0]!r} twice" if twice and not wrong else repr(wrong[0]) if wrong else "none"
        raise InputError(f"names of {thing}", got=got, expected="different printable names, one at least")


@dataclass(frozen=True)
class Stream:
    """Samples of one sensor in time order.

    Parameters
    ----------
    name : sensor name as the models use it: ``gyro``, ``accel``, ``mag``, ...
    t : (n,) seconds since the log's start, never decreasing.
    values : (n, m) readings in ``unit``; NaN marks a missing number.
    unit : SI unit, e.g. ``rad/s``, ``m/s^2``, ``T``.
    frame : frame of the values, ``b`` for body axes (forward-right-down).

    Raises
    ------
    InputError : shapes differ, a time is not finite or goes backwards, a value is infinite.
    """

    name: str
    t: Array
    values: Array
    unit: str
    frame: str = "b"

    def __post_init__(self) -> None:
        object.__setattr__(self, "t", np.ascontiguousarray(self.t, float))
        object.__setattr__(self, "values", np.ascontiguousarray(self.values, float))
        if self.values.ndim != 2 or len(self.values) != len(self.t):
            raise InputError(
                f"stream {self.name!r}",
                got=f"values of shape {self.values.shape}",
                expected=f"shape ({len(self.t)}, m)",
            )
        check_time(self.t, f"stream {self.name!r}")
        bad = np.flatnonzero(np.isinf(self.values).any(axis=1))
        if bad.size:
            raise InputError(
                f"stream {self.name!r}",
                place=f"row {bad[0]}",
                got=str(self.values[bad[0]]),
                expected="finite numbers, or NaN where a reading is missing",
            )

    def __len__(self) -> int:
        return len(self.t)

    @property
    def rate_hz(self) -> float:
        """Mean sample rate (n - 1) / (last - first) [Hz]; NaN with fewer than two distinct times."""
        span = float(self.t[-1] - self.t[0]) if len(self.t) > 1 else 0.0
        return (len(self.t) - 1) / span if span > 0 else float("nan")

    def between(self, start: float, stop: float) -> Stream:
        """Return the samples with ``start <= t <= stop`` [s], times unchanged."""
        keep = slice(int(np.searchsorted(self.t, start)), int(np.searchsorted(self.t, stop, side="right")))
        return Stream(self.name, self.t[keep], self.values[keep], self.unit, self.frame)


@dataclass(frozen=True)
class Truth:
    """Reference states, or another estimator's states, with their own times.

    Parameters
    ----------
    t : (n,) seconds since the log's start.
    q_nb : (n, 4) attitude, Hamilton, w first, body FRD to NED; NaN rows where the reference is missing.
    kind : ``optical``, ``simulated`` ... for a reference; ``estimate`` for another estimator's output, which is
        never scored as truth without saying so.
    north : ``magnetic`` or ``true``: which north the attitude refers to.
    p_n, v_n : (n, 3) position [m] and velocity [m/s] in NED, or None.
    moving : (n,) which samples count in a metric over motion, or None.
    accuracy : one line on how good it is, for reports.
    """

    t: Array
    q_nb: Array | None = None
    kind: str = "simulated"
    north: str = "magnetic"
    p_n: Array | None = None
    v_n: Array | None = None
    moving: BoolArray | None = None
    accuracy: str = ""

    def __post_init__(self) -> None:
        check_time(self.t, "truth")
        for name, width in (("q_nb", 4), ("p_n", 3), ("v_n", 3)):
            value = getattr(self, name)
            if value is not None and value.shape != (len(self.t), width):
                raise InputError(
                    f"truth {name}", got=f"shape {value.shape}", expected=f"shape ({len(self.t)}, {width})"
                )


@dataclass(frozen=True)
class Log:
    """Named streams of one recording in SI units, body FRD.

    Parameters
    ----------
    streams : by sensor name; each has its own times.
    source : file name or what made it.
    conventions : what the source used and what was converted, one line each.
    origin_ns : the log's start on its own clock [ns].
    truth : reference attitude or position, or None.
    estimate : the recorder's own estimate (an autopilot's attitude); not a truth.
    skipped : what was left out and why, one line each.
    info : figures and settings worth showing: firmware, declination_deg, latitude_deg, longitude_deg, year ...
    """

    streams: Mapping[str, Stream]
    source: str
    conventions: tuple[str, ...] = ()
    origin_ns: int = 0
    truth: Truth | None = None
    estimate: Truth | None = None
    skipped: tuple[str, ...] = ()
    info: Mapping[str, str | float] = field(default_factory=dict)

    def stream(self, name: str) -> Stream:
        """Return a stream by name, or raise ``InputError`` listing those present."""
        try:
            return self.streams[name]
        except KeyError:
            raise InputError(
                f"no stream {name!r}",
                place=self.source,
                got=f"streams {', '.join(self.streams) or 'none'}",
                expected=f"a stream named {name!r}",
            ) from None

    def between(self, start: float, stop: float) -> Log:
        """Return the recording cut to ``start <= t <= stop`` [s]; the truth is kept whole."""
        cut = {name: stream.between(start, stop) for name, stream in self.streams.items()}
        return replace(self, streams=cut)


@dataclass(frozen=True)
class Anchors:
    """Ranging anchors at surveyed points.

    Parameters
    ----------
    ids : (k,) names, printable and all different.
    p_a : (k, 3) positions [m] in frame a: right-handed, z down, origin and direction of x as surveyed.
    sd : (k, 3) standard deviations of the survey [m], or None.

    Raises
    ------
    InputError : no anchor, a name that is empty or stands twice, a number that is missing, or a wrong shape.
    """

    ids: tuple[str, ...]
    p_a: Array
    sd: Array | None = None

    def __post_init__(self) -> None:
        check_names(self.ids, "anchors")
        for name, value in (("p_a", self.p_a), ("sd", self.sd)):
            if value is None:
                continue
            object.__setattr__(self, name, np.ascontiguousarray(value, float))
            checked = getattr(self, name)
            if checked.shape != (len(self.ids), 3) or not np.isfinite(checked).all():
                got = f"shape {checked.shape}, {np.count_nonzero(~np.isfinite(checked))} numbers not finite"
                raise InputError(f"anchors {name}", got=got, expected=f"finite numbers, shape ({len(self.ids)}, 3)")
        if self.sd is not None and not (self.sd > 0).all():
            raise InputError("anchors sd", got=f"{self.sd.min()}", expected="standard deviations > 0 m")


@dataclass(frozen=True)
class Ranges:
    """Ranges between tags and anchors, one row each, in time order.

    One table of events, not a ``Stream`` for each link: ranges arrive one at a time, a filter fuses them in the order
    of their stamps, and a model must not change with the number of anchors.  ``stream`` turns the rows into the
    readings of one sensor, each with the position of its anchor.

    Parameters
    ----------
    t : (n,) seconds since the recording's start, never decreasing; several rows may share a stamp.
    anchor, tag : (n,) which of ``anchors`` and ``tags``, from 0.
    distance : (n,) ranges [m], as reported or calibrated; always a number, a range that failed has no row.
    anchors : where the anchors stand.
    tags : names of the tags.
    lever_b : (tags, 3) where the tags sit on the body [m], FRD, or None.
    variance : (n,) reported or calibrated variance [m^2], or None.

    Raises
    ------
    InputError : shapes differ, time goes backwards, an index points nowhere, a distance is not finite.
    """

    t: Array
    anchor: IntArray
    tag: IntArray
    distance: Array
    anchors: Anchors
    tags: tuple[str, ...] = ("tag",)
    lever_b: Array | None = None
    variance: Array | None = None

    def __post_init__(self) -> None:
        check_names(self.tags, "tags")
        for name in ("t", "distance", "variance", "lever_b"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), float))
        check_time(self.t, "ranges")
        self._check("distance", self.distance, np.isfinite, "a finite number of metres")
        for name, index, size in (("anchor", self.anchor, len(self.anchors.ids)), ("tag", self.tag, len(self.tags))):
            object.__setattr__(self, name, np.asarray(index))
            index = getattr(self, name)
            if index.dtype.kind not in "iu":
                raise InputError(f"ranges {name}", got=f"dtype {index.dtype}", expected="integers")
            self._check(name, index, lambda x, size=size: (x >= 0) & (x < size), f"0 to {size - 1}")
        if self.variance is not None:
            self._check("variance", self.variance, lambda x: np.isfinite(x) & (x >= 0), "a finite variance >= 0 m^2")
        if self.lever_b is not None and self.lever_b.shape != (len(self.tags), 3):
            raise InputError("lever_b", got=f"shape {self.lever_b.shape}", expected=f"shape ({len(self.tags)}, 3)")

    def _check(self, name: str, values: Array | IntArray, good: Callable[..., BoolArray], expected: str) -> None:
        if values.shape != self.t.shape:
            raise InputError(f"ranges {name}", got=f"shape {values.shape}", expected=f"shape {self.t.shape}")
        bad = np.flatnonzero(~good(values))
        if bad.size:
            raise InputError(f"ranges {name}", place=f"row {bad[0]}", got=str(values[bad[0]]), expected=expected)

    def __len__(self) -> int:
        return len(self.t)

    def where(self, keep: BoolArray) -> Ranges:
        """Return the rows for which ``keep`` (n,) is true."""
        columns = {name: getattr(self, name) for name in ("t", "anchor", "tag", "distance", "variance")}
        return replace(self, **{name: value[keep] for name, value in columns.items() if value is not None})

    def stream(self, name: str = "range") -> Stream:
        """Return the rows as readings (n, 4) in metres: the distance, then the anchor's position in frame a."""
        return Stream(name, self.t, np.column_stack([self.distance, self.anchors.p_a[self.anchor]]), "m", "a")


@dataclass(frozen=True)
class Innovations:
    """What one sensor's readings told a filter, before they were used.

    ``t`` (n,) s; ``z`` (n, m) measured minus predicted in the sensor's unit; ``s`` (n, m) their predicted variances,
    row after row as they were fused (NaN for constant-gain filters); ``nis`` (n,) = sum z^2 / s;
    ``used`` (n,) False where a gate refused the reading or it was missing.
    """

    t: Array
    z: Array
    s: Array
    nis: Array
    used: BoolArray


@dataclass(frozen=True)
class Run:
    """What an estimator said on one recording.

    Parameters
    ----------
    estimator, model : their names.
    t : (n,) times of the inputs [s].
    state : state blocks by name, each (n, size); ``q_nb`` is Hamilton, w first.
    sd : standard deviations by block, each (n, error_size), rad for rotations.
    innovations : by sensor.
    events : restarts, gaps and missing samples, in words.
    settings : everything needed to repeat the run.
    """

    estimator: str
    model: str
    t: Array
    state: Mapping[str, Array]
    sd: Mapping[str, Array]
    innovations: Mapping[str, Innovations]
    events: tuple[str, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Score:
    """Numbers from a Run and a Truth: ``values`` by name (unit in the name), over ``samples`` samples."""

    estimator: str
    reference: str
    values: Mapping[str, float]
    samples: int
    notes: tuple[str, ...] = ()
