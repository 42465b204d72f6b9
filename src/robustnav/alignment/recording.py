"""From a recording to what ``align`` takes: increments of even periods, and the readings of others at their ends.

A reading of gyro or accelerometer is taken for the mean since the reading before it, as units with their own filter
report it.  Their sums are therefore known at the stamps; between them they are straight lines, so that a recording of
any rate, its stamps jittering, is cut into even samples without losing any turn or velocity.  Nothing is made up for
samples that were lost: a recording with gaps is cut at them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robustnav.alignment.bank import LEVEL_TIME
from robustnav.engine.strapdown import preintegrate
from robustnav.errors import InputError
from robustnav.frames import Array, quat_multiply, rotate
from robustnav.records import Log, Stream
from robustnav.strapdown.increments import ImuSamples, Increments, check_interval
from robustnav.units import DEG, STANDARD_GRAVITY

JITTER = 1.5  # median intervals: what is longer has lost a sample
SIMULTANEOUS = 0.1  # of an interval, gyro and accelerometer apart
ON_TIME = 1e-6  # of a period
MOST_FORCE_OFF = 0.05  # of gravity, the median
WANDER_SECONDS = 1.0  # s in which the direction of specific force is watched
MOST_WANDER = 20 * DEG
MOST_VELOCITY = 50.0  # m/s: no wind at a mooring is faster
REFERENCE = "velocity"  # the stream


@dataclass(frozen=True)
class Readings:
    """What a recording gives an alignment.

    Parameters
    ----------
    increments : n of them, of one period each.
    t : (n,) their ends [s], on the recording's clock.
    reference : (n, 2) velocity north and east at the ends [m/s], NaN where there is none.
    field_b : (n, 3) magnetic field in body axes at the ends [T], NaN where there is none.
    rate_hz : of the inertial samples.
    events : what was left out, in words.
    """

    increments: Increments
    t: Array
    reference: Array
    field_b: Array
    rate_hz: float
    events: tuple[str, ...] = ()


def readings_of(log: Log, period: float, *, longest: bool = False) -> Readings:
    """Return a recording as an alignment takes it.

    Parameters
    ----------
    log : streams ``gyro`` and ``accel`` [rad/s, m/s^2, body axes], read together; where they are there, ``velocity``
        [m/s, north, east], at any rate, and ``mag`` [T, body axes].
    period : of the increments [s].
    longest : of a recording with gaps take the longest piece, instead of refusing it.

    Notes
    -----
    Periods end at the stamps of the reference, if it has any.  A reading counts for the nearest end, if that is within
    half a period and no other reading is nearer.

    Raises
    ------
    InputError : no such stream, wrong unit or frame, gyro and accelerometer apart, a gap in them (unless ``longest``),
        less than two seconds, numbers that no unit at rest would give, or no reference reading meanwhile.
    """
    check_interval("increments", period)
    t, values, events = _inertial(log)
    t, values, cut = _whole(log, t, values, longest=longest)
    interval = float(np.median(np.diff(t)))
    velocity = _velocity(log)
    begin = _begin(t[0] - interval, velocity, period)
    n = int((t[-1] - begin) / period + ON_TIME)
    if n * period < LEVEL_TIME:
        raise InputError(
            "too short to align",
            place=log.source,
            got="; ".join([f"{t[-1] - t[0]:.3g} s of inertial samples", *cut]),
            expected=f"{LEVEL_TIME:g} s at least; a wind takes twelve to be told from a tilt",
        )
    every = max(1, round(period / interval))
    samples = _even(t, values, begin + period / every * np.arange(n * every + 1.0), period / every)
    increments = preintegrate(samples, every)
    check_sensors(increments, log.source)
    ends = begin + period * np.arange(1.0, n + 1.0)
    reference, words = _reference(velocity, ends, period, log.source)
    mag = log.streams.get("mag")
    field_b = np.full((n, 3), np.nan) if mag is None else nearest(_checked(log, "mag", "T", "b", 3), ends, period)
    return Readings(
        increments=replace(increments, dt=period),
        t=ends,
        reference=reference,
        field_b=field_b,
        rate_hz=1 / interval,
        events=(*events, *cut, *words),
    )


def nearest(stream: Stream, ends: Array, period: float) -> Array:
    """Return a stream's readings (n, m) nearest to evenly spaced ``ends`` (n,) [s], each used once.

    NaN where none is within half a period.  Rows with a missing number are no readings.
    """
    there = ~np.isnan(stream.values).any(axis=1)
    t, values = stream.t[there], stream.values[there]
    row = np.round((t - ends[0]) / period).astype(int)
    inside = (row >= 0) & (row < len(ends))
    t, values, row = t[inside], values[inside], row[inside]
    order = np.argsort(-np.abs(t - ends[row]), kind="stable")  # the nearest is written last, and stays
    out = np.full((len(ends), stream.values.shape[1]), np.nan)
    out[row[order]] = values[order]
    return out


def check_sensors(increments: Increments, source: str) -> None:
    """Raise ``InputError`` unless specific force has the size of gravity and turns in the body as the gyro says."""
    size = float(np.median(np.linalg.norm(increments.velocity, axis=1))) / increments.dt
    if abs(size / STANDARD_GRAVITY - 1) > MOST_FORCE_OFF:
        raise InputError(
            "accelerometer at rest",
            place=source,
            got=f"a median of {size:.4g} m/s^2",
            expected=f"{STANDARD_GRAVITY:.2f} m/s^2 within {100 * MOST_FORCE_OFF:g} %",
            do="check its unit (g is 9.80665 m/s^2); robustnav doctor names what is wrong",
        )
    turned, still = _wander(increments)
    if turned > MOST_WANDER and turned > 2 * still:
        raise InputError(
            "gyro and accelerometer disagree",
            place=source,
            got=f"specific force wanders by {turned / DEG:.0f} deg in a second if turned as the gyro says, by "
            f"{still / DEG:.0f} deg in the body",
            expected="a vertical that stands still",
            do="is the gyro in rad/s, not deg/s? check its axes and signs; robustnav doctor names what is wrong",
        )


def _wander(increments: Increments) -> tuple[float, float]:
    """Return the rms angle [rad] of specific force from its mean within a second, turned as the gyro says and in b."""
    steps = max(2, round(WANDER_SECONDS / increments.dt))
    n = len(increments) // steps
    force = increments.velocity[: n * steps].reshape(n, steps, 3)
    rotation = increments.rotation[: n * steps].reshape(n, steps, 4)
    q, turned = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)), np.empty_like(force)
    for k in range(steps):
        turned[:, k] = rotate(q, force[:, k])
        q = quat_multiply(q, rotation[:, k])
    return _spread(turned), _spread(force)


def _spread(force: Array) -> float:
    direction = force / np.linalg.norm(force, axis=2, keepdims=True)
    mean = direction.mean(axis=1, keepdims=True)
    mean /= np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), 1e-9)
    angle = np.arctan2(np.linalg.norm(np.cross(direction, mean), axis=2), (direction * mean).sum(axis=2))
    return float(np.sqrt(np.mean(angle**2)))


def _inertial(log: Log) -> tuple[Array, Array, tuple[str, ...]]:
    """Return stamps (n,), rates and forces (n, 6) of the rows that are whole and advance, and what was left out."""
    gyro, accel = _checked(log, "gyro", "rad/s", "b", 3), _checked(log, "accel", "m/s^2", "b", 3)
    if len(gyro) < 2 or len(gyro) != len(accel):
        raise InputError(
            "gyro and accelerometer",
            place=log.source,
            got=f"{len(gyro)} and {len(accel)} readings",
            expected="as many of each, read together, two at least",
            do="resample one to the stamps of the other",
        )
    apart = np.abs(gyro.t - accel.t)
    row = int(np.argmax(apart))
    if apart[row] > SIMULTANEOUS * float(np.median(np.diff(gyro.t))):
        raise InputError(
            "gyro and accelerometer",
            place=f"{log.source}, row {row}",
            got=f"stamps of {gyro.t[row]:.6f} s and {accel.t[row]:.6f} s",
            expected="readings taken together",
            do="resample one to the stamps of the other",
        )
    values = np.hstack([gyro.values, accel.values])
    whole = np.asarray(~np.isnan(values).any(axis=1))
    fresh = np.append(np.diff(gyro.t) > 0, True) & whole  # of equal stamps the last
    events = []
    if not whole.all():
        events.append(f"{np.sum(~whole)} of {len(whole)} inertial readings are missing")
    if (whole & ~fresh).any():
        events.append(f"{np.sum(whole & ~fresh)} inertial readings with the stamp of the next are left out")
    return gyro.t[fresh], values[fresh], tuple(events)


def _whole(log: Log, t: Array, values: Array, *, longest: bool) -> tuple[Array, Array, tuple[str, ...]]:
    """Return the samples between gaps: all of them, or the longest piece where that is wanted."""
    if len(t) < 2:
        raise InputError("gyro and accelerometer", place=log.source, got="no readings", expected="two at least")
    interval = float(np.median(np.diff(t)))
    gaps = np.flatnonzero(np.diff(t) > JITTER * interval)
    if not gaps.size:
        return t, values, ()
    first, last = np.append(0, gaps + 1), np.append(gaps, len(t) - 1)
    best = int(np.argmax(t[last] - t[first]))
    start, stop = f"{t[first[best]]:.3f}", f"{t[last[best]]:.3f}"
    widest = int(gaps[np.argmax(np.diff(t)[gaps])])
    count = "1 gap" if len(gaps) == 1 else f"{len(gaps)} gaps"
    found = f"{count}, the longest {t[widest + 1] - t[widest]:.4g} s after {t[widest]:.3f} s"
    if not longest:
        raise InputError(
            "gaps in gyro and accelerometer",
            place=log.source,
            got=found,
            expected=f"a reading every {interval * 1e3:.4g} ms: nothing tells how the unit turned meanwhile",
            do=f"align the longest piece: --start {start} --stop {stop}, or --longest",
        )
    keep = slice(first[best], last[best] + 1)
    return t[keep], values[keep], (f"{found}; aligned over the longest piece, {start} to {stop} s",)


def _even(t: Array, values: Array, edges: Array, dt: float) -> ImuSamples:
    """Return even samples between ``edges`` (m + 1,), ``dt`` apart, from means over the intervals before stamps."""
    lasting = np.diff(t, prepend=t[0] - float(np.median(np.diff(t))))
    stamps = np.append(t[0] - lasting[0], t)
    total = np.vstack([np.zeros(6), np.cumsum(values * lasting[:, None], axis=0)])
    sums = np.stack([np.diff(np.interp(edges, stamps, column)) for column in total.T], axis=1)
    return ImuSamples(sums[:, :3], sums[:, 3:], dt)


def _velocity(log: Log) -> Stream | None:
    """Return the reference velocity, north and east, or None without one."""
    if REFERENCE not in log.streams:
        return None
    given = log.stream(REFERENCE)
    width = given.values.shape[1]
    checked = _checked(log, REFERENCE, "m/s", "n", 3 if width == 3 else 2)
    size = np.abs(checked.values[:, :2])
    fast = np.flatnonzero((size > MOST_VELOCITY).any(axis=1))
    if len(fast) > len(size) // 2:
        raise InputError(
            "reference velocity",
            place=f"{log.source}, {given.t[fast[0]]:.3f} s",
            got=f"{size[fast[0]].max():.4g} m/s",
            expected=f"at most {MOST_VELOCITY:g} m/s at a mooring",
            do="check its unit",
        )
    return Stream(REFERENCE, given.t, given.values[:, :2], "m/s", "n")


def _begin(start: float, velocity: Stream | None, period: float) -> float:
    """Return when periods begin so that one of them ends at the first reference reading after ``start`` [s]."""
    after = velocity.t[velocity.t >= start] if velocity is not None else np.zeros(0)
    late = (float(after[0]) - start) % period if after.size else 0.0
    return start + late if ON_TIME * period < late < (1 - ON_TIME) * period else start


def _reference(velocity: Stream | None, ends: Array, period: float, source: str) -> tuple[Array, tuple[str, ...]]:
    if velocity is None:
        return np.full((len(ends), 2), np.nan), ()
    out = nearest(velocity, ends, period)
    used = int((~np.isnan(out[:, 0])).sum())
    if not used:
        raise InputError(
            "reference velocity",
            place=source,
            got=f"no reading between {ends[0] - period:.3f} and {ends[-1]:.3f} s",
            expected="readings while gyro and accelerometer are read",
            do="bring the streams to one clock",
        )
    words = f"{used} of {len(velocity)} reference readings stand at the ends of {len(ends)} periods"
    return out, () if used == len(ends) == len(velocity) else (words,)


def _checked(log: Log, name: str, unit: str, frame: str, width: int) -> Stream:
    stream = log.stream(name)
    found = (stream.unit, stream.frame, stream.values.shape[1])
    if found != (unit, frame, width):
        raise InputError(
            f"stream {name!r}",
            place=log.source,
            got=f"{found[2]} columns in {found[0]}, frame {found[1]}",
            expected=f"{width} columns in {unit}, frame {frame}",
        )
    return stream
