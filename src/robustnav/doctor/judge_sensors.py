"""T, Q, F, B in words: each sensor by itself."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robustnav.doctor.measure import Numbers
from robustnav.doctor.readings import Readings
from robustnav.doctor.record import Finding, Level
from robustnav.doctor.timing import Timing
from robustnav.records import Log
from robustnav.units import DPS, MICRO_TESLA, STANDARD_GRAVITY

GRAVITY = 9.81  # m/s^2, where the place is not known
FORCE_UNITS = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "milli-g": STANDARD_GRAVITY / 1000}
EARTH_FIELD = (22 * MICRO_TESLA, 67 * MICRO_TESLA)
FIELD_UNITS = {"tesla": 1.0, "gauss": 1e-4, "microtesla": 1e-6, "milligauss": 1e-7, "nanotesla": 1e-9}
SENSORS = ("gyro", "accel", "mag")  # they are noisy: a reading that never changes is no reading
LONG_GAP = 1.0  # s
MISSING = 0.1  # share of stretched intervals that is no longer a logger's hiccup
RANGE_FLOOR = {"gyro": 100 * DPS, "accel": 15.0}  # no sensor's range ends below: less is noise standing still


def judge_time(n: Numbers) -> Iterator[Finding]:
    """Yield T: stamps, repeats and gaps; streams that share their stamps share the finding."""
    for t in dict.fromkeys(n.timing.values()):
        yield from _time(", ".join(name for name, other in n.timing.items() if other == t), t)


def _time(name: str, t: Timing) -> Iterator[Finding]:
    if t.rows < 2 or np.isnan(t.interval_s):
        got = f"{t.rows} rows" if t.rows < 2 else f"{t.rows} rows with one stamp"
        yield Finding("T", "error", f"{name} time", got, "stamps that advance", "drop the stream or correct its stamps")
        return
    what = f"{t.rows} rows, {t.rate_hz:.2f} Hz, median interval {t.interval_s * 1e3:.3f} ms"
    share = t.stretched / (t.rows - 1)
    faults = []
    if t.repeats:
        faults.append(f"{t.repeats} repeated stamps")
        level: Level = "error" if t.repeats > 0.5 * t.rows else "warning"
        do = "drop repeated rows: time must advance between samples"
        yield Finding("T", level, f"{name} stamps", faults[-1], "strictly increasing", do)
    gaps = f"{t.gaps} gaps, the largest {t.largest_gap_s * 1e3:.1f} ms at {t.largest_gap_at_s:.2f} s"
    if share > MISSING:
        got = f"{t.stretched} of {t.rows - 1} intervals at least doubled; {gaps}"
        do = "log faster storage or fewer topics; use an estimator that takes the true interval"
        yield Finding("T", "warning", f"{name} samples missing", got, "equal intervals", do)
    elif t.largest_gap_s > LONG_GAP:
        do = "start the estimator again after it, or cut the recording there"
        yield Finding("T", "warning", f"{name} gap", gaps, f"no gap above {LONG_GAP:g} s", do)
    elif t.gaps:
        yield Finding("T", "info", f"{name} time", f"{what}; {gaps}")
    elif not faults:
        yield Finding("T", "ok", f"{name} time", what)


def judge_readings(n: Numbers) -> Iterator[Finding]:
    """Yield Q: missing, held, stuck and limited readings of every stream."""
    for name, r in n.readings.items():
        yield from _readings(name, r, n.timing[name].rows)


def _readings(name: str, r: Readings, rows: int) -> Iterator[Finding]:
    if r.missing == rows:
        yield Finding("Q", "error", f"{name} readings", f"none in {rows} rows", "numbers", "drop the stream")
        return
    if r.missing:
        yield Finding("Q", _grave(r.missing > 0.05 * rows), f"{name} readings missing", f"{r.missing} of {rows} rows")
    if r.constant and name in SENSORS:
        got, do = f"axis {_axes(r.constant)} never changes", "the sensor or its driver is stuck: do not use it"
        yield Finding("Q", "error", f"{name} stuck", got, "noise at least", do)
    elif r.held > 0.1 * rows:
        got, do = f"{r.held} of {rows} rows repeat the row before", "drop them, or each reading counts more than once"
        yield Finding("Q", _grave(r.held > 0.5 * rows), f"{name} readings held", got, "", do)
    if r.limited and r.limit > RANGE_FLOOR.get(name, np.inf):
        do = "set a wider range; an estimator must not use these samples"
        yield Finding(
            "Q",
            "error",
            f"{name} at its limit",
            f"axis {_axes(r.limited)} stands at {r.limit:.4g}",
            "below its range",
            do,
        )


def _axes(numbers: tuple[int, ...]) -> str:
    return " ".join("xyz"[k] if k < 3 else str(k) for k in numbers)


def _grave(much: bool) -> Level:
    return "warning" if much else "info"


def nearest_unit(size: float, expected: float, units: dict[str, float]) -> str:
    """Return the unit in which ``size`` comes closest, by ratio, to ``expected`` in SI."""
    return min(units, key=lambda unit: abs(np.log(size * units[unit] / expected)))


def judge_force(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield F: the accelerometer's size against gravity."""
    r = n.readings.get("accel")
    if r is None or not r.norm_median > 0:
        return
    gravity, where = (n.place.gravity, "at the place") if n.place else (GRAVITY, "nominal")
    expected = f"{gravity:.3f} m/s^2 ({where})"
    unit = nearest_unit(r.norm_median, gravity, FORCE_UNITS)
    if unit != "m/s^2":
        got, do = f"median norm {r.norm_median:.4g}", f"read it as {unit}: multiply by {FORCE_UNITS[unit]:g}"
        yield Finding("F", "error", f"accelerometer unit: {unit}", got, expected, do)
        return
    off = r.norm_median / gravity - 1
    got = f"median norm {r.norm_median:.3f} m/s^2, {100 * off:+.1f} %"
    level: Level = "ok" if abs(off) <= 0.015 else "warning" if abs(off) <= 0.05 else "error"
    do = "" if level == "ok" else "calibrate bias and scale, or check the unit and how much the vehicle accelerates"
    yield Finding("F", level, "accelerometer size", got, expected, do)


def judge_field(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield B: the magnetometer's size against the Earth's field."""
    r = n.readings.get("mag")
    if r is None or not r.norm_median > 0:
        return
    low, high = EARTH_FIELD
    expected = f"{low / MICRO_TESLA:.0f} to {high / MICRO_TESLA:.0f} microtesla"
    unit = nearest_unit(r.norm_median, float(np.sqrt(low * high)), FIELD_UNITS)
    if unit != "tesla":
        got, do = f"median norm {r.norm_median:.4g}", f"read it as {unit}: multiply by {FIELD_UNITS[unit]:g}"
        yield Finding("B", "error", f"magnetometer unit: {unit}", got, expected, do)
        return
    got = f"median norm {r.norm_median / MICRO_TESLA:.2f} microtesla, sd {r.norm_sd / MICRO_TESLA:.2f}"
    if low <= r.norm_median <= high:
        yield Finding("B", "ok", "magnetometer size", got, expected)
    else:
        do = "calibrate it, or move it away from iron and currents"
        yield Finding("B", "warning", "magnetometer size", got, expected, do)
