"""Where a filter must reduce to another: EKF, UKF and constant gain to the Kalman filter, rows to a batch."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from robustnav.errors import InputError
from robustnav.filter import ekf, fixed_gain, ukf
from robustnav.filter.ukf import Spread
from robustnav.frames import quat_from_rotvec, quat_multiply
from robustnav.model import NumericModel

DT = 0.1
SPREADS = [Spread(), Spread(0.5, 2.0, 0.0), Spread(1.0, 0.0, 2.0)]


def system(spring):
    """F, B, Q, H, R of the linear model, the textbook's letters."""
    x = np.zeros(3)
    F, Q = spring.transition(x, np.zeros(1), DT)
    B = spring.propagate(x, np.ones(1), DT)
    return F, B, Q, spring.jacobian(0, x), spring.model.variances[0] * np.eye(2)


def kalman(system, x, P, u, z):
    """One step of the textbook filter: predict, then the joint update with an inverse."""
    F, B, Q, H, R = system
    x, P = F @ x + B * u, F @ P @ F.T + Q
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ (z - H @ x), (np.eye(3) - K @ H) @ P


def readings(count=60):
    rng = np.random.default_rng(0)
    return zip(rng.normal(size=count), rng.normal(size=(count, 2)), strict=True)


def test_ekf_is_the_kalman_filter_on_a_linear_model(spring):
    x, P = np.ones(3), 2 * np.eye(3)
    x_ekf, P_ekf = x, P
    for u, z in readings():
        x, P = kalman(system(spring), x, P, u, z)
        x_ekf, P_ekf = ekf.predict(spring, x_ekf, P_ekf, np.array([u]), DT)
        x_ekf, P_ekf, seen = ekf.update(spring, 0, (x_ekf, P_ekf), z)
        assert seen.used
        np.testing.assert_allclose(x_ekf, x, atol=1e-12)
        np.testing.assert_allclose(P_ekf, P, atol=1e-12)


@pytest.mark.parametrize("spread", SPREADS)
def test_ukf_is_the_kalman_filter_on_a_linear_model(spring, spread):
    x, P = np.ones(3), 2 * np.eye(3)
    belief = x, P
    for u, z in readings():
        x, P = kalman(system(spring), x, P, u, z)
        belief = ukf.predict(spring, belief, np.array([u]), DT, spread)
        *belief, seen = ukf.update(spring, 0, tuple(belief), z, spread)
        assert seen.used
        np.testing.assert_allclose(belief[0], x, atol=1e-11)
        np.testing.assert_allclose(belief[1], P, atol=1e-11)


def test_a_constant_gain_is_the_kalman_filter_in_its_steady_state(spring):
    F, _, Q, H, R = whole = system(spring)
    P = solve_discrete_are(F.T, H.T, Q, R)  # before the update
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    x = x_fixed = np.ones(3)
    P = (np.eye(3) - K @ H) @ P
    for u, z in readings():
        x, P = kalman(whole, x, P, u, z)
        x_fixed = spring.propagate(x_fixed, np.array([u]), DT)
        x_fixed, seen = fixed_gain.correct(spring, x_fixed, K, {0: z})
        np.testing.assert_allclose(x_fixed, x, atol=1e-10)
        assert seen[0].used and np.isnan(seen[0].s).all()


def test_rows_one_by_one_are_one_joint_update(turning, belief):
    x, P = belief
    z = turning.measure(1, x) + np.array([0.05, -0.1, 0.02])
    H, r = turning.jacobian(1, x), turning.residual(1, x, z)
    S = H @ P @ H.T + turning.model.variances[1] * np.eye(3)
    K = P @ H.T @ np.linalg.inv(S)
    x_rows, P_rows, seen = ekf.update(turning, 1, belief, z)
    np.testing.assert_allclose(x_rows, turning.inject(x, K @ r), atol=1e-13)
    np.testing.assert_allclose(P_rows, P - K @ S @ K.T, atol=1e-14)
    assert seen.nis == pytest.approx(r @ np.linalg.solve(S, r), rel=1e-11)
    assert seen.s[0] == pytest.approx(S[0, 0]) and seen.nu[0] == pytest.approx(r[0])


