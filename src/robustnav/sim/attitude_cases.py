"""The setting of the published attitude study, and everything in it that we had to assume.

The published cases state duration, frequency and angle bounds only.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin
from typing import NamedTuple

from robustnav.datasheet.presets import imu, magnetometer
from robustnav.sim.batch import Environment, Sensors
from robustnav.sim.sensor_errors import STUDY_ERRORS
from robustnav.sim.trajectory import SineAttitude, case_one, case_two
from robustnav.units import DEG, DPS, MICRO_G, MICRO_TESLA, STANDARD_GRAVITY

IMU = "mpu9250"
MAGNETOMETER = "ak8963"
BIAS_WALK_DPS_RTS = 1e-4
FIELD_UT = 48.0
DIP_DEG = 60.0


class Assumption(NamedTuple):
    """A named value, its unit in the name, and why it was chosen."""

    name: str
    value: float
    why: str


def sensors() -> Sensors:
    """Return the study's sensors: MPU-9250 and AK8963 with white noise and a gyro bias walk, nothing else."""
    unit = imu(IMU)
    gyro = replace(unit.gyro, random_walk=BIAS_WALK_DPS_RTS * DPS)
    return Sensors(replace(unit, gyro=gyro), magnetometer(MAGNETOMETER), STUDY_ERRORS)


def environment() -> Environment:
    """Return the study's gravity and magnetic field, in magnetic-north axes."""
    strength, dip = FIELD_UT * MICRO_TESLA, DIP_DEG * DEG
    return Environment(STANDARD_GRAVITY, (strength * cos(dip), 0.0, strength * sin(dip)))


def assumptions() -> tuple[Assumption, ...]:
    """Return what the study assumes beyond the published text, for its report."""
    one, two, unit = case_one(), case_two(), imu(IMU)
    gyro, accel = _number(unit.gyro.density, DPS), _number(unit.accel.density, MICRO_G)
    mag = _number(magnetometer(MAGNETOMETER).field.noise_rms_sd, MICRO_TESLA)
    optimistic = "the same sheet's total is 8 mg rms where the density gives 3 mg, so this is optimistic"
    return (
        Assumption("rate_hz", one.rate_hz, "not published; usual for the part"),
        *_amplitudes("case_one", one, "not published; below 30 deg"),
        *_amplitudes("case_two", two, "not published; above 30 deg on every axis"),
        Assumption("phase_deg", _number(one.phase[0], DEG), "not published; every angle starts at zero"),
        Assumption("gyro_density_dps_rthz", gyro, f"one-sided, typical, {unit.document}"),
        Assumption("accel_density_ug_rthz", accel, f"one-sided, typical, {unit.document}; {optimistic}"),
        Assumption("mag_sd_ut", mag, "no data sheet states it"),
        Assumption("bias_walk_dps_rts", BIAS_WALK_DPS_RTS, "not published, and no data sheet states it"),
        Assumption("field_ut", FIELD_UT, "not published; mid latitudes"),
        Assumption("dip_deg", DIP_DEG, "not published; mid latitudes"),
        Assumption("gravity_m_s2", STANDARD_GRAVITY, "not published; standard gravity"),
    )


def _amplitudes(case: str, trajectory: SineAttitude, why: str) -> list[Assumption]:
    axes = zip(("roll", "pitch", "yaw"), trajectory.amplitude, strict=True)
    return [Assumption(f"{case}_{axis}_amplitude_deg", _number(value, DEG), why) for axis, value in axes]


def _number(value: float | None, unit: float) -> float:
    """Return a value in a unit, free of the conversion's rounding; NaN when there is none."""
    return float("nan") if value is None else round(value / unit, 12)
