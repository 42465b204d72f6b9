from dataclasses import replace

import numpy as np
import pytest

from robustnav.design import Plant
from robustnav.design.scaling import Scaling
from robustnav.errors import EstimatorError, InputError


def chain(**changes):
    """Position and velocity, position measured, white acceleration."""
    parts = {
        "A": [[0.0, 1.0], [0.0, 0.0]],
        "B_w": [[0.0, 0.0], [1.0, 0.0]],
        "C_y": [[1.0, 0.0]],
        "D_w": [[0.0, 1.0]],
        "C_z": [[1.0, 0.0]],
    }
    return Plant(**(parts | changes))


def test_names_the_unobservable_direction():
    with pytest.raises(EstimatorError, match=r"not detectable") as caught:
        chain(C_y=[[0.0, 1.0]])
    assert "x[0]" in str(caught.value)
    assert "x[1]" not in str(caught.value)


def test_without_magnetometer_heading_is_named(make_plant):
    with pytest.raises(EstimatorError, match=r"x\[2\]"):
        make_plant(field_n=np.zeros(3))


def test_unobservable_but_decaying_is_allowed():
    chain(A=[[-1.0, 1.0], [0.0, 0.0]], C_y=[[0.0, 1.0]])


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_detectability_does_not_depend_on_units_of_the_output(unit):
    chain(C_y=[[unit, 0.0]], D_w=[[0.0, unit]])
    with pytest.raises(EstimatorError, match="not detectable"):
        chain(C_y=[[0.0, unit]], D_w=[[0.0, unit]])


def test_mode_on_the_axis_without_noise_is_named():
    with pytest.raises(EstimatorError, match=r"not stabilisable(.|\n)*x\[1\]"):
        chain(B_w=[[1.0, 0.0], [0.0, 0.0]])


def test_sensor_noise_can_cancel_process_noise():
    """With w known exactly from y there is no noise left on the mode: the test must use the cross term."""
    with pytest.raises(EstimatorError, match="not stabilisable"):
        Plant([[1.0]], [[1.0]], [[1.0]], [[1.0]], [[1.0]])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"A": np.zeros((2, 3))}, "A"),
        ({"A": 3.0}, "A"),
        ({"C_y": [[np.nan, 0.0]]}, "C_y"),
        ({"D_w": [[0.0, 1.0, 0.0]]}, "D_w"),
        ({"D_w": [[0.0, 0.0]]}, "output 0 has no noise"),
        ({"C_y": np.eye(2), "D_w": [[0.0, 1.0], [0.0, 1.0]]}, "linearly dependent"),
        ({"C_z": [[1.0]]}, "C_z"),
    ],
)
def test_bad_input(changes, words):
    with pytest.raises(InputError, match=words):
        chain(**changes)


def test_scaling_is_a_change_of_units(random_plant):
    plant = random_plant(3)
    L = np.random.default_rng(4).normal(size=(4, 2))
    units = Scaling.expected(plant, np.array([1e-3, 2.0, 50.0, 0.1]))
    scaled = units.apply(plant)
    assert np.allclose(scaled.R, np.eye(2), atol=1e-12)
    assert np.isclose(np.linalg.norm(scaled.C_z), 1.0)
    F_scaled, B_scaled = scaled.closed_loop(L)
    F, B = plant.closed_loop(units.gain(L))
    T = units.states[:, None]
    assert np.allclose(F * units.states / T, F_scaled, rtol=1e-12, atol=1e-9)
    assert np.allclose(B / T, B_scaled, rtol=1e-12, atol=1e-9)


def test_scaling_refuses_zero(plant):
    with pytest.raises(InputError, match="standard deviations"):
        Scaling.expected(plant, np.zeros(6))


def test_frozen(plant):
    with pytest.raises(AttributeError):
        plant.A = np.eye(6)
    assert replace(plant, C_z=np.eye(6)).C_z.shape == (6, 6)
