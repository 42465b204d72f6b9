"""A model that cannot be right is refused when it is made, and the error names what is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, Rotation, Sensor, Vector
from robustnav.models import AttitudeNoise, attitude


def make(**changes):
    parts = {
        "name": "cart",
        "state": (Vector("position", "m", 1), Vector("speed", "m/s", 1)),
        "inputs": (Vector("push", "m/s^2", 1),),
        "noises": (Noise("gust", "m/s^2/sqrt(Hz)", 0.1, 1),),
        "sensors": (Sensor("ruler", "m", 0.01, 1),),
        "parameters": {"mass": 2.0},
        "equations": lambda s: Equations(
            {"position": s.speed, "speed": s.push / s.mass + s.gust}, {"ruler": s.position}
        ),
        "start_sd": {"position": 1.0},
    }
    return Model(**{**parts, **changes})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": "my cart"}, ["'my cart'", "identifier"]),
        ({"state": (Vector("2fast", "m", 1),)}, ["'2fast'", "identifier"]),
        ({"sensors": (Sensor("a-b", "m", 1.0, 1),)}, ["'a-b'", "identifier"]),
        ({"parameters": {"mass of cart": 1.0}}, ["'mass of cart'", "identifier"]),
        ({"inputs": (Vector("speed", "m/s^2", 1),)}, ["speed twice"]),
        ({"parameters": {"gust": 1.0}}, ["gust twice"]),
        ({"state": ()}, ["no state"]),
        ({"state": (Rotation("q_a"), Rotation("q_b"))}, ["two rotations"]),
        ({"state": (Vector("position", "m", 0),)}, ["'position'", "size 0"]),
        ({"state": (Vector("position", "m", 2, frame="b"),)}, ["'position'", "size 2", "three"]),
        ({"noises": (Noise("gust", "m/s^2/sqrt(Hz)", -0.1, 1),)}, ["'gust'", "-0.1", "m/s^2/sqrt(Hz)"]),
        ({"noises": (Noise("gust", "m", float("nan"), 1),)}, ["'gust'", "nan"]),
        ({"sensors": (Sensor("ruler", "m", 0.0, 1),)}, ["'ruler'", "sd 0.0", "> 0"]),
        ({"sensors": (Sensor("ruler", "m", float("inf"), 1),)}, ["'ruler'", "inf"]),
        ({"parameters": {"mass": float("nan")}}, ["'mass'", "nan"]),
        ({"nominal": {"velocity": 1.0}}, ["nominal", "velocity"]),
    ],
)
def test_bad_parts_are_refused_by_name(changes, words):
    with pytest.raises(InputError) as caught:
        make(**changes)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_rotation_has_an_error_in_one_of_two_frames():
    with pytest.raises(InputError, match="'q_nb'"):
        Rotation("q_nb", error="world")


def test_sizes_and_places():
    model = make(state=(Vector("position", "m", 2), Rotation("q_nb"), Vector("bias", "rad/s")))
    assert (model.state_size, model.error_size, model.input_size) == (9, 8, 1)
    assert model.state_slices == {"position": slice(0, 2), "q_nb": slice(2, 6), "bias": slice(6, 9)}
    assert model.error_slices == {"position": slice(0, 2), "q_nb": slice(2, 5), "bias": slice(5, 8)}
    np.testing.assert_array_equal(model.nominal_state(), [0, 0, 1, 0, 0, 0, 0, 0, 0])


def test_a_missing_start_deviation_is_named_and_scalars_spread():
    model = make()
    with pytest.raises(InputError, match=r"'speed' in m/s"):
        model.start_covariance()
    with pytest.raises(InputError, match=r"start_sd(.|\n)*spped"):
        model.start_covariance({"spped": 1.0})
    np.testing.assert_array_equal(model.start_covariance({"speed": 3.0}), np.diag([1.0, 9.0]))


def test_numbers_are_replaced_by_name_only():
    model = make().with_numbers({"gust": 0.5}, {"ruler": 0.2}, {"mass": 4.0})
    assert (model.noises[0].density, model.sensors[0].sd, model.parameters["mass"]) == (0.5, 0.2, 4.0)
    assert model.intensities == pytest.approx([0.25])
    with pytest.raises(InputError, match="ruller"):
        model.with_numbers(sd={"ruller": 1.0})
    with pytest.raises(InputError, match="'gust'"):
        model.with_numbers({"gust": -1.0})


def test_an_unknown_sensor_lists_those_there_are():
    with pytest.raises(InputError, match="one of ruler"):
        make().sensor_index("scale")


def test_other_equations_are_not_run_as_the_c_that_ships():
    model = attitude(AttitudeNoise(1e-3, 1e-5, 0.1, 1e-6), field=48e-6, dip_deg=60.0)
    assert model.prebuilt
    assert model.with_numbers(sd={"accel": 0.2}).prebuilt
    assert not replace(model, equations=lambda s: model.equations(s)).prebuilt
