"""Trajectories: the interval-mean rate reproduces the attitude, and agrees with rates derived another way."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import euler_from_quat, matrix_from_quat, quat_from_rotvec, quat_multiply
from robustnav.sim.trajectory import (
    BodyTurns,
    Motion,
    SineAttitude,
    Turn,
    case_one,
    case_two,
    full_roll_and_pitch,
    steady_turn,
)

DEG = np.pi / 180
ALL = [case_one(), case_two(), steady_turn(duration=30.0), full_roll_and_pitch()]


def body_rate_of_sines(case, t):
    """Analytic body rate from Euler angle rates (the inverse of the kinematic matrix T)."""
    angle = np.multiply.outer(t, case.frequency) + case.phase
    euler = case.amplitude * np.sin(angle)
    rate = case.amplitude * np.asarray(case.frequency) * np.cos(angle)
    (roll, pitch, _), (p, q, r) = euler.T, rate.T
    return np.stack(
        [
            p - np.sin(pitch) * r,
            np.cos(roll) * q + np.sin(roll) * np.cos(pitch) * r,
            -np.sin(roll) * q + np.cos(roll) * np.cos(pitch) * r,
        ],
        axis=1,
    )


@pytest.mark.parametrize("trajectory", ALL)
def test_integrating_the_rate_reproduces_the_attitude(trajectory):
    motion = trajectory.sample()
    dt = np.diff(motion.t)
    q, worst = motion.q_nb[0], 0.0
    for k in range(1, len(motion.t)):
        q = quat_multiply(q, quat_from_rotvec(motion.omega_b[k] * dt[k - 1]))
        worst = max(worst, min(np.abs(q - motion.q_nb[k]).max(), np.abs(q + motion.q_nb[k]).max()))
    assert worst < 1e-12
    np.testing.assert_array_equal(motion.omega_b[0], motion.omega_b[1])
    np.testing.assert_allclose(np.linalg.norm(motion.q_nb, axis=1), 1.0, atol=1e-12)
    assert not motion.acceleration_n.any()


@pytest.mark.parametrize("case", [case_one(), case_two()])
def test_mean_rate_is_the_instantaneous_rate_at_mid_interval_to_second_order(case):
    def worst(rate_hz):
        motion = replace(case, rate_hz=rate_hz).sample()
        middle = (motion.t[1:] + motion.t[:-1]) / 2
        return np.abs(motion.omega_b[1:] - body_rate_of_sines(case, middle)).max()

    assert worst(100.0) < 1e-4
    assert worst(50.0) / worst(100.0) == pytest.approx(4.0, rel=0.02)


def test_finite_difference_of_the_matrix():
    # C_dot = C [omega]x, so the skew part of C(t)^T C(t+h) / h tends to the mean rate.
    motion = replace(case_two(), rate_hz=1000.0).sample()
    C = matrix_from_quat(motion.q_nb)
    relative = np.einsum("nji,njk->nik", C[:-1], C[1:])
    odd = (relative - relative.transpose(0, 2, 1)) / 2
    rate = np.stack([odd[:, 2, 1], odd[:, 0, 2], odd[:, 1, 0]], axis=1) * 1000.0
    np.testing.assert_allclose(rate, motion.omega_b[1:], atol=1e-5)


def test_published_cases():
    one, two = case_one().sample(), case_two().sample()
    assert (len(one.t), one.t[-1], one.rate_hz) == (5001, 50.0, pytest.approx(100.0))
    assert (len(two.t), two.t[-1]) == (1001, 10.0)
    peaks = np.abs(euler_from_quat(one.q_nb)).max(axis=0) / DEG
    np.testing.assert_allclose(peaks, [20, 15, 25], rtol=1e-6)  # a quarter period of pi/50 rad/s is 25 s
    assert (np.abs(euler_from_quat(two.q_nb)).max(axis=0) > 30 * DEG).all()
    np.testing.assert_allclose(one.q_nb[0], [1, 0, 0, 0])
    np.testing.assert_allclose(euler_from_quat(two.q_nb[150]), np.array([50, 45, 80]) * DEG, rtol=1e-9)


def test_steady_turn():
    motion = steady_turn(20 * DEG, 9.0).sample()
    np.testing.assert_allclose(motion.omega_b, np.tile([0, 0, 20 * DEG], (901, 1)), atol=1e-12)
    np.testing.assert_allclose(matrix_from_quat(motion.q_nb[-1]) @ [1, 0, 0], [-1, 0, 0], atol=1e-12)


def test_full_roll_and_pitch_passes_every_attitude_and_rests_between():
    motion = full_roll_and_pitch().sample()
    roll, pitch, _ = euler_from_quat(motion.q_nb).T
    assert np.ptp(roll[:1000]) > 359 * DEG
    assert pitch.max() > 89.7 * DEG and pitch.min() < -89.7 * DEG
    assert np.abs(pitch[:1001]).max() < 1e-9
    np.testing.assert_allclose(np.abs(motion.q_nb[[1000, 2000], 0]), 1.0, atol=1e-12)  # level, north
    assert np.abs(motion.omega_b[[1, 1000, 1001, 2000]]).max() < 1e-3
    assert np.abs(motion.omega_b[:1001, 1:]).max() < 1e-12 and np.abs(motion.omega_b[1001:, [0, 2]]).max() < 1e-12
    assert np.abs(np.diff(motion.omega_b, axis=0)).max() < 0.005  # no jump of the rate


def test_turns_are_about_body_axes():
    turns = BodyTurns((Turn((0, 0, np.pi / 2), 1.0), Turn((np.pi / 2, 0, 0), 1.0)), 10.0, eased=False)
    C = matrix_from_quat(turns.sample().q_nb[-1])
    np.testing.assert_allclose(C, [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-12)  # forward is east, right is down


@pytest.mark.parametrize("duration", [0.29, 0.57, 1.1])
def test_last_sample_is_at_the_duration(duration):
    assert steady_turn(duration=duration).sample().t[-1] == pytest.approx(duration, abs=1e-12)


ZERO = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda: SineAttitude((1.0, 2.0), ZERO, ZERO, 1.0, 10.0),
        lambda: SineAttitude(ZERO, (np.nan, 0.0, 0.0), ZERO, 1.0, 10.0),
        lambda: SineAttitude(ZERO, ZERO, ZERO, -1.0, 10.0),
        lambda: SineAttitude(ZERO, ZERO, ZERO, np.nan, 10.0),
        lambda: SineAttitude(ZERO, ZERO, ZERO, 1.0, np.inf),
        lambda: SineAttitude(ZERO, ZERO, ZERO, 0.05, 10.0),
        lambda: BodyTurns((), 10.0, eased=True),
        lambda: BodyTurns((Turn(ZERO, 0.0),), 10.0, eased=True),
        lambda: BodyTurns((Turn((np.inf, 0.0, 0.0), 1.0),), 10.0, eased=True),
        lambda: Motion(np.zeros(1), np.ones((1, 4)), np.zeros((1, 3)), np.zeros((1, 3))),
        lambda: Motion(np.array([0, 1, 3.0]), np.ones((3, 4)), np.zeros((3, 3)), np.zeros((3, 3))),
        lambda: Motion(np.array([0, 0.0]), np.ones((2, 4)), np.zeros((2, 3)), np.zeros((2, 3))),
        lambda: Motion(np.arange(3.0), np.ones((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))),
    ],
)
def test_bad_input(make):
    with pytest.raises(InputError):
        make()
