"""Noise figures of the attitude models: from data sheets, and widened for a carrier that moves."""

from math import sqrt

import pytest

from robustnav.datasheet import imu, magnetometer
from robustnav.errors import InputError
from robustnav.models import AttitudeNoise

QUIET = AttitudeNoise(1e-5, 1e-7, 0.01, 1e-8)
FIELD = 5e-5


def test_a_data_sheet_gives_a_samples_noise_at_its_rate():
    noise = AttitudeNoise.from_datasheet("mpu9250", "ak8963", 100.0, gyro_bias_density=2e-6)
    unit, field = imu("mpu9250"), magnetometer("ak8963")
    assert noise.gyro_density * sqrt(100) == pytest.approx(unit.gyro.sample_sd(100.0))
    assert noise.gyro_density == pytest.approx(unit.gyro.density / sqrt(2))  # the sheet's is one-sided
    assert noise.accel_sd == unit.accel.sample_sd(100.0)
    assert noise.mag_sd == field.field.sample_sd(100.0)
    assert noise.gyro_bias_density == 2e-6
    own = AttitudeNoise.from_datasheet("mpu9250", "ak8963", 100.0, gyro_bias_density=0.0, mag_sd=3e-7)
    assert own.mag_sd == 3e-7


def test_an_unknown_sensor_is_named():
    with pytest.raises(InputError, match="mpu9999"):
        AttitudeNoise.from_datasheet("mpu9999", "ak8963", 100.0, gyro_bias_density=0.0)


def test_motion_weighs_the_same_at_every_sample_rate():
    """Information a second, 1 / (sd^2 dt), must not grow with the rate: the carrier's motion is no white noise."""
    slow, fast = QUIET.moving(50.0, 10.0, FIELD), QUIET.moving(400.0, 100.0, FIELD)
    assert slow.accel_sd**2 / 50 == pytest.approx(fast.accel_sd**2 / 400)
    assert slow.mag_sd**2 / 10 == pytest.approx(fast.mag_sd**2 / 100)
    assert (slow.gyro_density, slow.gyro_scale_density) == (fast.gyro_density, fast.gyro_scale_density)


def test_motion_never_makes_a_sensor_better():
    loud = AttitudeNoise(1.0, 1.0, 100.0, 1.0, 1.0)
    assert loud.moving(100.0, 100.0, FIELD) == loud


def test_a_turn_adds_in_squares():
    noise = AttitudeNoise(3e-3, 0.0, 1.0, 1.0, gyro_scale_density=2e-3)
    assert noise.turning(2.0).gyro_density == pytest.approx(5e-3)
    assert noise.turning(0.0) == noise
