"""Units against their definitions; the expected numbers are written out, not computed from the module."""

import math

import pytest

from robustnav import units

DEFINITIONS = {
    "DEG": 0.017453292519943295,
    "ARCMIN": 0.0002908882086657216,
    "DPS": 0.017453292519943295,
    "DEG_PER_HOUR": 4.84813681109536e-06,
    "STANDARD_GRAVITY": 9.80665,
    "MILLI_G": 9.80665e-3,
    "MICRO_G": 9.80665e-6,
    "KNOT": 0.5144444444444445,
    "KILOMETRE_PER_HOUR": 0.2777777777777778,
    "GAUSS": 1e-4,
    "MILLI_GAUSS": 1e-7,
    "MICRO_TESLA": 1e-6,
    "NANO_TESLA": 1e-9,
    "MS": 1e-3,
    "US": 1e-6,
}


@pytest.mark.parametrize(("name", "value"), DEFINITIONS.items())
def test_each_unit_is_its_definition(name, value):
    assert getattr(units, name) == pytest.approx(value, rel=1e-15)


def test_no_unit_is_left_out_above():
    assert {n for n in vars(units) if n.isupper()} == set(DEFINITIONS)


def test_multiply_in_divide_out():
    assert math.pi / units.DEG == pytest.approx(180, rel=1e-15)
    assert pytest.approx(7.292115e-5, rel=1e-6) == 15.041067 * units.DEG_PER_HOUR  # the Earth's rate
    assert pytest.approx(50 * units.MICRO_TESLA, rel=1e-15) == 500 * units.MILLI_GAUSS
