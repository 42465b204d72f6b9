"""How far down the errors a step and a reading reach: what lies behind is really left alone, and not one error more."""

import numpy as np
import pytest

from robustnav.model import Equations, Model, Sensor, Vector
from robustnav.model.derive import Derivation
from robustnav.model.discretize import Step
from robustnav.model.pattern import errors_moved, errors_seen
from robustnav.model.program import Program

MOVED = {"attitude": 3, "attitude_body": 3, "attitude_euler": 3, "inertial_n": 9, "inertial_b": 9}
SEEN = {
    "attitude": {"accel": 2, "mag": 3},
    "attitude_body": {"accel": 3, "mag": 3},
    "attitude_euler": {"accel": 2, "mag": 3},
    "inertial_n": {"air": 6, "speed": 6, "mag": 3},
    "inertial_b": {"air": 6, "speed": 6, "mag": 3},
}


def moved(model):
    import symengine as se

    derivation = Derivation(model)
    return errors_moved(model, derivation.x, Step(derivation, Program(), se.Symbol("dt")).state)


@pytest.mark.parametrize("name", MOVED)
def test_the_counts(models, name):
    assert moved(models[name]) == MOVED[name]
    assert {s.name: errors_seen(Derivation(models[name]), s.name) for s in models[name].sensors} == SEEN[name]


def test_a_block_that_stands_still_before_one_that_moves_counts_as_moved():
    model = Model(
        name="still_first",
        state=(Vector("a", "1", 2), Vector("b", "1", 1), Vector("c", "1", 1)),
        inputs=(),
        noises=(),
        sensors=(Sensor("late", "1", 1.0, 1), Sensor("nothing", "1", 1.0, 1)),
        equations=lambda s: Equations(
            {"a": 0 * s.a, "b": s.a[0], "c": 0 * s.c}, {"late": s.c[0] - s.a[0], "nothing": (3,)}
        ),
    )
    assert moved(model) == 3
    derivation = Derivation(model)
    assert (errors_seen(derivation, "late"), errors_seen(derivation, "nothing")) == (4, 0)


@pytest.mark.parametrize("name", MOVED)
def test_errors_behind_are_left_alone_and_the_last_before_is_not(models, numerics, states, name):
    model, numeric = models[name], numerics[name]
    rng, n = np.random.default_rng(2), model.error_size
    reached = dict.fromkeys(SEEN[name], 0.0)
    stepped = 0.0
    for x, u in states(model, 6):
        e = 0.4 * rng.normal(size=n)
        last = MOVED[name]
        a, b = (numeric.propagate(one, u, 0.05) for one in (numeric.inject(x, e), x))
        np.testing.assert_allclose(numeric.difference(a, b)[last:], e[last:], atol=1e-14)
        stepped = max(stepped, np.abs(numeric.difference(a, b)[last - 1] - e[last - 1]))
        for j, (sensor, seen) in enumerate(SEEN[name].items()):
            behind = np.where(np.arange(n) < seen, 0.0, e)
            np.testing.assert_allclose(numeric.measure(j, numeric.inject(x, behind)), numeric.measure(j, x), atol=1e-13)
            only = np.where(np.arange(n) == seen - 1, 0.3, 0.0)
            apart = numeric.measure(j, numeric.inject(x, only)) - numeric.measure(j, x)
            reached[sensor] = max(reached[sensor], np.abs(apart).max())
    assert stepped > 1e-6 and min(reached.values()) > 1e-3
