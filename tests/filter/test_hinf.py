"""The H-infinity update: four forms of one Riccati step, existence as the pivots say, Kalman as gamma grows."""

from itertools import pairwise

import numpy as np
import pytest

from robustnav.filter.hinf import enlarge
from robustnav.filter.ukf import Spread
from robustnav.models import AlignmentNoise, alignment
from robustnav.records import Log, Stream
from robustnav.run import UKF, HInfinity, Start, run


def draw(rng, n, rows):
    A = rng.normal(size=(n, n))
    return A @ A.T + 0.1 * np.eye(n), rng.normal(size=(rows, n)), rng.normal(size=(int(rng.integers(1, n + 1)), n))


def kalman(P, H):
    return P - P @ H.T @ np.linalg.solve(H @ P @ H.T + np.eye(len(H)), H @ P)


def published(P, H, L, gamma):
    """The publication's Riccati line with the indefinite weight Re, and its existence condition."""
    both = np.vstack([H, L])
    Re = np.block(
        [
            [np.eye(len(H)) + H @ P @ H.T, H @ P @ L.T],
            [L @ P @ H.T, -(gamma**2) * np.eye(len(L)) + L @ P @ L.T],
        ]
    )
    exists = np.linalg.eigvalsh(np.linalg.inv(P) + H.T @ H - L.T @ L / gamma**2)[0] > 0
    return P - P @ both.T @ np.linalg.solve(Re, both @ P), exists


def test_it_is_the_published_riccati_step_and_fails_exactly_when_that_does():
    rng, verdicts = np.random.default_rng(1), []
    for _ in range(600):
        n = int(rng.integers(1, 9))
        P, H, L = draw(rng, n, int(rng.integers(1, 4)))
        Pf = kalman(P, H)
        gamma = float(np.sqrt(np.linalg.eigvalsh(L @ Pf @ L.T)[-1] * 10 ** rng.uniform(-1.0, 1.0)))
        expected, exists = published(P, H, L, gamma)
        found, margin = enlarge(Pf, L, gamma)
        assert (margin > 0) == exists
        verdicts.append(exists)
        if not exists:
            np.testing.assert_array_equal(found, Pf)
            continue
        np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())
        information = np.linalg.inv(np.linalg.inv(Pf) - L.T @ L / gamma**2)
        np.testing.assert_allclose(found, information, rtol=1e-6, atol=1e-8 * np.abs(expected).max())
        pivots = np.diag(np.linalg.cholesky(gamma**2 * np.eye(len(L)) - L @ Pf @ L.T)) ** 2 / gamma**2
        assert margin == pytest.approx(pivots.min(), rel=1e-6)
        assert np.linalg.eigvalsh(found - Pf)[0] > -1e-9 * np.abs(found).max()  # it only adds
    assert 100 < sum(verdicts) < 500


def test_a_covariance_that_is_not_a_number_does_not_exist():
    P = np.eye(2) * np.nan
    _, margin = enlarge(P, np.eye(2), 5.0)
    assert not margin > 0


@pytest.fixture(scope="module")
def moored():
    """A unit at rest, level, in increments of a tenth of a second, with a velocity reference."""
    rng, n, T = np.random.default_rng(3), 120, 0.1
    model = alignment(
        AlignmentNoise(1e-4, 1e-3, 1e-6, 1e-5, 0.1), gravity=9.8, earth_rate_north=6e-5, earth_rate_down=-4e-5
    )
    t, eye = T * np.arange(1, n + 1), np.tile((T * np.eye(3)).ravel(), (n, 1))
    u = {
        "turn": np.column_stack([np.ones(n), 1e-5 * rng.normal(size=(n, 3))]),
        "velocity_increment": np.tile([0.0, 0.0, -9.8 * T], (n, 1)) + 1e-4 * rng.normal(size=(n, 3)),
        "turn_by_bias": eye,
        "velocity_by_bias": np.zeros((n, 9)),
    }
    streams = {name: Stream(name, t, values, "1", "b") for name, values in u.items()}
    streams["velocity"] = Stream("velocity", t, 0.1 * rng.normal(size=(n, 3)), "m/s", "n")
    sd = {"quaternion": (1e-4, 0.05, 0.05, 0.2)}
    return model, Log(streams, "made"), Start.at(model, sd)


def test_it_becomes_the_unscented_filter_as_gamma_grows(moored):
    model, log, start = moored
    kalman_run, spread = run(UKF(model, Spread(1.0, 2.0)), log, start), Spread(1.0, 2.0)
    distances = []
    for gamma in (10.0, 1e2, 1e3, 1e6):
        one = run(HInfinity(model, gamma, spread=spread), log, start)
        margin = one.innovations["velocity"].margin
        assert margin is not None and (margin > 0).all() and margin[-1] > 1 - 100 / gamma**2
        distances.append(np.abs(one.sd["quaternion"] - kalman_run.sd["quaternion"]).max())
    assert distances[0] > 1e-5 and all(b < 0.05 * a for a, b in pairwise(distances[:-1]))
    assert distances[-1] < 1e-10


def test_a_bound_too_tight_is_reported_and_the_run_goes_on(moored):
    model, log, start = moored
    one = run(HInfinity(model, 0.5), log, start)  # the start's velocity is known to 3 m/s
    margin = one.innovations["velocity"].margin
    assert margin is not None and (margin <= 0).any()
    assert np.isfinite(one.state["v_n"]).all()
    assert any("bound" in event and "not" in event for event in one.events)


def test_tolerances_choose_and_scale_what_is_bounded(moored):
    model = moored[0]
    L = HInfinity(model, 2.0, {"quaternion": 0.1}).bounded
    assert L.shape == (4, 13)
    np.testing.assert_array_equal(L[:, 3:7], 10 * np.eye(4))
    np.testing.assert_array_equal(HInfinity(model, 2.0).bounded, np.eye(13))


@pytest.mark.parametrize(
    ("gamma", "tolerances", "words"),
    [(0.0, None, "gamma"), (np.inf, None, "gamma"), (1.0, {"q": 1.0}, "'q'"), (1.0, {"v_n": 0.0}, "'v_n'")],
)
def test_bad_bounds_are_named(moored, gamma, tolerances, words):
    from robustnav.errors import InputError

    with pytest.raises(InputError, match=words):
        HInfinity(moored[0], gamma, tolerances)
