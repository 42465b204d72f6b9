"""What an alignment is told of its sensors: a data sheet, or one number a sensor as publications give it."""

from __future__ import annotations

import re
from dataclasses import replace
from math import sqrt

from robustnav.alignment.setting import AlignSetup
from robustnav.datasheet import Imu, SensorSpec
from robustnav.errors import InputError
from robustnav.units import DEG_PER_HOUR, DPS, MICRO_G, MILLI_G, STANDARD_GRAVITY

GYRO_UNITS = {"deg/h": DEG_PER_HOUR, "deg/s": DPS, "rad/s": 1.0}
ACCEL_UNITS = {"mg": MILLI_G, "ug": MICRO_G, "g": STANDARD_GRAVITY, "m/s^2": 1.0}
FLICKER = (
    0.664  # Allan deviation of flicker noise at its lowest, over the level of the noise (IEEE Std 952-1997, annex C)
)
WANDER_TIME = 3600.0  # s, correlation time of an in-run bias, as in the published study
WANDER_SHARE, WANDER_MINUTE = 0.01, 60.0  # of the turn-on bias in a minute, where a sheet says nothing
_FIGURE = re.compile(r"\s*([0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?)\s*([a-z/^0-9]+)\s*")


def setup_of_grade(text: str, latitude: float) -> AlignSetup:
    """Return the setting for sensors of a grade, ``AlignSetup.published``.

    Parameters
    ----------
    text : gyro and accelerometer with a comma, as in ``0.01deg/h,0.1mg``; deg/h, deg/s, rad/s; mg, ug, g, m/s^2.
    latitude : [rad].

    Raises
    ------
    InputError : another form, another unit, or a number that is not positive.
    """
    parts = [_FIGURE.fullmatch(part) for part in text.split(",")]
    if len(parts) == 2 and parts[0] and parts[1]:
        (gyro, gyro_unit), (accel, accel_unit) = parts[0].groups(), parts[1].groups()
        if gyro_unit in GYRO_UNITS and accel_unit in ACCEL_UNITS and float(gyro) > 0 and float(accel) > 0:
            rms = float(gyro) * GYRO_UNITS[gyro_unit], float(accel) * ACCEL_UNITS[accel_unit]
            return AlignSetup.published(*rms, latitude)
    raise InputError(
        "sensor grade",
        got=repr(text),
        expected=f"gyro ({', '.join(GYRO_UNITS)}) and accelerometer ({', '.join(ACCEL_UNITS)})",
        do="write both with their units, as in 0.01deg/h,0.1mg",
    )


def setup_of_imu(unit: Imu, rate_hz: float, latitude: float) -> tuple[AlignSetup, tuple[str, ...]]:
    """Return the setting for a unit from its data sheet, and what had to be assumed, in words.

    Parameters
    ----------
    unit : from ``robustnav.datasheet.imu``.
    rate_hz : of its samples.
    latitude : [rad].

    Notes
    -----
    A bias walk that the sheet does not state comes from its bias instability, a Markov bias of an hour; without one the
    bias is taken to wander by a hundredth of the turn-on bias in a minute.

    Raises
    ------
    InputError : the sheet states no turn-on bias.
    """
    numbers, assumed = {}, []
    for sensor, spec in (("gyro", unit.gyro), ("accel", unit.accel)):
        if spec.turn_on_bias_sd is None:
            raise InputError(
                f"data sheet {unit.name!r}, {sensor}",
                got="no turn-on bias",
                expected="a turn-on bias: an alignment starts with the bias unknown",
                do="give a .toml file of your own, or --grade",
            )
        numbers[f"{sensor}_density"] = spec.sample_sd(rate_hz) / sqrt(rate_hz)
        numbers[f"{sensor}_bias_sd"] = spec.turn_on_bias_sd
        numbers[f"{sensor}_bias_walk"], words = _walk(spec, spec.turn_on_bias_sd)
        if words:
            assumed.append(f"{unit.name}, {sensor}: {words}")
    return replace(AlignSetup.published(1.0, 1.0, latitude), **numbers), tuple(assumed)


def _walk(spec: SensorSpec, turn_on: float) -> tuple[float, str]:
    if spec.random_walk is not None:
        return spec.random_walk, ""
    if spec.bias_instability is not None:
        walk = spec.bias_instability / FLICKER * sqrt(2 / WANDER_TIME)
        return walk, "the bias walk is not stated; taken from its bias instability over an hour"
    walk = WANDER_SHARE * turn_on / sqrt(WANDER_MINUTE)
    return walk, "no bias walk or instability is stated; 1 % of the turn-on bias in a minute is taken"
