"""From what ``align`` is given, a recording or a simulated carrier, to one alignment and what it is held against."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import hypot, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robustnav.cli.alignment_options import Carrier, Part, Reference, Simulated
from robustnav.errors import InputError
from robustnav.units import DEG, DEG_PER_HOUR, MILLI_G

if TYPE_CHECKING:
    from robustnav.alignment import Alignment, AlignSetup
    from robustnav.records import Array, Log, Truth
    from robustnav.report.alignment_course import Against, Aligned, Course
    from robustnav.sim.alignment_scenario import Scenario

STAGES = 3  # of the progress bar: read or simulate, cut, align
GUST_SD, GUST_SHARE = 3.0, 0.05  # m/s and share of readings, as in the published setting


def recorded(path: Path, carrier: Carrier, given: Reference, part: Part, step: Callable[[], None]) -> Aligned:
    """Align a recording; ``step`` is called after each stage."""
    from robustnav.alignment import align
    from robustnav.alignment.recording import readings_of
    from robustnav.logs.reading import read

    log = read(path, part.mapping)
    step()
    latitude = place_of(log, carrier.latitude, "latitude_deg") * DEG
    height = carrier.height if carrier.height is not None else float(log.info.get("height_m", 0.0))
    if given.reference == "velocity" and "velocity" not in log.streams:
        raise InputError(
            "no reference velocity",
            place=log.source,
            got=f"streams {', '.join(log.streams)}",
            expected="a stream velocity, north and east, as in columns velocity_north_m_s, velocity_east_m_s",
            do="--reference zero for a base at rest without one",
        )
    start, stop = (-np.inf if part.start is None else part.start), (np.inf if part.stop is None else part.stop)
    readings = readings_of(log.between(start, stop), part.period, longest=part.longest)
    step()
    base, sensors, assumed = sensors_of(carrier, readings.rate_hz, latitude)
    setup = _setup(base, (latitude, height), log, given, part.period)
    still = given.reference == "zero"
    field_b = None if setup.declination is None else readings.field_b
    said = align(readings.increments, None if still else readings.reference, readings.t, setup, field_b=field_b)
    step()
    if still:
        readings = replace(readings, reference=np.full_like(readings.reference, np.nan))
    against = None if log.truth is None or log.truth.q_nb is None else against_truth(said, log.truth)
    events = (*readings.events, *assumed)
    rate_hz = round(readings.rate_hz, 6)
    about = {"sensors": sensors, "reference": given.reference, "height_m": height, "imu_rate_hz": rate_hz}
    return _aligned(log.source, said, readings.reference, setup, against=against, events=events, about=about)


def simulated(given: Simulated, step: Callable[[], None]) -> Aligned:
    """Align a simulated carrier and hold it against its truth; ``step`` is called after each stage."""
    from robustnav.alignment import align
    from robustnav.engine.strapdown import preintegrate
    from robustnav.sim.alignment import simulate_alignment

    scenario = scenario_of(given)
    setup = setup_of(scenario)
    step()
    data = simulate_alignment(scenario, given.seed, preintegrate)
    step()
    readings = data.velocity.values[:, :2]
    said = align(data.increments, readings, data.velocity.t, setup)
    step()
    truth = replace(
        against_truth(said, data.truth),
        gyro_bias=data.gyro_bias[:-1],
        accel_bias=data.accel_bias[:-1],
        wind=data.wind_n[:, :2],
    )
    about = {"scenario": scenario.name, "seed": given.seed, "height_m": scenario.height}
    source = f"{scenario.name}, seed {given.seed}"
    return _aligned(source, said, readings, setup, against=truth, events=(), about=about)


def scenario_of(given: Simulated) -> Scenario:
    """Return the scenario that was asked for, by name or file."""
    from robustnav.sim.alignment import load_scenario, scenario_names

    if given.scenario is None:
        raise InputError("no scenario", expected=f"one of {', '.join(scenario_names())}, or a .toml file")
    return load_scenario(given.scenario, given.wind)


def setup_of(scenario: Scenario) -> AlignSetup:
    """Return what an alignment is told of a scenario: place, sensors, the reference's noise; not the wind or start."""
    from robustnav.alignment import AlignSetup

    gyro, accel, dt = scenario.gyro, scenario.accel, 1 / scenario.imu_rate_hz
    return AlignSetup(
        period=1 / scenario.filter_rate_hz,
        latitude=scenario.latitude,
        gravity=float(scenario.place.gravity_n[2]),
        gyro_density=gyro.white_sd * sqrt(dt),
        gyro_bias_sd=hypot(gyro.bias, gyro.markov_sd),
        gyro_bias_walk=gyro.markov_sd * sqrt(2 / gyro.markov_time),
        accel_density=accel.white_sd * sqrt(dt),
        accel_bias_sd=hypot(accel.bias, accel.markov_sd),
        accel_bias_walk=accel.markov_sd * sqrt(2 / accel.markov_time),
        reference_sd=scenario.velocity_sd,
        gust_sd=GUST_SD,
        gust_share=GUST_SHARE,
    )


