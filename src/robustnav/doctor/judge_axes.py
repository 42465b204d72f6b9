"""G, D, A, V, S, L, E in words: sensors against the attitude and against each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robustnav.doctor.axes import AxisMatch
from robustnav.doctor.measure import Numbers
from robustnav.doctor.record import Finding, Level
from robustnav.doctor.turning import Turning
from robustnav.frames import Array, wrap_angle
from robustnav.records import Log
from robustnav.units import DEG, DPS, MICRO_TESLA

IDENTITY = "+x+y+z"
GOOD = 0.9  # share of the motion explained
NOISY = 0.5  # with the right axes best by far, the rest is noise of the attitude or a lag
TILT_OK, TILT_WRONG, UPSIDE_DOWN = 3.0, 10.0, 150.0  # deg
DIP_OK, DIP_WRONG = 5.0, 20.0  # deg from the model
SCALE_OK, SCALE_WRONG = (0.95, 1.05), (0.8, 1.25)
LAG_OK = 10.0  # ms
UNIT_BAND = 1.3  # a ratio within this factor of a unit's is that unit
BODY_TURNS = {"+x-y-z": "FLU instead of FRD, or the reverse", "-x-y+z": "half a turn about z"}


def _vector(v: Array) -> str:
    return "(" + ", ".join(f"{x:.3f}" for x in v) + ")"


def lag_explains(t: Turning) -> bool:
    """Say whether the attitude fits the gyro once its stamps are moved by the lag found."""
    return abs(t.lag_ms) >= LAG_OK and t.share_at_lag > GOOD


def attitude_fault(n: Numbers) -> str:
    """Return what is wrong between attitude and gyro: nothing, ``axes``, ``conjugate``, ``order`` or ``unknown``."""
    t = n.turning
    if t is None or n.motion is None or not n.motion.enough:
        return ""
    a = t.axes
    if a.best == IDENTITY and (a.share > NOISY or lag_explains(t)):
        return ""
    if a.best != IDENTITY and a.best_share > GOOD:
        return "axes"
    for share, fault in ((t.conjugated, "conjugate"), (t.reordered, "order")):
        if share > GOOD:
            return fault
    return "unknown"


def judge_gravity(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield G: mean specific force in the world of the attitude."""
    if n.world is None or n.world.force_n is None:
        return
    tilt, force = n.world.tilt_deg, n.world.force_n.vector_n
    got = f"mean C_nb f_b = {_vector(force)} m/s^2, {tilt:.2f} deg from upright"
    expected = "(0, 0, -9.8): specific force, body FRD, world NED"
    if tilt < TILT_OK:
        yield Finding("G", "ok", "gravity in the world", got, expected)
    elif attitude_fault(n) in ("axes", "conjugate", "order"):
        yield Finding("G", "error", "gravity in the world", got, expected, "see the finding on axes by attitude first")
    elif tilt > UPSIDE_DOWN:
        thing, do = _upside_down(n)
        yield Finding("G", "error", thing, got, expected, do)
    else:
        level: Level = "warning" if tilt < TILT_WRONG else "error"
        do = "check axes, quaternion order and direction; on a flight, check how much it accelerates"
        yield Finding("G", level, "gravity in the world", got, expected, do)


def _upside_down(n: Numbers) -> tuple[str, str]:
    """Return the likely mistake and the remedy: where the field points in the world tells the two apart."""
    if n.world is not None and n.world.field_n is not None:
        if _near(n.world.declination_deg, 90, 60):
            return "world ENU, body FLU", "convert to NED and FRD: read it with frame FLU and world ENU"
        if _near(n.world.declination_deg, 0, 60):
            return "accelerometer negated", "read it with sign -1 for the accelerometer, or correct the driver"
    return (
        "accelerometer negated, or world ENU and body FLU",
        "read it with sign -1, or with frame FLU and world ENU; a magnetometer would tell which",
    )


def _near(angle_deg: float, wanted_deg: float, within_deg: float) -> bool:
    return bool(abs(wrap_angle((angle_deg - wanted_deg) * DEG)) < within_deg * DEG)


