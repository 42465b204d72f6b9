"""The invariant filter: its derivatives by finite differences, its trap, its heading, and bad input."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.alignment import riekf
from robustnav.alignment.riekf import (
    Belief,
    InvariantStart,
    invariant_ekf,
    moved,
    predict,
    step_of,
    transition,
    turn_and_jacobian,
)
from robustnav.errors import InputError
from robustnav.frames import (
    euler_from_quat,
    matrix_from_quat,
    quat_from_matrix,
    quat_from_rotvec,
    quat_multiply,
    rotvec_from_quat,
    wrap_angle,
)
from robustnav.units import ARCMIN, DEG

from .conftest import COARSE, FINE, make_case, setup_of, tilt_of

CORRECTIONS = ("first order", "lie")


def matrix_from_rotvec(rotvec):
    return matrix_from_quat(quat_from_rotvec(rotvec))


def drawn(rng, m):
    C = matrix_from_rotvec(rng.normal(size=(m, 3)))
    return Belief(C, rng.normal(size=(m, 3)) * 3, *(1e-3 * rng.normal(size=(2, m, 3))), np.zeros((m, 12, 12)))


def times(C, v):
    return np.einsum("...ij,...j->...i", C, v)


def truth_at(belief, error):
    """The true state that has an error (m, 12) about the estimate."""
    turn = matrix_from_rotvec(error[:, :3])
    v = times(turn, belief.v) + error[:, 3:6]
    return Belief(turn @ belief.C, v, belief.gyro + error[:, 6:9], belief.accel + error[:, 9:], belief.P)


def error_of(C, v, C_est, v_est):
    turn = C @ C_est.swapaxes(-1, -2)
    return np.hstack([rotvec_from_quat(quat_from_matrix(turn)), v - times(turn, v_est)])


@pytest.mark.parametrize("size", [0.0, 1e-6, 3e-4, 0.1, 3.0])
def test_a_turn_is_the_rotation_and_its_jacobian_the_slope(size):
    theta = size * np.array([[0.6, -0.48, 0.64]])
    turn, J = turn_and_jacobian(theta)
    np.testing.assert_allclose(turn, matrix_from_rotvec(theta), atol=1e-12)
    for k in range(3):
        d = 1e-6 * np.eye(3)[k]
        ahead, behind = (turn_and_jacobian(theta + sign * d)[0] for sign in (1, -1))
        slope = rotvec_from_quat(quat_from_matrix(ahead @ behind.swapaxes(1, 2))) / 2e-6
        np.testing.assert_allclose(J[:, :, k], slope, atol=1e-8)


def test_the_transition_is_the_derivative_of_the_step():
    rng, m, h = np.random.default_rng(1), 5, 1e-6
    belief, step = drawn(rng, m), step_of(setup_of(FINE))
    J, H = 0.1 * np.eye(3) + 0.01 * rng.normal(size=(m, 3, 3)), 0.1 * rng.normal(size=(m, 3, 3))
    row = np.hstack([quat_from_rotvec(0.2 * rng.normal(size=(m, 3))), rng.normal(size=(m, 3)), J.reshape(m, 9)])
    row = np.hstack([row, H.reshape(m, 9)])
    turn = matrix_from_quat(row[:, :4])
    F, C, v = transition(belief, turn, row, step)
    for k in range(12):
        ends = []
        for sign in (1, -1):
            error = np.zeros((m, 12))
            error[:, k] = sign * h
            _, C_true, v_true = transition(truth_at(belief, error), turn, row, step)
            ends.append(error_of(C_true, v_true, C, v))
        slope = (ends[0] - ends[1]) / (2 * h)
        # J is the derivative at zero bias, and the Earth turns by 7e-6 within the step
        np.testing.assert_allclose(F[:, :, k], slope, atol=2e-4 * max(1.0, np.abs(slope).max()))


def test_what_a_step_adds_is_the_noise_of_the_sensors():
    rng, m = np.random.default_rng(6), 20000
    setup = replace(setup_of(FINE), gyro_density=1e-3, accel_density=2e-3)
    step, one = step_of(setup), drawn(rng, 1)
    belief = Belief(*(np.repeat(value, m, axis=0) for value in vars(one).values()))
    row = np.hstack([[1.0, 0, 0, 0], [0.3, -0.2, -0.98], 0.1 * np.eye(3).ravel(), np.zeros(9)])
    measured = np.tile(row, (m, 1))
    measured[:, :4] = quat_from_rotvec(setup.gyro_density * np.sqrt(setup.period) * rng.normal(size=(m, 3)))
    measured[:, 4:7] += setup.accel_density * np.sqrt(setup.period) * rng.normal(size=(m, 3))
    _, C, v = transition(belief, np.eye(3)[None], np.tile(row, (m, 1)), step)
    predict(belief, matrix_from_quat(measured[:, :4]), measured, step)
    found, claimed = np.cov(error_of(C, v, belief.C, belief.v).T), belief.P[0, :6, :6]
    np.testing.assert_allclose(claimed, found, atol=0.05 * np.abs(found).max())
    assert np.abs(claimed[3:, :3]).max() > 0.3 * claimed[0, 0]


@pytest.mark.parametrize("correction", CORRECTIONS)
@pytest.mark.parametrize("size", [1e-6, 0.05, 1.5])
def test_a_correction_moves_errors_as_it_says(correction, size):
    rng, m, h = np.random.default_rng(2), 4, 1e-6
    belief = drawn(rng, m)
    dx = np.hstack([size * rng.normal(size=(m, 3)), rng.normal(size=(m, 3))])
    C, v, G = moved(belief.C, belief.v, dx, correction)

    def truth(d):  # an error dx + d before the move, in the coordinates in which the correction is one of these
        turn, J = turn_and_jacobian((dx + d)[:, :3])
        nu = (dx + d)[:, 3:]
        shift = nu if correction == "first order" else times(J, nu)
        return error_of(turn @ belief.C, times(turn, belief.v) + shift, C, v)

    np.testing.assert_allclose(truth(0 * dx), 0, atol=1e-12)
    for k in range(6):
        d = np.zeros((m, 6))
        d[:, k] = h
        slope = (truth(d) - truth(-d)) / (2 * h)
        np.testing.assert_allclose(G[:, :, k], slope, atol=1e-7)


def runs_of(gyro_rms, wind, seconds, runs=6):
    cases = [make_case(setup_of(gyro_rms), 40 + k, seconds, wind) for k in range(runs)]
    rows = np.array([case.increments.rows for case in cases])
    z = np.array([np.hstack([case.reference, np.zeros((len(case.t), 1))]) for case in cases])
    return cases, rows, z


def started(cases, sd, rng):
    m = rng.normal(size=(len(cases), 3)) * sd
    q = np.array([case.q_nb[0] for case in cases])
    return InvariantStart(quat_multiply(quat_from_rotvec(m), q), np.tile(sd, (len(cases), 1)))


@pytest.fixture(scope="module")
def coarse():
    return runs_of(COARSE, "lines", 60.0)


@pytest.mark.parametrize("correction", CORRECTIONS)
def test_it_levels_in_wind(coarse, correction):
    cases, rows, z = coarse
    start = started(cases, np.array([10.0, 10.0, 60.0]) * DEG, np.random.default_rng(3))
    said = invariant_ekf(rows, z, start, replace(setup_of(COARSE), reference_sd=1.0), correction)
    assert said.q_nb.shape == (len(cases), len(cases[0].t) + 1, 4)
    np.testing.assert_allclose(matrix_from_quat(said.q_nb[:, 0]), matrix_from_quat(start.q_nb), atol=1e-14)
    last = [np.linalg.norm(tilt_of(q[-1:], case.q_nb[-1:])) for q, case in zip(said.q_nb, cases, strict=True)]
    assert np.median(last) < 10 * ARCMIN


def test_mean_wind_is_not_taken_for_heading_when_errors_are_carried_along(coarse, monkeypatch):
    """Two readings tell nothing of heading: its sd must stay what it was; without the transport it falls."""
    cases, rows, z = coarse
    exact = started(cases, np.zeros(3), np.random.default_rng(4))
    start, setup = replace(exact, sd=exact.sd + np.array([2.0, 2.0, 15.0]) * DEG), setup_of(COARSE)

    def heading_sd():
        return np.sqrt(invariant_ekf(rows[:, :2], z[:, :2], start, setup).P[:, -1, 2, 2]) / DEG

    assert (heading_sd() > 14.0).all()
    real = riekf.moved

    def forgetful(*arguments):
        C, v, G = real(*arguments)
        return C, v, np.tile(np.eye(6), (len(G), 1, 1))

    monkeypatch.setattr(riekf, "moved", forgetful)
    assert (heading_sd() < 8.0).all()


def test_along_the_group_it_knows_how_well_it_has_heading():
    """In wind the correction along the group keeps its own word about heading; first order claims far too much."""
    cases, rows, z = runs_of(FINE, "lines", 120.0, runs=8)
    start = started(cases, np.array([3.0, 3.0, 20.0]) * DEG, np.random.default_rng(5))
    true, setup = np.array([case.q_nb[-1] for case in cases]), replace(setup_of(FINE), reference_sd=1.0)
    off, nees = {}, {}
    for correction in CORRECTIONS:
        said = invariant_ekf(rows, z, start, setup, correction)
        error = wrap_angle(euler_from_quat(true)[:, 2] - euler_from_quat(said.q_nb[:, -1])[:, 2])
        off[correction] = np.median(np.abs(error)) / DEG
        nees[correction] = np.mean(error**2 / said.P[:, -1, 2, 2])
    assert off["lie"] < 6.0 < off["first order"]
    assert nees["lie"] < 3.0 and nees["first order"] > 10.0


def test_shapes_that_do_not_fit_are_named():
    with pytest.raises(InputError, match=r"rows \(2, 5, 24\)"):
        start = InvariantStart(np.ones((2, 4)), np.ones((2, 3)))
        invariant_ekf(np.zeros((2, 5, 24)), np.zeros((2, 5, 3)), start, setup_of(FINE))
