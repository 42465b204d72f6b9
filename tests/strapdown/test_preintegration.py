"""Pre-integration against motions whose rotation and velocity are known in closed form."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import matrix_from_quat, quat_conjugate, quat_from_rotvec, quat_multiply, rotation_error
from robustnav.strapdown import ImuSamples, Increments, preintegrate


def coning(half_angle, rate, n, dt):
    """Attitude (n + 1, 4) and integrated rate (n, 3) of an axis that goes round a cone, both exact."""
    t = np.arange(n + 1) * dt
    c, s = np.cos(half_angle / 2), np.sin(half_angle / 2)
    zero = np.zeros_like(t)
    q = np.stack([c + zero, s * np.cos(rate * t), s * np.sin(rate * t), zero], axis=-1)
    # body rate: rate * (-sin(a) sin, sin(a) cos, -2 sin^2(a/2)), integrated
    integral = np.stack(
        [np.sin(half_angle) * np.cos(rate * t), np.sin(half_angle) * np.sin(rate * t), -2 * s * s * rate * t], axis=-1
    )
    return q, np.diff(integral, axis=0)


def far(q_est, q_true):
    return float(np.linalg.norm(rotation_error(q_est, q_true)))


def coning_errors(half_angle_deg, n, dt):
    """Angle [rad] by which pre-integration, and plain summing, end beside the truth."""
    q, angle = coning(np.radians(half_angle_deg), 2 * np.pi * 10, n, dt)
    true = quat_multiply(quat_conjugate(q[0]), q[-1])
    plain = np.array([1.0, 0, 0, 0])
    for step in quat_from_rotvec(angle):
        plain = quat_multiply(plain, step)
    whole = preintegrate(ImuSamples(angle, np.zeros_like(angle), dt), n).rotation[0]
    return far(whole, true), far(plain, true)


@pytest.mark.parametrize("half_angle_deg", [1.0, 10.0])
def test_coning_is_followed(half_angle_deg):
    """What is left is (rate dt)^4 / 20 of the drift that the motion makes, against (rate dt)^2 / 6 by plain summing."""
    n, dt = 1000, 1e-3
    drift = 2 * np.sin(np.radians(half_angle_deg) / 2) ** 2 * 2 * np.pi * 10 * n * dt
    corrected, plain = coning_errors(half_angle_deg, n, dt)
    phase = 2 * np.pi * 10 * dt
    assert corrected == pytest.approx(drift * phase**4 / 20, rel=0.05)
    assert plain == pytest.approx(drift * phase**2 / 6, rel=0.05)


def test_halving_the_sample_interval_cuts_the_coning_error_by_sixteen():
    assert coning_errors(10.0, 500, 1e-3)[0] / coning_errors(10.0, 1000, 5e-4)[0] == pytest.approx(16, rel=0.05)


def test_constant_rate_and_force():
    """v = int Exp(w t) f dt has a closed form; the correction for turning is good to its fourth order."""
    w, f, dt, n = np.array([0.3, -1.2, 2.0]), np.array([1.0, -9.0, 3.0]), 1e-2, 50
    found = preintegrate(ImuSamples(np.tile(w * dt, (n, 1)), np.tile(f * dt, (n, 1)), dt), n)
    a, T = np.linalg.norm(w), n * dt
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]) / a
    integral = T * np.eye(3) + (1 - np.cos(a * T)) / a * K + (T - np.sin(a * T) / a) * K @ K
    assert far(found.rotation[0], quat_from_rotvec(w * T)) < 1e-14
    np.testing.assert_allclose(found.velocity[0], integral @ f, atol=T * np.linalg.norm(f) * (a * dt) ** 3 / 24)
    np.testing.assert_allclose(found.J[0], integral, atol=T * (a * dt) ** 2 / 12)


def test_sculling():
    """Turning and force that swing together leave a velocity; against dense quadrature."""
    turn, rate, force, dt, n = 0.02, 2 * np.pi * 15, 20.0, 1e-3, 2000
    fine = 40
    t = (np.arange(n * fine) + 0.5) * dt / fine
    phi = turn * np.sin(rate * t)
    along = force * np.sin(rate * t)
    true = np.array([np.mean(np.cos(phi) * along), np.mean(np.sin(phi) * along)]) * n * dt
    edges = np.arange(n + 1) * dt
    angle, velocity = np.zeros((n, 3)), np.zeros((n, 3))
    angle[:, 2] = turn * np.diff(np.sin(rate * edges))
    velocity[:, 0] = -force / rate * np.diff(np.cos(rate * edges))
    found = preintegrate(ImuSamples(angle, velocity, dt), n).velocity[0]
    assert true[1] > 0.3  # m/s in 2 s
    np.testing.assert_allclose(found[:2], true, atol=2e-6)


@pytest.fixture(scope="module")
def lively():
    rng = np.random.default_rng(3)
    t = (np.arange(400) + 0.5)[:, None] * 2e-3
    rate = np.sin(2 * np.pi * rng.uniform(1, 6, 3) * t + rng.uniform(0, 6, 3)) * [3.0, 2.0, 2.5]
    force = [1.0, -2.0, -9.8] + 3 * np.sin(2 * np.pi * rng.uniform(1, 6, 3) * t)
    return ImuSamples(rate * 2e-3, force * 2e-3, 2e-3)


def shifted(samples, gyro_bias, accel_bias):
    return ImuSamples(samples.angle + gyro_bias * samples.dt, samples.velocity + accel_bias * samples.dt, samples.dt)


def test_bias_jacobians_are_the_derivatives(lively):
    h = 1e-6
    base = preintegrate(lively, 100)
    for axis, e in enumerate(np.eye(3)):
        up, down = (preintegrate(shifted(lively, s * h * e, 0 * e), 100) for s in (1, -1))
        by_gyro = rotation_error(up.rotation, down.rotation) / (2 * h)
        np.testing.assert_allclose(by_gyro, base.J[:, :, axis], atol=1e-5 * base.dt)
        np.testing.assert_allclose((up.velocity - down.velocity) / (2 * h), base.H[:, :, axis], atol=2e-5)
        up, down = (preintegrate(shifted(lively, 0 * e, s * h * e), 100) for s in (1, -1))
        np.testing.assert_allclose((up.velocity - down.velocity) / (2 * h), base.J[:, :, axis], atol=1e-5 * base.dt)


def test_biases_come_off_to_first_order(lively):
    gyro_bias, accel_bias = np.array([8e-4, -8e-4, 8e-4]), np.array([2e-3, 2e-3, -2e-3])
    true, base = preintegrate(lively, 50), preintegrate(shifted(lively, gyro_bias, accel_bias), 50)
    rotation, velocity = base.corrected(gyro_bias, accel_bias)
    turned = np.linalg.norm(rotation_error(base.rotation, true.rotation), axis=1)
    moved = np.linalg.norm(base.velocity - true.velocity, axis=1)
    assert (np.linalg.norm(rotation_error(rotation, true.rotation), axis=1) < 1e-4 * turned).all()
    assert (np.linalg.norm(velocity - true.velocity, axis=1) < 1e-4 * moved).all()
    one_a_row = base.corrected(np.tile(gyro_bias, (len(base), 1)), np.tile(accel_bias, (len(base), 1)))
    np.testing.assert_array_equal(one_a_row[0], rotation)
    np.testing.assert_array_equal(one_a_row[1], velocity)


def test_a_recording_in_parts_gives_the_same_increments(lively):
    whole = preintegrate(lively, 20)
    first = ImuSamples(lively.angle[:160], lively.velocity[:160], lively.dt)
    rest = ImuSamples(lively.angle[160:], lively.velocity[160:], lively.dt)
    history = np.hstack([first.angle[-2:], first.velocity[-2:]])
    parts = [preintegrate(first, 20).rows, preintegrate(rest, 20, history).rows]
    np.testing.assert_array_equal(np.concatenate(parts), whole.rows)


def test_intervals_chain(lively):
    """Ten short intervals are one long one."""
    short, long = preintegrate(lively, 40), preintegrate(lively, 400)
    q, v, J, H = np.array([1.0, 0, 0, 0]), np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3))
    for k in range(len(short)):
        C, step = matrix_from_quat(q), matrix_from_quat(q) @ short.velocity[k]
        H += C @ short.H[k] - np.cross(step, J.T).T
        J += C @ short.J[k]
        v += step
        q = quat_multiply(q, short.rotation[k])
    np.testing.assert_allclose(np.concatenate([q, v, J.ravel(), H.ravel()]), long.rows[0], atol=1e-13)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_past_continues_a_line_or_a_parabola(n):
    k = np.arange(n)[:, None] + np.zeros(3)
    poly = [lambda k: 5 + 0 * k, lambda k: 5 + 2 * k, lambda k: 5 + 2 * k - 3 * k * k][n - 1]
    np.testing.assert_allclose(
        ImuSamples(poly(k), -poly(k), 0.1).history(), [[s * poly(b) for s in (1, 1, 1, -1, -1, -1)] for b in (-2, -1)]
    )


@pytest.mark.parametrize(
    ("angle", "velocity", "dt", "match"),
    [
        (np.zeros((4, 2)), np.zeros((4, 2)), 0.1, "angle"),
        (np.zeros((0, 3)), np.zeros((0, 3)), 0.1, "angle"),
        (np.zeros((4, 3)), np.zeros((5, 3)), 0.1, "velocity"),
        (np.full((4, 3), np.nan), np.zeros((4, 3)), 0.1, "row 0"),
        (np.zeros((4, 3)), np.r_[np.zeros((3, 3)), [[0, np.inf, 0]]], 0.1, "row 3"),
        (np.zeros((4, 3)), np.zeros((4, 3)), 0.0, "dt"),
        (np.zeros((4, 3)), np.zeros((4, 3)), np.nan, "dt"),
    ],
)
def test_samples_that_cannot_be_integrated_are_refused(angle, velocity, dt, match):
    with pytest.raises(InputError, match=match):
        ImuSamples(angle, velocity, dt)


def test_intervals_and_history_are_checked(lively):
    for every in (0, -1, 7, 401):
        with pytest.raises(InputError, match="samples an interval"):
            preintegrate(lively, every)
    for history in (np.zeros(6), np.full((2, 6), np.nan)):
        with pytest.raises(InputError, match="before the first"):
            preintegrate(lively, 10, history)
    with pytest.raises(InputError, match="increments"):
        Increments(np.zeros((3, 24)), 0.1)
    with pytest.raises(InputError, match="row 1"):
        Increments(np.r_[np.zeros((1, 25)), np.full((1, 25), np.nan)], 0.1)