def judge_dip(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield D: the field's dip, and the declination the attitude implies."""
    if n.dip is None:
        return
    dip, sd = n.dip
    got = f"dip {dip:+.1f} deg, sd {sd:.1f}"
    earth = n.place
    if earth is not None and earth.dip_deg is not None and earth.field_t is not None:
        size = n.readings["mag"].norm_median / MICRO_TESLA
        off = abs(dip - earth.dip_deg)
        level: Level = "ok" if off <= DIP_OK else "warning" if off <= DIP_WRONG else "error"
        expected = f"{earth.dip_deg:+.1f} deg and {earth.field_t / MICRO_TESLA:.1f} microtesla at the place"
        do = "" if level == "ok" else "do not use the magnetometer before it is calibrated; check its axes and signs"
        yield Finding("D", level, "magnetic dip", f"{got}, {size:.1f} microtesla", expected, do)
    else:
        yield _dip_sign(n, got, dip)
    yield from _declination(log, n)


def _dip_sign(n: Numbers, got: str, dip: float) -> Finding:
    """Return D without a place: only the sign speaks, and the field's direction in the world explains it."""
    expected = "above zero in the northern hemisphere"
    if dip > 0:
        return Finding("D", "ok", "magnetic dip", got, expected)
    upright = n.world is not None and n.world.tilt_deg < TILT_WRONG
    if upright and n.world is not None and _near(n.world.declination_deg, 180, 60):
        do = "negate the magnetometer; north shows south in the world of the attitude"
        return Finding("D", "error", "magnetometer negated", got, expected, do)
    if n.world is not None and n.world.tilt_deg > UPSIDE_DOWN:
        return Finding("D", "info", "magnetic dip", got, expected, "it follows the accelerometer: see gravity")
    if upright:
        return Finding("D", "info", "magnetic dip", got, expected, "right in the southern hemisphere only")
    do = "negate the accelerometer or the magnetometer, unless it is the southern hemisphere"
    return Finding("D", "warning", "magnetic dip", got, expected, do)


def _declination(log: Log, n: Numbers) -> Iterator[Finding]:
    if n.world is None or not n.world.tilt_deg < TILT_WRONG or np.isnan(n.world.declination_deg):
        return
    implied = n.world.declination_deg
    expected_deg, source = 0.0, "attitude to magnetic north"
    if n.world.north == "true":
        setting = log.info.get("declination_deg")
        if n.place is not None and n.place.declination_deg is not None:
            expected_deg, source = n.place.declination_deg, "model at the place"
        elif isinstance(setting, int | float):
            expected_deg, source = float(setting), "set in the log"
        else:
            return
    good = _near(implied, expected_deg, 10)
    if not good and n.dip is not None and n.dip[0] < 0:
        return  # a dip of the wrong sign is already a finding, and explains this
    setting = log.info.get("declination_deg")
    note = f", set in the log {setting:.2f}" if isinstance(setting, int | float) else ""
    yield Finding(
        "D",
        "ok" if good else "warning",
        "declination",
        f"{implied:.2f} deg by attitude and magnetometer{note}",
        f"{expected_deg:.2f} deg ({source})",
        "" if good else "calibrate the magnetometer, or check which north the attitude refers to",
    )


def judge_attitude(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield A: the gyro's axes against the rate of the attitude."""
    t = n.turning
    if t is None or n.motion is None or not n.motion.enough:
        return
    a = t.axes
    got = _match_words(a, "the turning")
    expected = f"{IDENTITY}, more than {GOOD}"
    fault = attitude_fault(n)
    if fault == "axes":
        thing, do = _axes_words(n, a.best, a.proper)
        yield Finding("A", "error", thing, got, expected, do)
    elif fault == "conjugate":
        do = f"conjugate it: then {t.conjugated:.3f} is explained; q_nb takes body vectors to the world"
        yield Finding("A", "error", "quaternion conjugated", got, expected, do)
    elif fault == "order":
        do = f"read it in the other order, w first or w last: then {t.reordered:.3f} is explained"
        yield Finding("A", "error", "quaternion in the wrong order of numbers", got, expected, do)
    elif fault == "unknown":
        do = "check stamps, axes and the quaternion; no single mistake explains it"
        yield Finding("A", "error", "gyro and attitude disagree", got, expected, do)
    elif a.share <= GOOD and not lag_explains(t):
        yield Finding(
            "A", "info", "axes by attitude", got, expected, "the rest is noise of the attitude, or its filter"
        )
    else:
        yield Finding("A", "ok", "axes by attitude", got, expected)


def _match_words(a: AxisMatch, what: str) -> str:
    return f"{a.share:.3f} of {what} explained; best {a.best} {a.best_share:.3f}, next {a.next_share:.3f}"


def _axes_words(n: Numbers, best: str, proper: bool) -> tuple[str, str]:
    """Return mistake and remedy: gravity and field tell whether the gyro alone is turned, or all sensors."""
    if n.vectors is not None and n.vectors.axes.best == IDENTITY and proper:
        turn = BODY_TURNS.get(best, f"the attitude's body axes are {best} of the sensors")
        return f"sensors and attitude in different body axes: {turn}", f"turn sensors or attitude by {best}"
    what = "turned" if proper else "swapped or negated"
    return f"gyro axes {what}", f"use {best} of the gyro as x, y, z"


def judge_vectors(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield V: the gyro's axes against gravity and field."""
    if n.vectors is None or n.motion is None or not n.motion.enough:
        return
    a = n.vectors.axes
    got = (
        f"{a.share:.3f} of the change of direction explained; best {a.best} {a.best_share:.3f}, next {a.next_share:.3f}"
    )
    if a.best == IDENTITY and a.share > NOISY:
        yield Finding("V", "ok", "axes by gravity and field", got, IDENTITY)
    elif a.best_share > GOOD and a.best_share - a.share > 0.1:
        do = f"use {a.best} of the gyro as x, y, z, or the reverse of it on the other sensors"
        yield Finding("V", "error", "gyro axes do not fit gravity and field", got, IDENTITY, do)
    else:
        yield Finding("V", "info", "axes by gravity and field", got, IDENTITY, "undecided: accelerations hide gravity")


def judge_scale(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield S: the gyro's unit and scale, by attitude, or by gravity and field where there is none."""
    if n.motion is None or not n.motion.enough:
        return
    expected = f"{SCALE_OK[0]} to {SCALE_OK[1]}"
    size = n.turning.size if n.turning else n.vectors.scale if n.vectors else float("nan")
    for ratio, unit in ((DPS, "deg/s"), (1e-3, "mrad/s")):
        if ratio / UNIT_BAND < size < ratio * UNIT_BAND:
            do = f"read it as {unit}: multiply by {ratio:g}"
            yield Finding("S", "error", f"gyro unit: {unit}", f"ratio {size:.4f} to the rate it shows", expected, do)
            return
    t = n.turning
    if t is None or attitude_fault(n):
        return
    scale = t.scale_at_lag if lag_explains(t) else t.scale
    within = SCALE_OK[0] <= scale <= SCALE_OK[1]
    level: Level = "ok" if within else "warning" if SCALE_WRONG[0] <= scale <= SCALE_WRONG[1] else "error"
    do = "" if within else "calibrate the gyro's scale, or check its unit and range"
    yield Finding("S", level, "gyro scale", f"{scale:.3f}", expected, do)


def judge_lag(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield L: how far the attitude's stamps are behind the gyro's."""
    t = n.turning
    if t is None or n.motion is None or not n.motion.enough or attitude_fault(n):
        return
    expected = f"less than {LAG_OK:g} ms"
    if np.isnan(t.lag_ms):
        yield Finding("L", "info", "attitude lag", "none found within 100 ms", expected)
    elif abs(t.lag_ms) < LAG_OK:
        yield Finding("L", "ok", "attitude lag", f"{t.lag_ms:.0f} ms", expected)
    else:
        do = f"move its stamps by {-t.lag_ms:.0f} ms, or use the stamp of measuring, not of publishing"
        late = "late" if t.lag_ms > 0 else "early"
        yield Finding("L", "warning", f"attitude stamped {late}", f"{t.lag_ms:.0f} ms", expected, do)


def judge_rotation(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield E: whether the vehicle turned enough for the axes to be judged."""
    m = n.motion
    if m is None:
        yield Finding("E", "warning", "no gyro", "no rate", "a gyro stream", "axes, scale and lag are not judged")
        return
    swept = ", ".join(f"{x:.1f}" for x in m.swept_deg)
    got = f"swept ({swept}) deg, fastest half second {m.peak_dps:.1f} deg/s"
    expected = "10 deg about two axes at 5 deg/s or more"
    if not m.enough:
        do = "axes, signs, scale and lag are not judged; turn the vehicle by hand about all axes and record again"
        yield Finding("E", "warning", "not enough rotation", got, expected, do)
    elif m.unchecked:
        yield Finding("E", "info", f"axis {' '.join(m.unchecked)} unchecked", got, "10 deg about all axes")
    else:
        yield Finding("E", "ok", "rotation", got, expected)
