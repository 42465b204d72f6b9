import numpy as np
import pytest

from robustnav.design import PathRows, posterior_bound
from robustnav.errors import EstimatorError, InputError


def path(seed, steps=6, n=3, m=2):
    rng = np.random.default_rng(seed)
    F = np.eye(n) + 0.3 * rng.normal(size=(steps, n, n))
    G = rng.normal(size=(steps, n, n))
    H = rng.normal(size=(steps, m, n))
    L = rng.normal(size=(n, n))
    return F, G @ np.swapaxes(G, 1, 2), H, L @ L.T + np.eye(n)


@pytest.mark.parametrize("seed", range(3))
def test_equals_the_inverse_of_the_joint_information(seed):
    """Independent route: Fisher information of the whole trajectory, inverted at once."""
    F, Q, H, P0 = path(seed)
    variance = np.array([0.5, 2.0])
    used = np.array([True, True, False, True, False, True])
    steps, n = len(F), F.shape[1]
    joint = np.zeros(((steps + 1) * n,) * 2)
    joint[:n, :n] = np.linalg.inv(P0)
    for k in range(steps):
        error = np.zeros((n, len(joint)))
        error[:, k * n : (k + 1) * n] = -F[k]
        error[:, (k + 1) * n : (k + 2) * n] = np.eye(n)
        joint += error.T @ np.linalg.solve(Q[k], error)
        here = slice((k + 1) * n, (k + 2) * n)
        if used[k]:
            joint[here, here] += H[k].T @ (H[k] / variance[:, None])
    expected = np.linalg.inv(joint)[-n:, -n:]
    P = posterior_bound(F, Q, [PathRows(H, variance, used)], P0)
    assert np.allclose(P[-1], expected, rtol=1e-9)
    assert np.array_equal(P, np.swapaxes(P, 1, 2))


def test_two_sensors_equal_one_stacked():
    F, Q, H, P0 = path(4)
    both = posterior_bound(F, Q, [(H[:, :1], 0.5), (H[:, 1:], 2.0)], P0)
    assert np.allclose(both, posterior_bound(F, Q, [(H, np.array([0.5, 2.0]))], P0), rtol=1e-10)


def test_batch_equals_one_by_one():
    paths = [path(seed) for seed in range(4)]
    F, Q, H = (np.stack([p[i] for p in paths], axis=1) for i in range(3))
    P0 = np.stack([p[3] for p in paths])
    used = np.random.default_rng(0).random((6, 4)) < 0.6
    batch = posterior_bound(F, Q, [(H, 1.0, used)], P0)
    for i, (F_i, Q_i, H_i, P0_i) in enumerate(paths):
        assert np.allclose(batch[:, i], posterior_bound(F_i, Q_i, [(H_i, 1.0, used[:, i])], P0_i), rtol=1e-12)
    shared = posterior_bound(F, Q[:, :1], [(H, 1.0, used[:, 0])], P0[0])
    assert np.allclose(shared[:, 0], posterior_bound(F[:, 0], Q[:, 0], [(H[:, 0], 1.0, used[:, 0])], P0[0]))


def test_error_of_the_linear_filter_attains_it():
    """Monte Carlo of the optimal estimator on a scalar random walk: mean square inside its chi-square band."""
    rng = np.random.default_rng(11)
    runs, steps, q, r, p0 = 4000, 12, 0.3, 1.5, 2.0
    one = np.ones((steps, 1, 1))
    P = posterior_bound(one, q * one, [(one, r)], [[p0]])[:, 0, 0]
    error = np.sqrt(p0) * rng.normal(size=runs)
    for k in range(steps):
        error = error - np.sqrt(q) * rng.normal(size=runs)
        error = error + (P[k] / r) * (np.sqrt(r) * rng.normal(size=runs) - error)
        assert np.mean(error**2) / P[k] == pytest.approx(1, abs=4 * np.sqrt(2 / runs))


def test_unused_rows_may_be_missing():
    F, Q, H, P0 = path(1)
    used = np.array([True, False, True, True, False, True])
    holes = np.where(used[:, None, None], H, np.nan)
    assert np.array_equal(posterior_bound(F, Q, [(holes, 1.0, used)], P0), posterior_bound(F, Q, [(H, 1.0, used)], P0))
    with pytest.raises(InputError, match="update 0"):
        posterior_bound(F, Q, [(holes, 1.0)], P0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"F": np.eye(3)}, "Jacobians F"),
        ({"Q": np.ones((6, 2, 2))}, "noise Q"),
        ({"updates": [(np.ones((5, 1, 3)), 1.0)]}, "Jacobians H, update 0"),
        ({"updates": [(np.ones((6, 1, 3)), 0.0)]}, "variance, update 0"),
        ({"updates": [(np.ones((6, 1, 3)), 1.0, np.ones(5, bool))]}, "mask"),
        ({"P0": np.full((3, 3), np.nan)}, "P0"),
    ],
)
def test_bad_input(change, words):
    F, Q, H, P0 = path(0)
    arguments = {"F": F, "Q": Q, "updates": [(H, 1.0)], "P0": P0} | change
    with pytest.raises(InputError, match=words):
        posterior_bound(**arguments)


def test_negative_start_covariance():
    F, Q, H, _ = path(0)
    with pytest.raises(EstimatorError, match="step 0"):
        posterior_bound(F, 0 * Q, [(H, 1.0)], -100 * np.eye(3))
