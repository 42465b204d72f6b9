"""The smoother against the joint Gaussian of the whole path, and against what must leave it alone."""

import numpy as np
import pytest

from robustnav.filter import ekf, smoother
from robustnav.filter.smoother import back, smooth, solve_semidefinite
from robustnav.frames import matrix_from_quat, quat_from_rotvec, quat_multiply
from robustnav.model import NumericModel

RNG = np.random.default_rng(5)
DT = np.r_[np.nan, RNG.uniform(0.02, 0.3, 24)]
STARTS = {"wide": np.diag([1.0, 2.0, 0.5]), "known but along one line": np.outer([1.0, -2.0, 0.5], [1.0, -2.0, 0.5])}


def filtered(model, start, u, readings, dt=DT):
    """Beliefs of a filter after the readings of each row, None for none."""
    out = []
    for k, z in enumerate(readings):
        belief = ekf.predict(model, *out[-1], u[k], dt[k]) if k else start
        out.append(belief if z is None else ekf.update(model, 0, belief, z)[:2])
    return out


def recording():
    rng, count = np.random.default_rng(1), len(DT)
    u = rng.normal(size=(count, 1))
    return u, [rng.normal(size=2) if k % 3 else None for k in range(count)]


def posterior(model, start, u, readings):
    """Mean and covariance of all states given all readings, by one dense solve in the joint covariance."""
    n, count = 3, len(readings)
    mean, joint = np.zeros(n * count), np.zeros((n * count, n * count))
    mean[:n], joint[:n, :n] = start
    for k in range(1, count):
        now, before = (slice(n * i, n * (i + 1)) for i in (k, k - 1))
        earlier = slice(0, n * k)
        F, Q = model.transition(np.zeros(n), u[k], DT[k])
        mean[now] = F @ mean[before] + model.propagate(np.zeros(n), u[k], DT[k])
        joint[now, earlier] = F @ joint[before, earlier]
        joint[earlier, now] = joint[now, earlier].T
        joint[now, now] = F @ joint[before, before] @ F.T + Q
    h = model.jacobian(0, np.zeros(n))
    rows = [k for k, z in enumerate(readings) if z is not None]
    H = np.zeros((2 * len(rows), n * count))
    for i, k in enumerate(rows):
        H[2 * i : 2 * i + 2, n * k : n * k + n] = h
    S = H @ joint @ H.T + model.model.variances[0] * np.eye(len(H))
    K = np.linalg.solve(S, H @ joint).T
    joint = joint - K @ H @ joint
    mean = mean + K @ (np.concatenate([readings[k] for k in rows]) - H @ mean)
    return mean.reshape(count, n), [joint[n * k : n * k + n, n * k : n * k + n] for k in range(count)]


@pytest.mark.parametrize("start", STARTS)
def test_it_is_the_joint_posterior_of_a_linear_model(spring, start):
    u, readings = recording()
    begin = np.ones(3), STARTS[start]
    smoothed = smooth(spring, DT, u, filtered(spring, begin, u, readings))
    mean, covariances = posterior(spring, begin, u, readings)
    for (x, P), x_joint, P_joint in zip(smoothed, mean, covariances, strict=True):
        np.testing.assert_allclose(x, x_joint, atol=1e-10)
        np.testing.assert_allclose(P, P_joint, atol=1e-11)


def test_a_motion_without_noise_is_the_joint_posterior_too(spring):
    """P_pred is singular at every row: all of the path follows from where it began on a line."""
    still = NumericModel(spring.model.with_numbers(density={"w": 0.0}))
    u, readings = recording()
    begin = np.ones(3), STARTS["known but along one line"]
    smoothed = smooth(still, DT, u, filtered(still, begin, u, readings))
    mean, covariances = posterior(still, begin, u, readings)
    np.testing.assert_allclose([x for x, _ in smoothed], mean, atol=1e-9)
    np.testing.assert_allclose([P for _, P in smoothed], covariances, atol=1e-10)


def attitudes(turning, belief):
    rng, count = np.random.default_rng(3), len(DT)
    u = 0.2 * rng.normal(size=(count, 3))
    readings = [turning.measure(0, belief[0]) + rng.normal(size=3) if k % 3 else None for k in range(count)]
    return u, filtered(turning, belief, u, readings)


def test_the_last_row_stays_and_no_covariance_grows(spring, turning, belief):
    u, readings = recording()
    for model, inputs, rows in (
        (spring, u, filtered(spring, (np.ones(3), np.eye(3)), u, readings)),
        (turning, *attitudes(turning, belief)),
    ):
        smoothed = smooth(model, DT, inputs, rows)
        assert smoothed[-1] is rows[-1]
        less = np.array([P - P_smooth for (_, P), (_, P_smooth) in zip(rows, smoothed, strict=True)])
        assert np.linalg.eigvalsh(less).min() > -1e-13 * np.abs(less).max()
        assert np.trace(less[0]) > 0.1 * np.trace(rows[0][1])


