"""The ranging model's own claims: a velocity that forgets itself, options that exclude each other."""

import numpy as np
import pytest

from robustnav.engine.backends import functions_of
from robustnav.errors import InputError
from robustnav.models import CARRIERS, RADIOS, RangeBias, uwb, uwb_of


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_velocity_with_a_speed_settles_at_it(dimensions):
    model = uwb(range_sd=0.1, acceleration_density=0.6, dimensions=dimensions, speed=1.5)
    functions, n = functions_of(model), dimensions
    x, P = np.zeros(2 * n), np.zeros((2 * n, 2 * n))
    for _ in range(4000):
        F, Q = functions.transition(x, np.zeros(0), 0.05)
        P = F @ P @ F.T + Q
    np.testing.assert_allclose(np.sqrt(np.diag(P)[n : n + 2]), 1.5, rtol=1e-3)
    slowed = functions.propagate(np.r_[np.zeros(n), np.ones(n)], np.zeros(0), 0.05)[n:]
    np.testing.assert_allclose(slowed, np.exp(-0.05 * 0.36 / (2 * 1.5**2)), rtol=1e-6)


def test_without_a_speed_it_is_the_published_motion():
    model = uwb(range_sd=0.1, acceleration_density=0.6)
    F, Q = functions_of(model).transition(np.zeros(6), np.zeros(0), 0.3)
    one = np.eye(3)
    np.testing.assert_allclose(F, np.block([[one, 0.3 * one], [0 * one, one]]), atol=1e-15)
    axis = 0.36 * np.array([[0.3**3 / 3, 0.3**2 / 2], [0.3**2 / 2, 0.3]])
    np.testing.assert_allclose(Q, np.kron(axis, one), atol=1e-15)


def test_a_named_radio_on_a_named_carrier_has_their_numbers():
    model = uwb_of(RADIOS["dw1000"], CARRIERS["cart"], time_offset=0.1)
    assert model.name == "uwb_3d_biased" and model.prebuilt and model.parameters["time_offset"] == 0.1
    assert uwb_of(RADIOS["dw1000"], CARRIERS["drone"], bias=False, tag_down=-1.0).name == "uwb_2d"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"dimensions": 4}, "dimensions"),
        ({"speed": 0.0}, "speed"),
        ({"speed": 1.0, "driven": True}, "driven"),
        ({"bias": RangeBias(0.1, 60.0, 0.01), "driven": True}, "driven"),
        ({"range_sd": 0.0}, "range"),
        ({"acceleration_density": -1.0}, "acceleration"),
    ],
)
def test_what_cannot_be_is_named(options, words):
    with pytest.raises(InputError, match=words):
        uwb(**({"range_sd": 0.1, "acceleration_density": 0.5} | options))


@pytest.mark.parametrize("bias", [(0.0, 60.0, 0.01), (0.1, -1.0, 0.01), (0.1, 60.0, np.nan)])
def test_a_bias_that_cannot_be_is_named(bias):
    with pytest.raises(InputError, match="range bias"):
        RangeBias(*bias)
