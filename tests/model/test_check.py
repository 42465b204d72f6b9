"""The checker passes what is right and catches deliberate mistakes, raising nothing."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.model import Equations, Rotation, Sensor, Vector, check_model
from robustnav.model.check import ModelCheck


def test_good_models_pass(model):
    found = check_model(model, samples=5)
    assert found.passed, found.findings
    assert found.rank == found.error_size == model.error_size and not found.unobservable
    sensors = {f"H of {s.name}" for s in model.sensors}
    assert set(found.worst) - {"turned body"} == {"A", "G", "F"} | sensors
    assert max(found.worst[k] for k in ("A", "G", *sensors)) < 1e-4
    assert ("turned body" in found.worst) == (model.rotation is not None)


def finding(model, *words, **options):
    found = check_model(model, samples=2, **options)
    assert isinstance(found, ModelCheck) and not found.passed
    assert any(all(word in line for word in words) for line in found.findings), found.findings
    return found


def without_magnetometer(model):
    return replace(
        model,
        shipped=None,
        sensors=model.sensors[:1],
        equations=lambda s: Equations(model.equations(s).rates, directions={"accel": (0, 0, -s.gravity)}),
    )


def test_a_heading_that_nothing_sees_is_named(models):
    found = finding(without_magnetometer(models["attitude"]), "no sensor sees q_nb z, gyro_bias z")
    assert (found.rank, found.unobservable) == (4, ("q_nb z", "gyro_bias z"))


def test_directions_that_lie_together_in_a_plane_are_named(models):
    """Tilted out of its axes, what is not seen is no single axis: position enters through a sum only."""
    model = models["inertial_n"]
    summed = replace(
        model,
        sensors=(*model.sensors, Sensor("sum", "m", 1.0, 1)),
        state=(*model.state, Vector("p_n", "m")),
        start_sd={**model.start_sd, "p_n": 1.0},
        equations=lambda s: _with(model.equations(s), {"p_n": s.v_n}, {"sum": s.p_n[0] - s.p_n[1]}),
    )
    found = finding(summed, "no sensor sees")
    assert set(found.unobservable) == {"p_n x with p_n y", "p_n z"}


def _with(equations, rates, sensors):
    return Equations({**equations.rates, **rates}, {**equations.sensors, **sensors}, equations.directions)


def test_a_direction_that_moves_with_the_state_is_no_direction(models):
    model = models["inertial_n"]
    moving = lambda s: Equations(  # noqa: E731
        model.equations(s).rates, model.equations(s).sensors, {"mag": (s.north, 0, s.down + s.v_n[2] / 10)}
    )
    finding(replace(model, equations=moving), "H of mag", "finite differences")


def test_a_direction_that_turns_with_the_body_is_no_direction(models):
    model = models["inertial_n"]
    turning = lambda s: Equations(  # noqa: E731
        model.equations(s).rates, model.equations(s).sensors, {"mag": (s.north, s.bias[0], s.down)}
    )
    finding(replace(model, equations=turning), "direction of mag", "body axes")


@pytest.mark.parametrize("error", ["n", "b"])
def test_a_navigation_vector_is_no_body_vector(models, error):
    model = models[f"inertial_{error}"]
    state = (model.state[0], Vector("v_n", "m/s", frame="b"), model.state[2])
    finding(replace(model, state=state), "rate of v_n", "body axes")


def test_a_body_vector_must_say_so(models):
    model = models["attitude"]
    finding(replace(model, shipped=None, inputs=(Vector("gyro", "rad/s"),)), "rate of q_nb", "body axes")


def test_a_wrong_derivative_is_seen(models, monkeypatch):
    """A sign lost in the derivation itself."""
    from robustnav.model.derive import Derivation

    right = Derivation.error_rate

    def wrong(self):
        A, G = right(self)
        A[0][-1] = -A[0][-1] + 1
        return A, G

    monkeypatch.setattr(Derivation, "error_rate", wrong)
    finding(models["attitude_euler"], "A differs")


@pytest.mark.parametrize(("scale", "words"), [("root", ["G", "finite"]), ("size", ["no derivative", "sqrt"])])
def test_a_corner_has_no_derivative(models, scale, words):
    """The square root of a bias has none at zero, where the nominal point is, nor has its absolute value."""
    import sympy as sp

    model = models["attitude"]
    factor = {"root": lambda s: sp.sqrt(s.gyro_bias[0]), "size": lambda s: abs(s.gyro_bias[0])}[scale]

    def corner(s):
        given = model.equations(s)
        return Equations({**given.rates, "gyro_bias": s.gyro_bias_noise * factor(s)}, directions=given.directions)

    finding(replace(model, shipped=None, equations=corner), *words)


def test_a_step_that_is_too_long_is_said(models):
    finding(models["inertial_n"], "step of 3 s is too long", dt=3.0)


@pytest.mark.parametrize(
    ("equations", "words"),
    [
        (lambda s: Equations({"euler": (1, 2)}), ["rate of 'euler'", "2 expressions"]),
        (lambda s: Equations({"euler": s.eulr}), ["AttributeError", "eulr"]),
        (lambda s: Equations({"euler": s.euler * s.gyro}), ["ShapeError"]),
        (lambda s: None, ["AttributeError"]),
        (lambda s: Equations({"euler": s.euler[7]}), ["IndexError"]),
        (lambda s: 1 / 0, ["ZeroDivisionError"]),
    ],
)
def test_equations_that_do_not_fit_are_a_finding(models, equations, words):
    model = replace(models["attitude_euler"], shipped=None, equations=equations)
    found = finding(model, *words)
    assert found.error_size == 6 and not found.worst


def test_what_runs_in_numpy_only_is_said(models):
    model = models["attitude_euler"]
    strange = lambda s: Equations(  # noqa: E731
        {"euler": s.gyro + s.gyro_noise, "gyro_bias": s.gyro_bias_noise + s.euler.applyfunc(lambda v: v**5)},
        {"accel": s.euler, "mag": s.euler + s.gyro_bias},
    )
    finding(replace(model, shipped=None, equations=strange), "NumPy only", "**(5)")


def test_no_sensor_is_said(models):
    model = models["attitude_euler"]
    finding(
        replace(model, shipped=None, sensors=(), equations=lambda s: Equations(model.equations(s).rates)),
        "no sensor:",
    )


def test_the_same_seed_finds_the_same(models):
    one, two, other = (check_model(models["inertial_b"], samples=1, seed=s) for s in (1, 1, 2))
    assert one == two and one.worst != other.worst
    assert np.isfinite(list(one.worst.values())).all()
    assert isinstance(models["inertial_b"].rotation, Rotation)