def test_prediction_alone_teaches_nothing(turning, belief):
    u, _ = attitudes(turning, belief)
    rows = filtered(turning, belief, u, [None] * len(DT))
    for (x, P), (x_smooth, P_smooth) in zip(rows, smooth(turning, DT, u, rows), strict=True):
        np.testing.assert_allclose(x_smooth, x, atol=1e-12)
        np.testing.assert_allclose(P_smooth, P, atol=1e-13)


def test_navigation_axes_may_be_turned(turning, belief):
    """The attitude's equations do not name a direction: turning all that was filtered turns what is smoothed."""
    u, rows = attitudes(turning, belief)
    turn = quat_from_rotvec([0.4, -1.1, 2.0])
    T = np.eye(6)
    T[:3, :3] = matrix_from_quat(turn)
    turned = [(np.r_[quat_multiply(turn, x[:4]), x[4:]], T @ P @ T.T) for x, P in rows]
    for (x, P), (x_turned, P_turned) in zip(smooth(turning, DT, u, rows), smooth(turning, DT, u, turned), strict=True):
        np.testing.assert_allclose(x_turned[:4], quat_multiply(turn, x[:4]), atol=1e-12)
        np.testing.assert_allclose(x_turned[4:], x[4:], atol=1e-12)
        np.testing.assert_allclose(P_turned, T @ P @ T.T, atol=1e-13)


def test_rows_of_one_instant_are_one_and_starts_cut(spring):
    u, readings = recording()
    dt = DT.copy()
    dt[8], dt[15] = 0.0, np.nan
    rows = filtered(spring, (np.ones(3), np.eye(3)), u, readings, np.nan_to_num(dt, nan=0.1))
    smoothed = smooth(spring, dt, u, rows)
    assert smoothed[7] is smoothed[8]
    assert smoothed[14] is rows[14]
    first = smooth(spring, dt[:15], u[:15], rows[:15])
    np.testing.assert_array_equal([x for x, _ in first], [x for x, _ in smoothed[:15]])


def test_the_covariance_is_the_textbooks_difference(spring):
    F, Q = spring.transition(np.zeros(3), np.zeros(1), 0.2)
    P, ahead = np.diag([1.0, 0.4, 2.0]) + 0.1, 0.05 * np.eye(3)
    G, P_smooth = back(F, Q, P, ahead)
    P_pred = F @ P @ F.T + Q
    np.testing.assert_allclose(G, P @ F.T @ np.linalg.inv(P_pred), atol=1e-13)
    np.testing.assert_allclose(P_smooth, P - G @ (P_pred - ahead) @ G.T, atol=1e-13)


@pytest.mark.parametrize("rank", range(7))
def test_a_semidefinite_system_is_solved_within_its_range(rank):
    rng = np.random.default_rng(rank)
    root = rng.normal(size=(6, rank)) * 10.0 ** rng.uniform(-3, 3, 6)[:, None]  # units differ
    M = root @ root.T
    B = M @ rng.normal(size=(6, 4))
    X = solve_semidefinite(M, B)
    scale = np.sqrt(np.diag(M))[:, None] * np.sqrt(np.diag(M)).max(initial=1e-300)
    np.testing.assert_allclose(M @ X, B, atol=1e-7 * np.abs(B).max() + 1e-9 * scale.max())
    assert np.count_nonzero(X.any(axis=1)) == rank  # rounding is no direction
    if rank == 6:
        np.testing.assert_allclose(X, np.linalg.solve(M, B), rtol=1e-4, atol=1e-7 * np.abs(X).max())


def test_a_known_number_stays_known(spring):
    """No variance and no noise on one number: it does not move, and the others are smoothed as without it."""
    P = np.diag([1.0, 1.0, 0.0])
    F = np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    Q, ahead = np.diag([0.1, 0.1, 0.0]), np.diag([0.3, 0.2, 0.0])
    G, P_smooth = back(F, Q, P, ahead)
    assert not G[2].any() and not P_smooth[2].any()
    two = slice(0, 2)
    G_two, P_two = smoother.back(F[two, two], Q[two, two], P[two, two], ahead[two, two])
    np.testing.assert_allclose(G[two, two], G_two, atol=1e-15)
    np.testing.assert_allclose(P_smooth[two, two], P_two, atol=1e-15)
