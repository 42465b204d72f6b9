"""From what ``align --reference gnss`` is given to one alignment of a carrier in motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robustnav.cli.alignment_case import against_truth, place_of, sensors_of
from robustnav.cli.alignment_options import REFERENCE, Carrier, Part, Reference, Satellites
from robustnav.errors import InputError
from robustnav.units import DEG

if TYPE_CHECKING:
    from robustnav.records import Array, Log, Run
    from robustnav.report.alignment_course import Aligned, Route
    from robustnav.run.moving_setting import GnssAiding, InertialUnit

CLAIMS = {"velocity": ("gnss_speed_sd_m_s",), "position": ("gnss_horizontal_sd_m", "gnss_vertical_sd_m")}


def recorded_in_motion(
    path: Path, options: tuple[Carrier, Reference, Satellites, Part], step: Callable[[], None]
) -> Aligned:
    """Align the recording of a carrier in motion; ``step`` is called after each stage."""
    from robustnav.logs.reading import read
    from robustnav.report.alignment_course import Aligned
    from robustnav.report.moving_course import moving_course
    from robustnav.run.moving import align_moving
    from robustnav.run.moving_setting import MovingStart

    carrier, reference, satellites, part = options
    _refuse(reference, part)
    log = _placed(read(path, part.mapping), carrier)
    start, stop = (-np.inf if part.start is None else part.start), (np.inf if part.stop is None else part.stop)
    log = log.between(start, stop)
    step()
    aiding, claimed = _aiding(log, satellites)
    if reference.compass:
        log.stream("mag")
        declination = place_of(log, reference.declination, "declination_deg") * DEG
        aiding = replace(aiding, heading_sd=satellites.heading_sd * DEG, declination=declination)
    unit, sensors, assumed = _unit(log, carrier, satellites)
    step()
    settings = MovingStart()
    run = align_moving(log, unit, aiding, settings)
    said = moving_course(run, float(log.stream("gyro").t[0]), part.period, settings.found_sd)
    step()
    truth = log.truth
    return Aligned(
        source=log.source,
        said=said,
        reference=_readings(log, aiding),
        gyro_bias_sd=unit.gyro_bias_sd,
        heading_floor=np.nan,
        tilt_floor=np.nan,
        against=None if truth is None or truth.q_nb is None else against_truth(said, truth),
        route=_route(log, aiding, said.p_n),
        events=(*run.events, *claimed, *assumed),
        settings={"sensors": sensors, "reference": "gnss", **_shown(unit, aiding), **_used(run)},
    )


def _refuse(reference: Reference, part: Part) -> None:
    """Refuse options that say nothing of a carrier in motion."""
    for name in ("reference_sd", "compass_sd", "compass_bias_sd"):
        if getattr(reference, name) != getattr(REFERENCE, name):
            raise InputError(
                f"option --{name.replace('_', '-')}",
                got="--reference gnss",
                expected="--velocity-sd, --position-sd and --heading-sd",
            )
    if part.longest:
        raise InputError("option --longest", got="--reference gnss", expected="a gap in motion is bridged, not cut")
    if not 0.01 <= part.period <= 10:
        raise InputError("--period", got=f"{part.period:g} s", expected="0.01 to 10 s between two rows of the answer")


def _placed(log: Log, carrier: Carrier) -> Log:
    """Return the log with the place that was given."""
    given = {"latitude_deg": carrier.latitude, "height_m": carrier.height}
    return replace(log, info={**log.info, **{name: value for name, value in given.items() if value is not None}})


def _aiding(log: Log, given: Satellites) -> tuple[GnssAiding, list[str]]:
    """Return what is known of the receiver, and in words what was taken from its own claims."""
    from robustnav.run.moving_setting import GnssAiding

    sd, words = {"velocity": given.velocity_sd, "position": given.position_sd}, []
    for name, claims in CLAIMS.items():
        said = [float(log.info[claim]) for claim in claims if claim in log.info]
        if sd[name] is None and f"gnss_{name}" in log.streams and len(said) == len(claims):
            sd[name] = max(said)
            words.append(f"{name} sd {max(said):.3g}, as the receiver claims of itself")
    if sd["velocity"] is None and sd["position"] is None:
        raise InputError(
            "noise of the satellite receiver",
            place=log.source,
            got=f"none given, none in the recording; streams {', '.join(log.streams)}",
            expected="that of gnss_velocity, gnss_position or both",
            do="--velocity-sd 0.1 --position-sd 1.5, say",
        )
    lever_b = (0.0, 0.0, 0.0) if given.lever is None else _lever(given.lever)
    return GnssAiding(sd["velocity"], sd["position"], lever_b=lever_b, delay=given.delay), words


def _lever(text: str) -> tuple[float, float, float]:
    try:
        forward, right, down = (float(part) for part in text.split(","))
    except ValueError as why:
        raise InputError("--lever", got=repr(text), expected="three metres, as in 0.3,-0.2,-0.5") from why
    return forward, right, down


def _unit(log: Log, carrier: Carrier, given: Satellites) -> tuple[InertialUnit, str, tuple[str, ...]]:
    from robustnav.models.inertial import InertialNoise
    from robustnav.run.moving_setting import InertialUnit

    t = log.stream("gyro").t
    if len(t) < 2 or not t[-1] > t[0]:
        raise InputError("stream 'gyro'", place=log.source, got=f"{len(t)} samples", expected="two or more")
    rate_hz = (len(t) - 1) / float(t[-1] - t[0])
    setup, name, assumed = sensors_of(carrier, rate_hz, 0.0)
    noise = InertialNoise(setup.gyro_density, setup.accel_density, setup.gyro_bias_walk, setup.accel_bias_walk)
    gyro = setup.gyro_bias_sd if given.gyro_bias_sd is None else given.gyro_bias_sd * DEG
    accel = setup.accel_bias_sd if given.accel_bias_sd is None else given.accel_bias_sd
    return InertialUnit(noise, gyro, accel), name, assumed


def _readings(log: Log, aiding: GnssAiding) -> Array:
    """Return the readings (k, 2) that most of the heading comes from: velocities, or else positions."""
    velocities = aiding.velocity_sd is not None and "gnss_velocity" in log.streams
    readings: Array = log.stream("gnss_velocity" if velocities else "gnss_position").values[:, :2]
    return readings


def _route(log: Log, aiding: GnssAiding, p_n: Array) -> Route:
    from robustnav.report.alignment_course import Route

    if aiding.position_sd is None or "gnss_position" not in log.streams:
        return Route(p_n, np.zeros((0, 3)))  # counted from the start: a truth is elsewhere
    return Route(p_n, log.stream("gnss_position").values, None if log.truth is None else log.truth.p_n)


def _used(run: Run) -> dict[str, object]:
    """Return the run's settings but for sensors of the model that the recording does not have."""
    fused = tuple(f"{name} sd" for name in run.innovations)
    unused = {name for name in run.settings if " sd [" in name and not name.startswith(fused)} | {"time_offset"}
    return {name: value for name, value in run.settings.items() if name not in unused}


def _shown(unit: InertialUnit, aiding: GnssAiding) -> dict[str, object]:
    """Return for people what the model's own settings do not say."""
    return {
        "gyro_bias_sd_deg_s": unit.gyro_bias_sd / DEG,
        "accel_bias_sd_m_s2": unit.accel_bias_sd,
        "lever_b_m": ", ".join(f"{v:g}" for v in aiding.lever_b),
        "delay_s": aiding.delay,
    }
