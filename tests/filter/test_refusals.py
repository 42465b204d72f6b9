"""What a filter does not believe leaves its belief alone, and is said."""

import numpy as np
import pytest

from robustnav.errors import EstimatorError
from robustnav.filter import ekf, ukf
from robustnav.filter.ekf import EVERYTHING
from robustnav.filter.steps import pack, unpack
from robustnav.filter.ukf import Spread
from robustnav.filter.weighting import Gate, Huber, StudentT

STEPS = {
    "ekf": lambda model, belief, z, rule=EVERYTHING: ekf.update(model, 1, belief, z, rule),
    "ukf": lambda model, belief, z, rule=EVERYTHING: ukf.update(model, 1, belief, z, Spread(), rule),
}


@pytest.fixture(params=STEPS)
def step(request):
    return STEPS[request.param]


def test_the_gate_is_the_largest_accepted_nis(step, turning, belief):
    z = turning.measure(1, belief[0]) + np.array([0.3, -0.2, 0.4])
    nis = step(turning, belief, z)[2].nis
    x, P, seen = step(turning, belief, z, Gate(0.999 * nis))
    assert not seen.used and seen.nis == nis
    np.testing.assert_array_equal(x, belief[0])
    np.testing.assert_array_equal(P, belief[1])
    assert step(turning, belief, z, Gate(1.001 * nis))[2].used


@pytest.mark.parametrize("z", [[np.nan, 0, 0], [np.inf, 0, 0], [1e200, 0, 0]])
@pytest.mark.parametrize("rule", [Gate(), Gate(9.0), Huber(), StudentT()])
@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")
def test_what_is_not_finite_is_never_used(step, turning, belief, z, rule):
    x, P, seen = step(turning, belief, np.array(z), rule)
    assert not seen.used
    np.testing.assert_array_equal(x, belief[0])
    np.testing.assert_array_equal(P, belief[1])


@pytest.mark.parametrize("where", [(0, 0), (2, 2)])
@pytest.mark.parametrize("value", [-1.0, np.nan])
def test_a_broken_covariance_is_refused(turning, belief, where, value):
    x, P = belief
    P = P.copy()
    P[where] = value
    after, P_after, seen = ekf.update(turning, 1, (x, P), turning.measure(1, x))
    assert not seen.used
    np.testing.assert_array_equal(after, x)
    np.testing.assert_array_equal(P_after, P)
    for call in (
        lambda: ukf.update(turning, 1, (x, P), turning.measure(1, x), Spread()),
        lambda: ukf.predict(turning, (x, P), np.zeros(3), 0.01, Spread()),
    ):
        with pytest.raises(EstimatorError, match="positive definite"):
            call()


def test_covariances_stay_symmetric_to_the_bit(step, turning, belief):
    P = step(turning, belief, turning.measure(1, belief[0]) + 0.1)[1]
    np.testing.assert_array_equal(P, P.T)
    P = ekf.predict(turning, *belief, np.array([1.0, -2.0, 0.5]), 0.01)[1]
    np.testing.assert_array_equal(P, P.T)


@pytest.mark.parametrize("n", [1, 2, 6, 15])
def test_packing_keeps_everything(n):
    P = np.random.default_rng(n).normal(size=(n, n))
    P = P + P.T
    np.testing.assert_array_equal(unpack(pack(P)), P)
    np.testing.assert_array_equal(unpack(np.stack([pack(P), 2 * pack(P)]))[1], 2 * P)
