"""Paths: derivatives by finite differences, joints, attitude from thrust, an IMU that leads back to the path."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.datasheet.presets import imu
from robustnav.errors import InputError
from robustnav.frames import euler_from_quat, matrix_from_quat, quat_from_rotvec, quat_multiply, rotate
from robustnav.sim import attitude_cases, quadcopter, rig
from robustnav.sim.batch import Sensors, simulate
from robustnav.sim.ranging_path import FigureEight, Leg, Path, Rest, SampledPath
from robustnav.sim.sensor_errors import NO_ERRORS

PATHS = [quadcopter.flight(), rig.approach(), rig.standing((1.0, 2.0, -3.0), 5.0)]
HOVER = Path((0.0, 0.0, -1.0), 0.4, (Rest(2.0),), 9.8, tilts=True)


def joints(path):
    return np.cumsum([segment.duration for segment in path.segments])


@pytest.mark.parametrize("path", PATHS, ids=("quadcopter", "vehicle", "standing"))
def test_velocity_and_acceleration_are_the_derivatives_of_position(path):
    t = np.sort(np.concatenate([np.linspace(-1.0, path.duration + 1.0, 500), joints(path)]))
    h = 1e-4
    before, now, after = path.at(t - h), path.at(t), path.at(t + h)
    np.testing.assert_allclose((after.p_n - before.p_n) / (2 * h), now.v_n, atol=2e-7)
    np.testing.assert_allclose((after.v_n - before.v_n) / (2 * h), now.a_n, atol=2e-6)


def test_the_body_rate_is_the_derivative_of_the_attitude():
    path, h = quadcopter.flight(), 1e-5
    t = np.linspace(0.01, path.duration - 0.01, 700)
    C, C_after, C_before = (matrix_from_quat(path.at(x).q_nb) for x in (t, t + h, t - h))
    rate = np.einsum("nji,njk->nik", C, (C_after - C_before) / (2 * h))  # C' C_dot = [omega]x
    np.testing.assert_allclose(
        np.stack([rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=1), path.at(t).omega_b, atol=1e-6
    )


def test_joints_are_smooth_up_to_the_body_rate():
    path, h = quadcopter.flight(), 1e-7
    before, after = path.at(joints(path) - h), path.at(joints(path) + h)
    for name in ("p_n", "v_n", "a_n", "omega_b"):
        np.testing.assert_allclose(getattr(before, name), getattr(after, name), atol=1e-5, err_msg=name)
    assert np.abs(np.sum(before.q_nb * after.q_nb, axis=1)).min() > 1 - 1e-12


def test_a_multicopter_feels_thrust_along_its_up_axis_only_and_keeps_its_heading():
    path = quadcopter.flight()
    states = path.at(np.linspace(0, path.duration, 3000))
    assert np.abs(states.f_b[:, :2]).max() < 1e-12 and states.f_b[:, 2].max() < -1.0
    np.testing.assert_allclose(rotate(states.q_nb, states.f_b), states.a_n - [0, 0, path.gravity], atol=1e-12)
    turn = euler_from_quat(states.q_nb)[:, 2] - path._moves(states.t)[1]
    np.testing.assert_allclose((turn + np.pi) % (2 * np.pi), np.pi, atol=1e-12)


@pytest.mark.parametrize("path", PATHS, ids=("quadcopter", "vehicle", "standing"))
def test_before_and_after_its_segments_a_carrier_rests_where_they_begin_and_end(path):
    ends = path.at(np.array([-5.0, 0.0, path.duration, path.duration + 5.0]))
    np.testing.assert_allclose(ends.p_n[:2], np.tile(path.start, (2, 1)), atol=1e-12)
    np.testing.assert_allclose(ends.p_n[3], ends.p_n[2], atol=1e-12)
    assert np.abs(ends.v_n).max() < 1e-12 and np.abs(ends.omega_b).max() < 1e-12
    headings = euler_from_quat(ends.q_nb)[:, 2]
    turned = path.heading + sum(segment.turn for segment in path.segments)
    np.testing.assert_allclose(
        np.exp(1j * headings), np.exp(1j * np.array([path.heading] * 2 + [turned] * 2)), atol=1e-9
    )


def test_hover_is_level_and_a_carrier_that_does_not_tilt_stays_level():
    hover = HOVER.at(np.array([1.0]))
    np.testing.assert_allclose(euler_from_quat(hover.q_nb), [[0, 0, 0.4]], atol=1e-15)
    np.testing.assert_allclose(hover.f_b, [[0, 0, -9.8]], atol=1e-12)
    drive = rig.approach().at(np.linspace(0, 180, 900))
    assert np.abs(euler_from_quat(drive.q_nb)[:, :2]).max() < 1e-12
    assert np.abs(drive.f_b[:, :2]).max() == pytest.approx(np.abs(drive.a_n[:, :2]).max(), rel=0.3)


def test_dead_reckoning_with_an_ideal_imu_returns_to_the_path():
    sampled = SampledPath(quadcopter.flight(), 400.0)
    place, ideal = attitude_cases.environment(), Sensors(imu("mpu9250"), None, NO_ERRORS)
    batch = simulate(sampled, ideal, place, runs=1, seed=0)
    states = sampled.states()
    np.testing.assert_allclose(batch.accel[0], states.f_b, atol=1e-12)
    dt, q, rotations = 1 / 400.0, states.q_nb[0], []
    for rate in batch.gyro[0, 1:]:
        q = quat_multiply(q, quat_from_rotvec(rate * dt))
        rotations.append(q)
    a_n = rotate(np.array([states.q_nb[0], *rotations]), batch.accel[0]) + np.array([0, 0, place.gravity])
    v_n = np.cumsum((a_n[1:] + a_n[:-1]) * dt / 2, axis=0)
    p_n = np.cumsum((v_n + np.concatenate([np.zeros((1, 3)), v_n[:-1]])) * dt / 2, axis=0)
    np.testing.assert_allclose(v_n, states.v_n[1:], atol=1e-4)
    np.testing.assert_allclose(p_n, states.p_n[1:], atol=2e-3)


def test_figures_of_eight_end_where_they_began_and_keep_their_extent():
    eight = FigureEight(3.0, 1.0, 0.5, 2, 20.0)
    p = eight.curve(np.array([1.0, 2.0, -4.0]), np.linspace(0, 1, 2001))[0]
    np.testing.assert_allclose(p[[0, 1000, -1]], np.tile([1.0, 2.0, -4.0], (3, 1)), atol=1e-12)
    np.testing.assert_allclose(np.ptp(p, axis=0), [6.0, 2.0, 1.0], rtol=1e-5)
    assert p[:, 2].min() == pytest.approx(-5.0)


def test_truth_carries_position_velocity_and_attitude():
    states = quadcopter.flight().at(np.array([0.0, 20.0]))
    truth = states.truth("true")
    assert (truth.kind, truth.north) == ("simulated", "true")
    for name in ("p_n", "v_n", "q_nb"):
        np.testing.assert_array_equal(getattr(truth, name), getattr(states, name))


def test_free_fall_has_no_attitude():
    drop = replace(HOVER, segments=(Leg((0.0, 0.0, 9.0), 2.0),), tilts=False)
    t = np.array([0.5])
    falling = float(drop.at(t).a_n[0, 2])
    with pytest.raises(InputError, match="free fall"):
        replace(drop, gravity=falling, tilts=True).at(t)
    assert replace(drop, gravity=falling + 0.1, tilts=True).at(t).f_b[0, 2] == pytest.approx(-0.1)


ZERO = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Leg((0.0, np.nan, 0.0), 1.0), "leg, to"),
        (lambda: FigureEight(1.0, np.inf, 0.0, 1, 1.0), "extents"),
        (lambda: FigureEight(1.0, 1.0, 0.0, 0, 1.0), "laps"),
        (lambda: FigureEight(1.0, 1.0, 0.0, 1.5, 1.0), "laps"),
        (lambda: Path((0.0, 0.0), 0.0, (Rest(1.0),), 9.8, True), "start"),
        (lambda: Path(ZERO, 0.0, (), 9.8, True), "no segment"),
        (lambda: Path(ZERO, 0.0, (Rest(1.0), Rest(0.0)), 9.8, True), "segment 1"),
        (lambda: Path(ZERO, 0.0, (Rest(1.0, np.nan),), 9.8, True), "segment 0"),
        (lambda: Path(ZERO, np.nan, (Rest(1.0),), 9.8, True), "heading"),
        (lambda: Path(ZERO, 0.0, (Rest(1.0),), 0.0, True), "gravity"),
        (lambda: SampledPath(HOVER, 0.0), "rate"),
        (lambda: rig.layout("barn"), "hall"),
    ],
)
def test_bad_input(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_layouts_are_what_they_say():
    spread = {
        name: np.linalg.svd(make().p_a - make().p_a.mean(0), compute_uv=False) for name, make in rig.LAYOUTS.items()
    }
    assert {name: len(rig.layout(name).ids) for name in rig.LAYOUTS} == {
        "hall": 8,
        "yard": 6,
        "vehicle_rig": 4,
        "ceiling": 4,
    }
    assert spread["ceiling"][2] < 1e-12 and all(s[2] > 1 for name, s in spread.items() if name != "ceiling")
    flown = quadcopter.flight().at(np.linspace(0, 77, 500)).p_n
    hall = rig.hall().p_a
    assert (np.abs(flown[:, :2]) < hall[:, :2].max(0)).all() and (flown[:, 2] > hall[:, 2].min()).all()
