"""Jacobians against differences taken on the manifold: at identity, 1e-8 rad beside it, and anywhere."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, NumericModel, Rotation, Sensor, Vector
from robustnav.model.derive import Derivation


def differences(function, n, step):
    return np.array([(function(e) - function(-e)) / (2 * step) for e in step * np.eye(n)]).T


def rate_of(moved):
    """d/dt at zero of what ``moved(h)`` gives after h seconds, forward and back."""
    h = 1e-3
    return (moved(h) - moved(-h)) / (2 * h)


def test_error_growth_is_that_of_two_flows(model, numeric, states):
    for x, u in states(model):

        def grown(e, x=x, u=u):
            other = numeric.inject(x, e)
            return rate_of(lambda h: numeric.difference(numeric.propagate(other, u, h), numeric.propagate(x, u, h)))

        A = numeric.error_rate(x, u)[0]
        np.testing.assert_allclose(A, differences(grown, len(A), 1e-4), atol=2e-5 * max(1, np.abs(A).max()))


def test_noise_enters_as_an_input_of_the_same_name_would(model, numeric, states):
    fed = replace(
        model,
        noises=(),
        inputs=(*model.inputs, *(Vector(n.name, n.unit, n.size) for n in model.noises)),
        shipped=None,
    )
    driven = NumericModel(fed)
    for x, u in states(model):

        def pushed(w, x=x, u=u):
            still = np.r_[u, 0 * w]
            return rate_of(
                lambda h: driven.difference(driven.propagate(x, np.r_[u, w], h), driven.propagate(x, still, h))
            )

        G, start = numeric.error_rate(x, u)[1], 0
        seen = differences(pushed, G.shape[1], 1e-4)
        for noise in model.noises:  # isotropic noise of the attitude alone is left unturned: G G' is what counts
            part = slice(start, start + noise.size)
            start += noise.size
            expected = seen[:, part] @ seen[:, part].T
            scale = max(1, np.abs(expected).max())
            np.testing.assert_allclose(G[:, part] @ G[:, part].T, expected, atol=2e-5 * scale)


def test_sensor_jacobians(model, numeric, states):
    for x, _ in states(model):
        for j in range(len(model.sensors)):
            z = numeric.measure(j, x)

            def predicted(e, j=j, x=x, z=z):
                return -numeric.residual(j, numeric.inject(x, e), z)

            H = numeric.jacobian(j, x)
            seen = differences(predicted, model.error_size, 1e-5)
            np.testing.assert_allclose(H, seen, atol=1e-8 * max(1, np.abs(H).max()))


def test_inject_and_difference_undo_each_other(model, numeric, states):
    rng = np.random.default_rng(0)
    for x, _ in states(model):
        e = rng.normal(size=model.error_size)
        np.testing.assert_allclose(numeric.difference(numeric.inject(x, e), x), e, atol=1e-12)
        np.testing.assert_allclose(numeric.difference(x, x), 0 * e, atol=1e-15)


def test_directions_are_compared_in_navigation_axes_and_their_jacobian_does_not_move(models, states):
    model = models["attitude"]
    numeric = NumericModel(model)
    H = [numeric.jacobian(j, model.nominal_state()) for j in range(2)]
    assert [len(h) for h in H] == [2, 3]  # gravity says nothing about the axis it points along
    for x, _ in states(model):
        for j in range(2):
            np.testing.assert_array_equal(numeric.jacobian(j, x), H[j])


@pytest.mark.parametrize("error", ["n", "b"])
def test_a_row_that_is_zero_by_its_number_only_is_kept(error):
    """With a level field the z number of the field is zero; the rows of a sensor must not depend on it."""
    model = Model(
        name="level",
        state=(Rotation("q_nb", error),),
        inputs=(Vector("gyro", "rad/s", frame="b"),),
        noises=(Noise("gyro_noise", "rad/s/sqrt(Hz)", 0.1),),
        sensors=(Sensor("mag", "1", 0.1),),
        parameters={"down": 0.0},
        equations=lambda s: Equations({"q_nb": s.gyro + s.gyro_noise}, directions={"mag": (1, 0, s.down)}),
    )
    numeric, x = NumericModel(model), model.nominal_state()
    assert len(numeric.jacobian(0, x)) == len(numeric.residual(0, x, np.ones(3))) == 3
    assert Derivation(model).rows("mag") == [0, 1, 2]


def linear(**changes):
    numbers = {
        "name": "m",
        "state": (Vector("a", "1", 2),),
        "inputs": (Vector("u", "1", 1),),
        "noises": (Noise("n", "1", 1.0, 1),),
        "sensors": (Sensor("y", "1", 1.0, 1),),
        "equations": lambda s: Equations({"a": (s.a[1], s.u[0] + s.n[0])}, {"y": s.a[0]}),
    }
    return Model(**{**numbers, **changes})


@pytest.mark.parametrize(
    ("equations", "words"),
    [
        (lambda s: Equations({}, {"y": s.a[0]}), ["no rate for 'a'"]),
        (lambda s: Equations({"a": (1, 2)}), ["no sensor equation for 'y'"]),
        (lambda s: Equations({"a": (1, 2, 3)}, {"y": s.a[0]}), ["rate of 'a'", "3 expressions", "2"]),
        (lambda s: Equations({"a": (1, 2)}, {"y": s.a}), ["sensor equation of 'y'", "2 expressions"]),
        (lambda s: Equations({"a": (1, 2)}, {"y": s.u[0]}), ["sensor equation of 'y'", "u_u_0"]),
        (lambda s: Equations({"a": (1, 2)}, {"y": s.n[0]}), ["sensor equation of 'y'", "w_n_0"]),
        (lambda s: Equations({"a": (1, _stranger())}, {"y": s.a[0]}), ["rate of 'a'", "stranger"]),
        (lambda s: Equations({"a": (1, 2), "b": (1,)}, {"y": s.a[0]}), ["an equation for 'b'"]),
        (lambda s: Equations({"a": (1, 2)}, {"y": s.a[0], "yy": s.a[0]}), ["an equation for 'yy'"]),
        (lambda s: Equations({"a": (1, 2)}, directions={"y": (0, 0, 1)}), ["no Rotation block"]),
        (lambda s: Equations({"a": (1, abs(s.a[0]))}, {"y": s.a[0]}), ["no derivative", "abs(s_a_0)", "sqrt"]),
    ],
)
def test_equations_that_do_not_fit_are_refused_by_name(equations, words):
    with pytest.raises(InputError) as caught:
        NumericModel(linear(equations=equations))
    assert all(word in str(caught.value) for word in words), str(caught.value)


def _stranger():
    import sympy as sp

    return sp.Symbol("stranger")


def test_a_misspelt_symbol_lists_those_there_are():
    with pytest.raises(AttributeError, match="no symbol 'aa'; the model has a, u, n"):
        NumericModel(linear(equations=lambda s: Equations({"a": s.aa}, {})))


def test_a_scalar_stands_for_a_block_of_one():
    numeric = NumericModel(linear())
    assert numeric.measure(0, np.array([3.0, 4.0])) == pytest.approx([3.0])
