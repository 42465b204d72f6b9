"""Attitude of a carrier that moves, from its inertial unit and satellite velocity or position, without a prior."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array, Log, Run, Stream
from robustnav.run.feed import feed_of
from robustnav.run.inertial_course import InertialCourse
from robustnav.run.moving_compass import with_compass
from robustnav.run.moving_setting import GnssAiding, InertialUnit, MovingStart, latitude_of, moving_ekf
from robustnav.run.moving_start import SENSORS, Window, moving_starts, window_at
from robustnav.run.task import Task
from robustnav.units import DEG

_UNITS = {"velocity": "m/s", "position": "m"}
_SILENCE = 2.0  # s without a reading that the events name
_LOST = 5.0  # s of readings that most are off, after which a filter is lost
_LEAST = 8  # of them
_REFUSED_NIS = 16.3  # three rows with their stated noise exceed it in 0.1 %
_AGREED = 0.8  # what readings must count for on average in a window that a lost filter starts from


def align_moving(
    log: Log,
    unit: InertialUnit,
    aiding: GnssAiding,
    settings: MovingStart | None = None,
    *,
    smooth: bool = False,
    backend: str = "auto",
) -> Run:
    """Return attitude, velocity and position of a carrier that moves, with nothing known at the start.

    A window of a second or more tells tilt, velocity and place, however the carrier manoeuvres (``moving_start``).  The
    heading shows when it accelerates sideways: filters with headings all round are followed until the readings tell
    one, and the best one so far is reported with a covariance that reaches to the others.  Readings far off count for
    little (Student-t).  When most readings of five seconds are far off and a window of them agrees with the inertial
    unit, everything is started again.  The events say when and what.  Nothing looks ahead, unless ``smooth`` is asked
    for.

    Parameters
    ----------
    log : streams ``gyro`` and ``accel`` of common times; ``gnss_velocity`` [m/s] or ``gnss_position`` [m], or both, in
        level axes north-east-down; ``heading`` [rad] of the forward axis, or ``mag``.  Missing readings are NaN.
    unit : the inertial unit.
    aiding : what is known of the readings; those without a standard deviation are not used.
    settings : how to start and restart; None: the defaults.
    smooth : smooth over the whole recording; a restart cuts it.
    backend : ``auto``, ``c``, ``float`` or ``numpy``.

    Returns
    -------
    Run : from the first start on, at the times of the inputs.  Without positions, ``p_n`` counts from the start.

    Raises
    ------
    InputError : no stream that ``aiding`` has a figure for, a stream in other axes or units, or as ``run``.
    EstimatorError : no window of readings tells the tilt.
    """
    settings = settings or MovingStart()
    estimator = moving_ekf(log, unit, aiding, settings.latitude)
    model = estimator.model
    fused = replace(log, streams=fused_streams(log, aiding))
    feed = feed_of(model, fused)
    news = {model.sensor_index(n): np.ones(len(fused.streams[n])) for n in SENSORS if n in fused.streams}
    task = Task(estimator, fused, feed, news, backend)
    row, window = _first(task, settings)
    starts = moving_starts(task, window, aiding, settings.headings)
    task, compass = with_compass(task, log, aiding, (row, starts))
    course = InertialCourse(task, settings.found_sd, task.nothing_said())
    _set_out(course, (row, window), (aiding, settings), "started")
    while settings.restart and (lost := _lost(course, settings)) is not None:
        _set_out(course, lost, (aiding, settings), "lost and started again")
    course.events += [*_words(task, log, aiding, settings), *compass]
    return course.report(task.with_silent(), {"headings": settings.headings}, smooth=smooth)


def _set_out(
    course: InertialCourse, begin: tuple[int, Window], given: tuple[GnssAiding, MovingStart], word: str
) -> None:
    (row, window), (aiding, settings) = begin, given
    sd = window.fit.cov[1, 1] ** 0.5
    words = f"{word} at {course.task.feed.t[row]:.2f} s from {window.seconds:.1f} s, sd {sd:.2f} m/s"
    course.set_out(row, moving_starts(course.task, window, aiding, settings.headings), words)


def fused_streams(log: Log, aiding: GnssAiding) -> dict[str, Stream]:
    """Return the streams a log gives to the model, by the names of its inputs and sensors."""
    streams = {name: log.stream(name) for name in ("gyro", "accel")}
    for name in SENSORS:
        if getattr(aiding, f"{name}_sd") is not None and f"gnss_{name}" in log.streams:
            one = _checked(log, f"gnss_{name}", _UNITS[name], 3)
            t, lever_b = one.t - aiding.delay, np.tile(aiding.lever_b, (len(one), 1))
            rates = [_rate_at(streams["gyro"], t)] if name == "velocity" else []
            streams[name] = Stream(name, t, np.hstack([one.values, lever_b, *rates]), one.unit, "n")
    if len(streams) == 2:
        expected = "gnss_velocity with a velocity_sd, or gnss_position with a position_sd"
        raise InputError("no GNSS to align with", place=log.source, got=", ".join(log.streams), expected=expected)
    if aiding.heading_sd is not None and "heading" in log.streams:
        streams["heading"] = _checked(log, "heading", "rad", 1)
    return streams


def _rate_at(gyro: Stream, t: Array) -> Array:
    """Return what the gyro reads (n, 3) over the intervals that hold times t (n,), NaN where no reading follows."""
    whole = np.isfinite(gyro.values).all(axis=1)
    k = np.searchsorted(gyro.t[whole], t)
    read: Array = np.vstack([gyro.values[whole], np.full(gyro.values.shape[1], np.nan)])[k]
    return read


def _checked(log: Log, name: str, unit: str, width: int) -> Stream:
    one = log.streams[name]
    if one.unit != unit or one.frame != "n" or one.values.shape[1] != width:
        got = f"{one.values.shape[1]} columns in {one.unit}, frame {one.frame}"
        raise InputError(f"stream {name!r}", place=log.source, got=got, expected=f"{width} in {unit}, frame n")
    return one


def _first(task: Task, settings: MovingStart) -> tuple[int, Window]:
    """Return the first row at which a window tells the tilt, and what it tells."""
    t = task.feed.t
    heard = [data.t for j in task.news if (data := task.feed.sensors[j]) is not None]
    rows = np.unique(np.searchsorted(t, np.concatenate([np.zeros(0), *heard])))
    for row in rows[(rows > 0) & (rows < len(t) - 1)]:
        if t[row] - t[0] < 0.8 * settings.window:
            continue
        found = window_at(task, int(row), settings)
        if found is not None:
            return int(row), found
    raise EstimatorError(
        "no tilt to start from",
        place=task.log.source,
        got=f"{sum(len(one) for one in heard)} readings within {t[-1] - t[0]:.1f} s of inputs",
        expected=f"up to {settings.patience:g} s of readings that tell it to {settings.tilt_sd / DEG:g} deg",
        do="check times, units and axes of accel and GNSS with: robustnav doctor",
    )


def _lost(course: InertialCourse, settings: MovingStart) -> tuple[int, Window] | None:
    """Return the next row at which readings disagree with the filter but not with the inertial unit, or None."""
    task, leg, last = course.task, course.legs[-1], -np.inf
    t = task.feed.t
    for j in task.news:
        one, data = course.seen[j], task.feed.sensors[j]
        if one is None or data is None or not len(data.t):
            continue
        said = np.isfinite(one.nis) & (data.t > t[leg.settled])
        at, off = data.t[said], one.nis[said] > _REFUSED_NIS
        begin = np.searchsorted(at, at - _LOST)
        total = np.arange(1, len(at) + 1) - begin
        sums = np.concatenate([[0], np.cumsum(off)])
        refused = sums[1:] - sums[begin]
        for k in np.flatnonzero(off & (total >= _LEAST) & (2 * refused >= total)):
            row = int(np.searchsorted(t, at[k]))
            if at[k] - last < settings.window or row >= len(t) - 1:
                continue
            last = at[k]
            found = window_at(task, row, settings)
            if found is not None and found.fit.agreed > _AGREED:
                return row, found
    return None


def _words(task: Task, log: Log, aiding: GnssAiding, settings: MovingStart) -> list[str]:
    """Return in words what was not there, not used, or silent."""
    out = []
    for name in SENSORS:
        there, wanted = f"gnss_{name}" in log.streams, getattr(aiding, f"{name}_sd") is not None
        if there != wanted:
            out.append(f"no gnss_{name} stream: not fused" if wanted else f"gnss_{name} without {name}_sd: not fused")
        if not (there and wanted):
            continue
        one = task.log.streams[name]
        t = one.t[np.isfinite(one.values).all(axis=1)]
        gaps = np.flatnonzero(np.diff(t) > _SILENCE)[:20]
        out += [f"no gnss_{name} from {t[k]:.2f} to {t[k + 1]:.2f} s" for k in gaps]
    if latitude_of(log, settings.latitude) is None:
        out.append("no latitude: standard gravity, the Earth's rate left out")
    return out
