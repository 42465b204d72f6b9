"""Sensors in a word: grades as publications give them, data sheets with what they leave out."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav import datasheet
from robustnav.alignment import AlignSetup
from robustnav.alignment.sensors import setup_of_grade, setup_of_imu
from robustnav.errors import InputError
from robustnav.units import DEG, DEG_PER_HOUR, DPS, MILLI_G


@pytest.mark.parametrize(
    ("text", "gyro", "accel"),
    [
        ("0.01deg/h,0.1mg", 0.01 * DEG_PER_HOUR, 0.1 * MILLI_G),
        (" 1e-2 deg/s , 100 ug", 0.01 * DPS, 0.1 * MILLI_G),
        (".5rad/s,2m/s^2", 0.5, 2.0),
    ],
)
def test_a_grade_is_the_published_setting(text, gyro, accel):
    expected = AlignSetup.published(gyro, accel, 32 * DEG)
    np.testing.assert_allclose(setup_of_grade(text, 32 * DEG).numbers, expected.numbers, rtol=1e-12)


@pytest.mark.parametrize(
    "text", ["", "0.01deg/h", "0.1mg,0.01deg/h", "0deg/h,1mg", "1dps,1mg", "1deg/h,1mg,2", "-1deg/h,1mg"]
)
def test_half_a_grade_is_refused(text):
    with pytest.raises(InputError, match=r"0\.01deg/h,0\.1mg"):
        setup_of_grade(text, 0.0)


@given(st.text("0123456789.,-e dghsmura/^2²", max_size=20))
def test_any_text_is_a_grade_or_refused(text):
    try:
        setup_of_grade(text, 0.5)
    except InputError as why:
        assert "deg/h" in str(why) or "alignment setup" in str(why)


@pytest.mark.parametrize("name", datasheet.names()["imu"])
def test_every_preset_gives_a_setting_and_says_what_it_assumed(name):
    unit = datasheet.imu(name)
    setup, assumed = setup_of_imu(unit, 100.0, 0.5)
    assert setup.gyro_density == pytest.approx(unit.gyro.density / sqrt(2))  # two-sided, as models take it
    assert setup.gyro_bias_sd == unit.gyro.turn_on_bias_sd
    assert len(assumed) == 2 and all(name in words for words in assumed)
    if unit.gyro.bias_instability is None:
        assert setup.gyro_bias_walk * sqrt(60) == pytest.approx(0.01 * setup.gyro_bias_sd)


def test_a_stated_walk_is_taken_and_a_missing_bias_is_not_invented():
    unit = datasheet.imu("adis16470")
    walked = replace(unit, gyro=replace(unit.gyro, random_walk=1e-5))
    setup, assumed = setup_of_imu(walked, 100.0, 0.5)
    assert setup.gyro_bias_walk == 1e-5 and len(assumed) == 1
    with pytest.raises(InputError, match="no turn-on bias"):
        setup_of_imu(replace(unit, accel=replace(unit.accel, turn_on_bias_sd=None)), 100.0, 0.5)