def place_of(log: Log, given: float | None, name: str) -> float:
    """Return a number of the place [deg]: the one given, or else the recording's own."""
    own = log.info.get(name)
    if given is None and not isinstance(own, float | int):
        word = name.removesuffix("_deg")
        raise InputError(
            word, place=log.source, got="none given, none in the recording", expected="degrees", do=f"--{word} DEG"
        )
    return float(own if given is None else given)  # type: ignore[arg-type]


def sensors_of(carrier: Carrier, rate_hz: float, latitude: float) -> tuple[AlignSetup, str, tuple[str, ...]]:
    """Return a setting that holds the sensors' numbers, their name, and what had to be assumed of them."""
    from robustnav import datasheet
    from robustnav.alignment.sensors import setup_of_grade, setup_of_imu

    if (carrier.imu is None) == (carrier.grade is None):
        raise InputError(
            "inertial sensors",
            got="both --imu and --grade" if carrier.imu else "neither --imu nor --grade",
            expected="one of them: how good they are decides what can be found",
            do=f"--imu {'|'.join(datasheet.names()['imu'])}, or --grade 0.01deg/h,0.1mg",
        )
    if carrier.grade is not None:
        return setup_of_grade(carrier.grade, latitude), carrier.grade, ()
    unit = datasheet.imu(str(carrier.imu))
    setup, assumed = setup_of_imu(unit, rate_hz, latitude)
    return setup, unit.name, assumed


def _setup(base: AlignSetup, place: tuple[float, float], log: Log, given: Reference, period: float) -> AlignSetup:
    from robustnav.earth import normal_gravity

    if not abs(place[1]) < 1e5:
        raise InputError("--height", got=f"{place[1]:g} m", expected="metres above the ellipsoid, within 100 km of it")
    setup = replace(base, period=period, gravity=normal_gravity(*place), reference_sd=given.reference_sd)
    if not given.compass:
        return setup
    log.stream("mag")
    return replace(
        setup,
        declination=place_of(log, given.declination, "declination_deg") * DEG,
        compass_sd=given.compass_sd * DEG,
        compass_bias_sd=given.compass_bias_sd * DEG,
    )


def against_truth(said: Course, truth: Truth) -> Against:
    """Hold an alignment against a truth's attitude; its heading only where that is from true north."""
    from robustnav.evaluate.reference import reference_at
    from robustnav.frames import euler_from_quat
    from robustnav.report.alignment_course import Against
    from robustnav.studies.alignment_errors import heading_error, tilt_error

    q_true = reference_at(truth, said.t).q_nb
    known = 1.0 if truth.north == "true" else np.nan
    return Against(
        tilt=np.linalg.norm(tilt_error(q_true, said.q_nb), axis=1),
        heading=euler_from_quat(q_true)[:, 2] * known,
        heading_error=heading_error(q_true, said.q_nb) * known,
    )


def _aligned(
    source: str,
    said: Alignment,
    reference: Array,
    setup: AlignSetup,
    *,
    against: Against | None,
    events: tuple[str, ...],
    about: Mapping[str, object],
) -> Aligned:
    from robustnav.alignment.disturbance import disturbance_of
    from robustnav.report.alignment_course import Aligned

    wind = disturbance_of(reference, setup)
    return Aligned(
        source=source,
        said=said,
        reference=reference,
        gyro_bias_sd=setup.gyro_bias_sd,
        heading_floor=setup.heading_floor,
        tilt_floor=setup.accel_bias_sd / setup.gravity,
        wind_words="" if wind is None else wind.words,
        wind={} if wind is None else vars(wind),
        against=against,
        events=events,
        settings={**about, **_shown(setup)},
    )


def _shown(setup: AlignSetup) -> dict[str, object]:
    """Return the setting for people, unit in every name."""
    numbers = {
        "period_s": setup.period,
        "latitude_deg": setup.latitude / DEG,
        "gravity_m_s2": setup.gravity,
        "gyro_density_rad_s_rthz": setup.gyro_density,
        "gyro_bias_sd_deg_h": setup.gyro_bias_sd / DEG_PER_HOUR,
        "gyro_bias_walk_rad_s_rts": setup.gyro_bias_walk,
        "accel_density_m_s2_rthz": setup.accel_density,
        "accel_bias_sd_mg": setup.accel_bias_sd / MILLI_G,
        "accel_bias_walk_m_s2_rts": setup.accel_bias_walk,
        "reference_sd_m_s": setup.reference_sd,
        "gust_sd_m_s": setup.gust_sd,
        "gust_share": setup.gust_share,
    }
    if setup.declination is not None and setup.compass_sd is not None and setup.compass_bias_sd is not None:
        numbers |= {
            "declination_deg": setup.declination / DEG,
            "compass_sd_deg": setup.compass_sd / DEG,
            "compass_bias_sd_deg": setup.compass_bias_sd / DEG,
        }
    return {name: float(f"{value:.6g}") for name, value in numbers.items()}
