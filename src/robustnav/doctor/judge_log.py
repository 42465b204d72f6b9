"""H, N, R, M, I in words: what the recording as a whole can and cannot prove."""

from __future__ import annotations

from collections.abc import Iterator

from robustnav.doctor.measure import STANDING, Numbers
from robustnav.doctor.record import Finding
from robustnav.records import Log

HEADING_SLIP, HEADING_RATE = 5.0, 0.1  # deg, and deg/s left for the gyro's bias
LITTLE_MOTION = 0.2  # share of samples above 10 deg/s


def judge_heading(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield H: a heading that moves while the gyro says the vehicle stands."""
    h = n.heading
    if h is None:
        return
    got = f"the log's heading moves {h.attitude_deg:.1f} deg in {h.still_s:.1f} s at rest, the gyro {h.gyro_deg:.2f}"
    if abs(h.attitude_deg - h.unbiased_deg) > HEADING_SLIP + HEADING_RATE * h.still_s:
        do = "do not compare headings with this estimate; its gyro bias or its magnetometer is wrong"
        yield Finding("H", "error", "heading of the log's own estimate", got, "no motion at rest", do)
    else:
        yield Finding("H", "ok", "heading of the log's own estimate", got, "no motion at rest")


def judge_reference(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield N and R: which north, and whether there is a truth to compare with."""
    if log.truth is not None and log.truth.q_nb is not None:
        if n.turned_deg is not None and n.turned_deg < STANDING:
            got = f"constant: it turns {n.turned_deg:.3f} deg"
            do = "it can judge standing still only"
            yield Finding("R", "warning", f"truth, {log.truth.kind}", got, "a reference that moves", do)
        else:
            yield Finding("R", "ok", f"truth, {log.truth.kind}, {log.truth.north} north", log.truth.accuracy)
    elif log.estimate is not None:
        if log.estimate.north == "magnetic":
            do = "set the declination of the place; headings refer to magnetic north"
            yield Finding("N", "warning", "no declination", "none set, or zero", "the declination of the place", do)
        maker = log.info.get("estimator")
        got = f"another estimate, {maker}" if maker else log.estimate.accuracy or "another estimate"
        do = "differences to it are no errors; record optical or simulated truth to measure accuracy"
        yield Finding("R", "warning", "the log's own attitude is no truth", got, "a reference", do)
    else:
        yield Finding("R", "info", "no attitude in the log", "", "", "consistency can be judged, accuracy cannot")


def judge_motion(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield M: how much of the recording is motion."""
    m = n.motion
    if m is None or not m.enough:
        return
    got = f"{100 * m.moving_share:.1f} % above 10 deg/s, from {m.moving_from_s:.1f} to {m.moving_to_s:.1f} s"
    if m.moving_share < LITTLE_MOTION:
        do = "score the motion apart, and see that no settling time cuts it away"
        yield Finding("M", "warning", "little motion", got, f"{100 * LITTLE_MOTION:.0f} % or more", do)
    else:
        yield Finding("M", "ok", "motion", got)


def judge_notes(log: Log, n: Numbers) -> Iterator[Finding]:
    """Yield I: what the reader left out, and what the file says of lost data."""
    incomplete = log.info.get("incomplete")
    if incomplete:
        do = "copy the recording again, or judge only what is left"
        yield Finding("I", "warning", "incomplete file", str(incomplete), "a whole file", do)
    for line in log.skipped:
        if line != incomplete:
            yield Finding("I", "info", "left out", line)
    if "dropouts" in log.info:
        got = f"{log.info['dropouts']:g} records, {log.info.get('dropout_ms', 0):g} ms"
        yield Finding("I", "info", "logger dropouts", got)
    levels = [log.info.get(key) for key in ("board_level_x_deg", "board_level_y_deg")]
    if any(isinstance(level, float) and abs(level) > 0.01 for level in levels):
        got = "x {:.2f}, y {:.2f} deg".format(*(float(level or 0.0) for level in levels))
        yield Finding("I", "info", "board levelling already applied", got)
