"""One filter: Jacobians by finite differences, transport, the robust update, the compiled form, consistency."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.stats import chi2, multivariate_normal

from robustnav.alignment.filter import (
    COMPASS,
    RATE,
    Belief,
    Core,
    anchor,
    core_transition,
    graft,
    inject,
    observation,
    predict,
    start,
    update,
    wind_transition,
)
from robustnav.alignment.heading import answer
from robustnav.alignment.readings import VELOCITY, reading_rows
from robustnav.alignment.setting import Wind
from robustnav.engine import _kernel
from robustnav.frames import matrix_from_quat, quat_conjugate, quat_from_rotvec, quat_multiply, rotvec_from_quat

from .conftest import COARSE, FINE, Case, make_case, setup_of, tilt_of

TWO_LINES = Wind(0.1, 2.0, (0.7, 1.9), (0.1, 0.05))


def some_belief(rng: np.random.Generator, wind: Wind = TWO_LINES) -> Belief:
    belief = start(setup_of(COARSE), wind, quat_from_rotvec(rng.normal(size=3)), np.array([2.0, -1.0]))
    n = len(belief.P)
    root = rng.normal(size=(n, n)) * 0.1 * np.sqrt(np.diag(belief.P) + 1e-6)[:, None]
    core = replace(belief.core, x=belief.core.x + np.array([0.3, 0.1, *[1e-3] * 3, *[2e-2] * 3, 5e-5, -3e-5]))
    return replace(belief, core=core, d=belief.d + 0.2 * rng.normal(size=len(belief.d)), P=root @ root.T)


def moved(core: Core, e: np.ndarray) -> Core:
    return Core(quat_multiply(quat_from_rotvec(e[:3]), core.q), core.x + e[3:])


def difference(a: Core, b: Core) -> np.ndarray:
    return np.concatenate([rotvec_from_quat(quat_multiply(a.q, quat_conjugate(b.q))), a.x - b.x])


@pytest.mark.parametrize("seed", range(3))
def test_common_jacobian_is_that_of_the_step(seed):
    rng, case = np.random.default_rng(seed), make_case(setup_of(COARSE), seed, 1.0, "lines")
    # At the truth, where the specific force is that of gravity as the Jacobian has it; biases are small there.
    core = replace(some_belief(rng).core, q=case.q_nb[3])
    core = replace(core, x=core.x * np.r_[np.ones(2), np.full(6, 1e-3), np.ones(2)])
    row = reading_rows(case.increments, case.reference)[4]
    F, after = core_transition(core, case.setup, row)[1], core_transition(core, case.setup, row)[0]
    for j in range(COMPASS):
        h = 1e-3 if j < 5 else 1e-6
        e = h * np.eye(COMPASS)[j]
        both = [difference(core_transition(moved(core, s * e), case.setup, row)[0], after) for s in (1, -1)]
        slope = (both[0] - both[1]) / (2 * h)
        # The Coriolis turn of a tilt and the turn of the Earth rate in the attitude are left out: period x rate.
        np.testing.assert_allclose(F[:, j], slope, atol=2e-4 * max(1.0, abs(slope).max()))


def test_wind_jacobian_is_that_of_the_step():
    belief = some_belief(np.random.default_rng(1))
    _, F, _ = wind_transition(belief, 0.1)
    for j in range(len(belief.d)):
        e = 1e-5 * np.eye(len(belief.d))[j]
        ahead = [wind_transition(replace(belief, d=belief.d + s * e), 0.1)[0] for s in (1, -1)]
        np.testing.assert_allclose(F[:, j], (ahead[0] - ahead[1]) / 2e-5, atol=1e-8)


def test_the_markov_part_is_stationary():
    belief = start(setup_of(), Wind(0.5, 4.0), np.array([1.0, 0, 0, 0]), np.zeros(2))
    _, F, Q = wind_transition(belief, 0.1)
    P = np.diag([0.25, 0.25])
    np.testing.assert_allclose(F @ P @ F.T + np.diag(Q), P, rtol=1e-12)


def test_injection_carries_the_covariance_to_the_new_attitude():
    """The error of a cloud of attitudes, measured from the corrected one, has the transported covariance."""
    rng = np.random.default_rng(2)
    belief, dx = some_belief(rng), np.zeros(25)
    dx[:3] = [0.4, -0.3, 0.5]
    cloud = 1e-4 * rng.normal(size=(40000, 3)) @ np.diag([1.0, 2.0, 0.5])
    small = replace(belief, P=np.zeros((25, 25)))
    small.P[:3, :3] = 1e-8 * np.diag([1.0, 4.0, 0.25])
    after = inject(small, dx)
    truth = quat_multiply(quat_from_rotvec(dx[:3] + cloud), belief.core.q)
    errors = rotvec_from_quat(quat_multiply(truth, quat_conjugate(after.core.q)))
    np.testing.assert_allclose(np.cov(errors.T), after.P[:3, :3], atol=1.5e-9)
    assert np.abs(np.cov(errors.T) - small.P[:3, :3]).max() > 5e-9


def test_without_gusts_the_update_is_the_textbook_one():
    belief, setup = some_belief(np.random.default_rng(3)), setup_of(gust_share=0.0)
    z, H = np.array([2.3, -0.7]), observation(some_belief(np.random.default_rng(3)))
    S = H @ belief.P @ H.T + setup.reference_sd**2 * np.eye(2)
    K = belief.P @ H.T @ np.linalg.inv(S)
    r = z - belief.core.velocity - H[:, COMPASS:] @ belief.d
    expected = inject(replace(belief, P=(np.eye(25) - K @ H) @ belief.P), K @ r)
    after = update(belief, setup, z)
    np.testing.assert_allclose(after.P, expected.P, atol=1e-12)
    np.testing.assert_allclose(after.core.x, expected.core.x, atol=1e-12)
    assert after.log_likelihood == pytest.approx(multivariate_normal(cov=S).logpdf(r))
    assert after.misfit == pytest.approx(r @ np.linalg.solve(S, r))


def test_a_gust_moves_little_and_costs_a_bounded_likelihood():
    rng = np.random.default_rng(4)
    belief, setup = replace(some_belief(rng), P=1e-6 * np.eye(25)), setup_of()
    said = belief.core.velocity + observation(belief)[:, COMPASS:] @ belief.d
    calm, blown = (update(belief, setup, said + np.array([off, 0.0])) for off in (0.03, 4.0))
    pull = [np.abs(after.core.velocity - belief.core.velocity).max() for after in (calm, blown)]
    assert pull[1] < 0.1 * pull[0]
    assert calm.log_likelihood - blown.log_likelihood < 15
    assert blown.misfit < 0.1


def anchored_run(case: Case, gain: float, turn: float = 0.0) -> Belief:
    """Take eight seconds of readings, their velocity times ``gain``, at an anchor turned about down."""
    q = quat_multiply(quat_from_rotvec([0.0, 0.0, turn]), case.q_nb[0])
    belief = anchor(start(case.setup, Wind(0.1, 4.0), q, np.zeros(2), np.array([0.02, -0.01, 0.03])))
    for row in reading_rows(case.increments, gain * case.reference):
        belief = update(predict(belief, case.setup, row), case.setup, row[VELOCITY])
    return belief


def test_what_an_anchored_filter_claims_does_not_depend_on_what_it_reads():
    case = make_case(setup_of(COARSE, gyro_bias_sd=0.05, accel_bias_sd=0.45, gust_share=0.0), 8, 8.0, "none")
    calm, blown = anchored_run(case, 1.0), anchored_run(case, 1.3)
    np.testing.assert_array_equal(calm.P, blown.P)
    assert np.abs(calm.estimate.gyro_bias - blown.estimate.gyro_bias).max() > 1e-3
    np.testing.assert_array_equal(calm.core.gyro_bias, [0.02, -0.01, 0.03])


def test_a_graft_on_an_anchored_belief_knows_what_that_knew():
    case = make_case(setup_of(COARSE, gyro_bias_sd=0.05, accel_bias_sd=0.45), 8, 8.0, "none")
    known = anchored_run(case, 1.0)
    grafted = graft(known, Wind(0.3, 2.0, (1.0,), (0.1,)))
    assert np.linalg.norm(known.off[:2]) > 0.01
    np.testing.assert_array_equal(grafted.estimate.q, known.estimate.q)
    np.testing.assert_array_equal(grafted.estimate.x, known.estimate.x)
    free = np.diag([*np.zeros(3), 9.0, 9.0, *np.zeros(8)])
    np.testing.assert_allclose(grafted.P[:13, :13], known.P[:13, :13] + free)


def test_mean_wind_teaches_no_heading():
    """Five seconds of a steady 3.4 m/s say nothing of north, however precise the reference."""
    case = make_case(setup_of(FINE), 5, 5.0, "none")
    belief = start(case.setup, Wind(0.0, 4.0), case.q_nb[0], np.zeros(2))
    for row in reading_rows(case.increments, case.reference):
        belief = update(predict(belief, case.setup, row), case.setup, row[VELOCITY])
    said = answer(belief, case.setup)
    assert said.concentration < 0.1
    assert np.sqrt(belief.P[RATE, RATE]) > 1e-4


def one_filter(case, wind, real="double", field=None):
    n, rows = len(case.t), reading_rows(case.increments, case.reference, field)
    omega = np.zeros((2, 5))
    omega[0, : len(wind.omega)], omega[1, : len(wind.omega)] = wind.omega, wind.omega_sd
    numbers = np.concatenate([[wind.markov_sd, wind.markov_time], omega.ravel()])
    answers, likelihood, state, P = np.empty((n, 22)), np.empty(n), np.empty(42), np.empty(1681)
    arguments = (case.setup.numbers, numbers, case.q_nb[0], np.zeros(2), rows, answers, likelihood, state, P)
    _kernel.align_one(real, *arguments)
    return answers, likelihood, state, P


@pytest.mark.parametrize("wind", [Wind(0.5, 4.0), TWO_LINES, Wind(0.0, 1.0, (0.5,), (0.0,))])
def test_compiled_equals_numpy(wind):
    case = make_case(setup_of(COARSE), 6, 8.0, "gusts")
    belief, said = start(case.setup, wind, case.q_nb[0], np.zeros(2)), []
    for row in reading_rows(case.increments, case.reference):
        belief = update(predict(belief, case.setup, row), case.setup, row[VELOCITY])
        said.append(answer(belief, case.setup).row)
    answers, likelihood, state, P = one_filter(case, wind)
    n = len(belief.P)
    np.testing.assert_allclose(P[: n * n].reshape(n, n), belief.P, rtol=1e-7, atol=1e-14)
    np.testing.assert_allclose(
        state[: 14 + n - COMPASS], np.concatenate([belief.core.q, belief.core.x, belief.d]), atol=1e-9
    )
    assert likelihood[-1] == pytest.approx(belief.log_likelihood, abs=1e-8)
    np.testing.assert_allclose(answers, said, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("gyro_rms", [FINE, COARSE])
def test_tilt_and_heading_are_as_good_as_they_say(gyro_rms):
    """NEES inside its 99 % band over runs, gyros that can find north and gyros that cannot."""
    runs, tilt, heading = 40, [], []
    for seed in range(runs):
        case = make_case(setup_of(gyro_rms), 100 + seed, 60.0, "markov")
        last = one_filter(case, Wind(0.5, 4.0))[0][-1]
        q = quat_multiply(quat_from_rotvec([last[4], last[5], 0.0]), last[:4])
        error = tilt_of(q[None], case.q_nb[-1:])[0]
        cov = np.array([[last[6], last[7]], [last[7], last[8]]])
        tilt.append(error @ np.linalg.solve(cov, error))
        C = matrix_from_quat(case.q_nb[-1])
        off = (last[9] - np.arctan2(C[1, 0], C[0, 0]) + pi) % (2 * pi) - pi
        heading.append(off**2 / last[10])
    low, high = chi2.ppf([0.005, 0.995], 2 * runs) / runs
    assert low < np.mean(tilt) < high
    # A heading that is flat on the circle has a variance of pi^2 / 3, but no tails.
    low, high = chi2.ppf([0.005, 0.995], runs) / runs
    assert low < np.mean(heading) < high
