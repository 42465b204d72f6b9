"""One alignment as pages and tables take it: what was said over time, what it was held against, the verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Protocol

import numpy as np

from robustnav.frames import euler_from_quat, matrix_from_quat
from robustnav.records import Array, BoolArray
from robustnav.report.figures.alignment import RateUnit
from robustnav.report.page import Level
from robustnav.units import ARCMIN, DEG, DEG_PER_HOUR, DPS, MILLI_G

RADIUS_95, ONE_AXIS_95 = 2.4477, 1.96  # of a plane and of a single normal distribution, in standard deviations
TRUSTED = 0.9  # of the radius that the accelerometer's bias leaves: a base at rest can hardly tell more
FAR_OFF = 4.0  # standard deviations of a heading: one in ten thousand by chance
FAR_BEYOND = 1.5  # times the radius claimed: one in a thousand by chance
FINE_GYRO = 1e-3 * DPS  # below, biases are shown in deg/h
OPEN = 0.5  # rad, heading sd beyond which nothing is known


class Course(Protocol):
    """What an estimator said after each of n readings, NaN where nothing; ``robustnav.alignment.Alignment`` is one."""

    @property
    def t(self) -> Array:
        """Times (n,) [s]."""

    @property
    def q_nb(self) -> Array:
        """Attitude (n, 4), heading included even where it is not observable."""

    @property
    def tilt_radius(self) -> Array:
        """Radius (n,) within which tilt is with 95 % [rad]."""

    @property
    def heading(self) -> Array:
        """Of the forward axis (n,) [rad]."""

    @property
    def heading_sd(self) -> Array:
        """Standard deviation (n,) [rad]."""

    @property
    def heading_observable(self) -> BoolArray:
        """Whether the heading is known at all (n,)."""

    @property
    def gyro_bias(self) -> Array:
        """In body axes (n, 3) [rad/s]."""

    @property
    def accel_bias(self) -> Array:
        """In body axes (n, 3) [m/s^2]."""

    @property
    def wind(self) -> Array:
        """What the reference shows besides noise, north and east (n, 2) [m/s]."""

    @property
    def tilt_goal(self) -> float:
        """Radius aimed at [rad]; NaN where none is."""

    @property
    def aligned_at(self) -> float:
        """When the radius was first within the goal, or in motion the heading found [s]; NaN if never."""


@dataclass(frozen=True)
class Against:
    """What an alignment was held against; NaN where there is no truth.

    ``tilt`` (n,) size of the error [rad]; ``heading`` (n,) the true one and ``heading_error`` (n,), true minus
    estimated [rad]; true ``gyro_bias``, ``accel_bias`` (n, 3) and ``wind`` (n, 2), or None.
    """

    tilt: Array
    heading: Array
    heading_error: Array
    gyro_bias: Array | None = None
    accel_bias: Array | None = None
    wind: Array | None = None


@dataclass(frozen=True)
class Route:
    """Where a carrier was [m]: ``p_n`` (n, 3), ``fixes`` (k, 3) of its receiver, ``p_true`` (m, 3) or None."""

    p_n: Array
    fixes: Array
    p_true: Array | None = None


@dataclass(frozen=True)
class Aligned:
    """One alignment.

    Parameters
    ----------
    source : what was aligned.
    said : over time.
    reference : (n, 2) velocity readings north and east [m/s]; NaN where missing.
    gyro_bias_sd : one axis at the start [rad/s].
    heading_floor : heading sd [rad] that this bias leaves on a base at rest; NaN in motion.
    tilt_floor : tilt sd [rad] that the accelerometer's bias leaves there; NaN in motion.
    route : of a carrier in motion; None: it is moored or at rest.
    wind_words, wind : what disturbed the reference, in words and as numbers; empty where it was not looked for.
    against : the truth, or None.
    events, settings, command : what was left out, what is needed to repeat it.
    """

    source: str
    said: Course
    reference: Array
    gyro_bias_sd: float
    heading_floor: float
    tilt_floor: float
    wind_words: str = ""
    wind: Mapping[str, object] = field(default_factory=dict)
    against: Against | None = None
    route: Route | None = None
    events: tuple[str, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    command: str = ""

    @property
    def begin(self) -> float:
        """When the first period began [s]."""
        t = self.said.t
        return float(2 * t[0] - t[1])

    @property
    def duration(self) -> float:
        """How long it took [s]."""
        return float(self.said.t[-1]) - self.begin

    @property
    def waited(self) -> float:
        """How long until it was aligned [s]; NaN if it never was."""
        return self.said.aligned_at - self.begin


def judge(run: Aligned) -> tuple[Level, str, tuple[str, ...]]:
    """Return the verdict: ``error`` where it never aligned or the truth is far outside what it claims; its reasons."""
    text, failures, doubts = _judge_moored(run) if run.route is None else _judge_moving(run)
    if run.against is not None and run.against.tilt[-1] > FAR_BEYOND * run.said.tilt_radius[-1]:
        failures.append(f"The tilt is off by {arcmin(run.against.tilt[-1])}, far more than claimed.")
    level: Level = "error" if failures else "warning" if doubts else "ok"
    return level, f"{text}; {heading_words(run)}.", (*failures, *doubts)


def _judge_moored(run: Aligned) -> tuple[str, list[str], list[str]]:
    said, radius = run.said, run.said.tilt_radius[-1]
    goal = f"{said.tilt_goal / ARCMIN:g} arcmin"
    failures, doubts, floor = [], [], RADIUS_95 * run.tilt_floor
    if np.isnan(said.aligned_at):
        text = f"never aligned: after {run.duration:.1f} s tilt is within {arcmin(radius)} with 95 %, not {goal}"
        if floor > said.tilt_goal:
            failures.append(f"The accelerometer's bias alone leaves {arcmin(floor)} with 95 %: calibrate it.")
        else:
            failures.append("More time or a calmer reference is needed.")
    else:
        text = f"aligned after {run.waited:.1f} s: tilt within {goal} with 95 %, at the end {arcmin(radius)}"
        if radius > said.tilt_goal:
            doubts.append(f"At the end the goal of {goal} is no longer met.")
    if radius < TRUSTED * floor:
        doubts.append(
            f"The tilt claimed is less than the accelerometer's bias alone leaves, {arcmin(floor)} with 95 %: do not "
            "rely on it with sensors of this grade."
        )
    if matrix_from_quat(said.q_nb[-1])[2, 2] < 0:
        doubts.append("The unit stands upside down: is the accelerometer's sign that of specific force, -g when level?")
    return text, failures, doubts


def _judge_moving(run: Aligned) -> tuple[str, list[str], list[str]]:
    said, within = run.said, f"tilt within {arcmin(run.said.tilt_radius[-1])} with 95 %"
    failures, doubts = [], []
    if np.isnan(said.aligned_at):
        text = f"heading never found in {run.duration:.1f} s; at the end {within}"
        failures.append("It shows when the carrier speeds up, brakes or turns: it takes more of that.")
    else:
        text = f"heading found after {run.waited:.1f} s; at the end {within}"
        if not said.heading_observable[-1]:
            doubts.append("At the end the heading is no longer known as well as when it was found.")
    if run.against is not None and abs(off := run.against.heading_error[-1]) > FAR_OFF * said.heading_sd[-1]:
        failures.append(f"The heading is off by {off / DEG:.3g} deg, far more than claimed.")
    return text, failures, doubts


def heading_words(run: Aligned) -> str:
    """Say what is known of the heading."""
    said, floor = run.said, run.heading_floor
    if said.heading_observable[-1]:
        return f"heading {said.heading[-1] / DEG:.2f} deg, within {ONE_AXIS_95 * said.heading_sd[-1] / DEG:.2f} deg"
    if run.route is not None:
        return f"heading not known: its standard deviation is {said.heading_sd[-1] / DEG:.0f} deg"
    unit = gyro_unit(run.gyro_bias_sd)
    bias = f"{run.gyro_bias_sd / unit.size:.3g} {unit.name}"
    left = (
        f"{floor / DEG:.2g} deg" if floor < OPEN else f"{floor / DEG:.0f} deg" if floor < pi else "every heading open"
    )
    return f"heading not observable{' yet' if floor < OPEN else ''}: a gyro bias of {bias} leaves {left}"


def angle_rows(run: Aligned) -> list[dict[str, object]]:
    """Return roll, pitch and heading at the end with what they are within, one row each.

    Roll and pitch have the larger axis of the tilt's covariance, and roll grows with pitch.
    """
    said, angles = run.said, euler_from_quat(run.said.q_nb[-1])
    tilt = float(said.tilt_radius[-1]) / RADIUS_95 * ONE_AXIS_95
    within = (min(tilt / max(abs(float(np.cos(angles[1]))), 1e-9), pi), tilt, ONE_AXIS_95 * float(said.heading_sd[-1]))
    rows: list[dict[str, object]] = [
        {"angle": name, "value_deg": float(angle) / DEG, "within_deg": size / DEG}
        for name, angle, size in zip(("roll", "pitch", "heading"), angles, within, strict=True)
    ]
    if not said.heading_observable[-1]:
        rows[-1] |= {"value_deg": None, "within_deg": None}
    return rows


def bias_rows(run: Aligned) -> list[dict[str, object]]:
    """Return the biases at the end, with the true ones where they are known, one row an axis."""
    truth, unit = run.against, gyro_unit(run.gyro_bias_sd)
    size, name, rows = unit.size, f"gyro_bias,_{unit.name}", []
    for k, axis in enumerate("xyz"):
        row: dict[str, object] = {"axis": axis, name: float(run.said.gyro_bias[-1, k]) / size}
        if truth is not None and truth.gyro_bias is not None:
            row[f"true_{name}"] = float(truth.gyro_bias[-1, k]) / size
        row["accel_bias,_mg"] = float(run.said.accel_bias[-1, k]) / MILLI_G
        if truth is not None and truth.accel_bias is not None:
            row["true_accel_bias,_mg"] = float(truth.accel_bias[-1, k]) / MILLI_G
        rows.append(row)
    return rows


def truth_row(run: Aligned) -> dict[str, object]:
    """Return the errors against the truth: at the end, and their rms over the last quarter; empty without a truth."""
    if run.against is None:
        return {}
    last = slice(-(-3 * len(run.said.t) // 4), None)
    tilt, heading = run.against.tilt, run.against.heading_error
    row: dict[str, object] = {"tilt_arcmin": float(tilt[-1]) / ARCMIN, "tilt_rms_arcmin": _rms(tilt[last]) / ARCMIN}
    if run.said.heading_observable[-1]:
        row |= {"heading_deg": float(heading[-1]) / DEG, "heading_rms_deg": _rms(heading[last]) / DEG}
    return row


def arcmin(angle: float) -> str:
    """Return an angle [rad] in words: arc minutes, degrees where it is large."""
    return f"{angle / ARCMIN:#.3g} arcmin" if angle < DEG else f"{angle / DEG:.3g} deg"


def gyro_unit(bias: float) -> RateUnit:
    """Return the unit that suits gyro biases of the given size [rad/s]."""
    return RateUnit("deg/h", DEG_PER_HOUR) if bias < FINE_GYRO else RateUnit("deg/s", DPS)


def _rms(values: Array) -> float:
    known = values[~np.isnan(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")