def test_two_readings_are_one_of_half_the_variance(turning, belief):
    """The second at the first's linearisation point, which the nav-frame Jacobian does not leave."""
    x, P = belief
    z = turning.measure(0, x)  # no innovation: only P moves
    once = NumericModel(turning.model.with_numbers(sd={"accel": turning.model.sensors[0].sd / np.sqrt(2)}))
    _, P_two, _ = ekf.update(turning, 0, ekf.update(turning, 0, belief, z)[:2], z)
    np.testing.assert_allclose(P_two, ekf.update(once, 0, belief, z)[1], atol=1e-14)
    assert np.trace(P_two) < np.trace(P)


@pytest.mark.parametrize("step", [lambda *a: ekf.update(*a), lambda *a: ukf.update(*a, Spread())])
def test_a_reading_of_infinite_variance_says_nothing(turning, belief, step):
    deaf = NumericModel(turning.model.with_numbers(sd={"mag": 1e9}))
    x, P, seen = step(deaf, 1, belief, np.array([9.0, -7.0, 5.0]))
    assert seen.used
    np.testing.assert_allclose(x, belief[0], atol=1e-12)
    np.testing.assert_allclose(P, belief[1], atol=1e-12)


def test_ukf_is_ekf_when_the_belief_is_narrow(turning, belief):
    """The manifold and its points do not matter to first order."""
    x, P = belief[0], belief[1] * 1e-8
    tight = NumericModel(turning.model.with_numbers(sd={"mag": 1e-5, "accel": 1e-4}))
    z = tight.measure(1, x) + 1e-5 * np.array([1.0, -2.0, 1.5])
    u, spread = np.array([0.5, -1.0, 2.0]), Spread()
    one, other = ekf.predict(tight, x, P, u, 0.01), ukf.predict(tight, (x, P), u, 0.01, spread)
    np.testing.assert_allclose(one[0], other[0], atol=1e-9)
    np.testing.assert_allclose(one[1], other[1], atol=1e-5 * np.abs(P).max())
    one, other = ekf.update(tight, 1, (x, P), z), ukf.update(tight, 1, (x, P), z, spread)
    np.testing.assert_allclose(tight.difference(one[0], other[0]), 0, atol=1e-9)
    np.testing.assert_allclose(one[1], other[1], atol=1e-4 * np.abs(P).max())
    np.testing.assert_allclose(one[2].nis, other[2].nis, rtol=1e-3)


def test_a_steady_turn_of_the_body_frame_is_followed(turning):
    """inject_turned gives body vectors their correction in navigation axes: C_nb (b + C_bn e) = C_nb b + e."""
    x = np.r_[quat_from_rotvec([0.3, -0.8, 1.2]), 0.01, 0.02, 0.03]
    e = np.array([0.0, 0.0, 0.0, 0.1, 0.2, 0.3])
    moved = turning.inject_turned(x, e)
    seen = quat_multiply(quat_multiply(x[:4], np.r_[0, moved[4:] - x[4:]]), x[:4] * [1, -1, -1, -1])[1:]
    np.testing.assert_allclose(seen, e[3:], atol=1e-14)
    np.testing.assert_allclose(moved[:4], x[:4], atol=1e-15)


@pytest.mark.parametrize("spread", SPREADS)
@pytest.mark.parametrize("n", [1, 6, 20])
def test_weights_carry_mean_and_covariance(spread, n):
    distance, mean, covariance = spread.weights(n)
    assert mean.sum() == pytest.approx(1.0)
    assert 2 * distance * covariance[1] == pytest.approx(1.0)  # +-sqrt(distance) along each axis gives variance one
    assert covariance[0] - mean[0] == pytest.approx(1 - spread.alpha**2 + spread.beta)


def test_a_spread_without_width_is_refused():
    with pytest.raises(InputError, match="spread"):
        replace(Spread(), kappa=-6.0).weights(6)
