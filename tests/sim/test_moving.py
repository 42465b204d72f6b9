"""Carriers that move: readings lead back along the way, the receiver errs as told, the car drives where it looks."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.datasheet.sensors import Imu, SensorSpec
from robustnav.earth import earth_rate_n, normal_gravity
from robustnav.errors import InputError
from robustnav.frames import euler_from_quat, quat_from_rotvec, quat_multiply, rotate, rotation_error
from robustnav.sim.moving import MovingKit, Receiver, simulate_moving, true_increments
from robustnav.sim.moving_ways import WAYS, way
from robustnav.sim.sensor_errors import NO_ERRORS, ErrorSwitches
from robustnav.units import DEG

UNIT = Imu("made", SensorSpec(density=1e-3, turn_on_bias_sd=0.01), SensorSpec(density=0.01, turn_on_bias_sd=0.1))
LATITUDE = 47 * DEG


@pytest.mark.parametrize("name", WAYS)
def test_increments_lead_back_along_the_way(name):
    states = way(name, 3, 30.0, 100.0)
    gyro, accel = true_increments(states, LATITUDE)
    rate_n, gravity_n = earth_rate_n(LATITUDE), np.array([0, 0, normal_gravity(LATITUDE)])
    q, v, p, dt = states.q_nb[0], states.v_n[0], states.p_n[0], 0.01
    for k in range(1, len(states.t)):  # Heun, its own derivation: attitude in inertial steps, velocity by the middle
        middle = quat_multiply(quat_from_rotvec(-rate_n * dt / 2), quat_multiply(q, quat_from_rotvec(gyro[k] * dt / 2)))
        force = rotate(middle, accel[k]) + gravity_n
        rise = force - 2 * np.cross(rate_n, v + force * dt / 2)
        q = quat_multiply(quat_from_rotvec(-rate_n * dt), quat_multiply(q, quat_from_rotvec(gyro[k] * dt)))
        p, v = p + (v + rise * dt / 2) * dt, v + rise * dt
    assert np.linalg.norm(rotation_error(states.q_nb[-1], q)) < 1e-6
    np.testing.assert_allclose(v, states.v_n[-1], atol=1e-4)
    np.testing.assert_allclose(p, states.p_n[-1], atol=0.05)


@pytest.mark.parametrize("name", WAYS)
def test_velocity_and_acceleration_are_rates_of_the_way(name):
    states = way(name, 5, 20.0, 200.0)
    for one, rate in ((states.p_n, states.v_n), (states.v_n, states.a_n)):
        np.testing.assert_allclose((one[2:] - one[:-2]) * 100.0, rate[1:-1], atol=0.02)
    assert np.linalg.norm(states.v_n[0]) > 0.3  # on its way already
    tilt = np.arccos(1 - 2 * (states.q_nb[:, 1] ** 2 + states.q_nb[:, 2] ** 2))
    assert tilt.max() > {"drone": 10 * DEG, "car": 2 * DEG}[name]


def test_a_car_drives_where_it_looks_and_leans_outward():
    states = way("car", 1, 60.0, 100.0)
    euler = euler_from_quat(states.q_nb)
    course = np.arctan2(states.v_n[:, 1], states.v_n[:, 0])
    assert np.abs(np.angle(np.exp(1j * (course - euler[:, 2])))).max() < 1e-9
    aside = np.cross(states.v_n, states.a_n)[:, 2]  # positive to the right
    strong = np.abs(aside) > 5.0
    assert strong.any() and (np.sign(euler[strong, 0]) == -np.sign(aside[strong])).all()
    assert np.linalg.norm(states.v_n, axis=1).min() > 3.9


def test_the_receiver_errs_as_told():
    states = way("drone", 2, 60.0, 100.0)
    arm = (0.3, -0.2, 0.5)
    receiver = Receiver(10.0, 0.2, 3.0, lever_b=arm, delay=0.3, outages=((20.0, 25.0),), outlier_share=0.2)
    kit = MovingKit(UNIT, NO_ERRORS, receiver, compass_sd=0.3)
    log = simulate_moving(states, kit, latitude=LATITUDE, seed=4)
    for name, true, sd in (("velocity", states.v_n, 0.2), ("position", states.p_n, 3.0)):
        one = log.streams[f"gnss_{name}"]
        at = one.t - 0.3
        assert not ((at > 20.0) & (at < 25.0)).any() and len(one) == 550
        k = np.searchsorted(states.t, at - 1e-6)
        arms = np.cross(states.omega_b[k], arm) if name == "velocity" else np.tile(arm, (len(k), 1))
        off = one.values - true[k] - rotate(states.q_nb[k], arms)
        far = np.linalg.norm(off, axis=1) > 6 * sd
        assert 0.12 < far.mean() < 0.28
        assert 0.85 * sd < off[~far].std() < 1.15 * sd and np.abs(off[~far].mean(axis=0)).max() < 4 * sd / 20
    heading = log.streams["heading"].values[:, 0] - euler_from_quat(states.q_nb)[::10, 2]
    assert (
        np.ptp(np.angle(np.exp(1j * (heading - heading[0])))) < 1e-9 and abs(np.angle(np.exp(1j * heading[0]))) > 1e-3
    )
    assert log.truth.north == "true" and log.info["latitude_deg"] == pytest.approx(47)


def test_runs_differ_by_seed_alone():
    states, kit = way("car", 2, 5.0, 100.0), MovingKit(UNIT, ErrorSwitches(white_noise=True), Receiver())
    one, same, other = (simulate_moving(states, kit, latitude=LATITUDE, seed=s) for s in (4, 4, 5))
    for name, stream in one.streams.items():
        np.testing.assert_array_equal(stream.values, same.streams[name].values)
        assert np.abs(stream.values - other.streams[name].values).max() > 0
    gyro, _ = true_increments(states, LATITUDE)
    assert (one.streams["gyro"].values - gyro).std() == pytest.approx(UNIT.gyro.sample_sd(100.0), rel=0.1)


def test_what_cannot_be_is_refused():
    for bad in ({"rate_hz": 0.0}, {"velocity_sd": -1.0}, {"outlier_share": 1.0}, {"delay": float("nan")}):
        with pytest.raises(InputError, match="receiver"):
            replace(Receiver(), **bad)
    with pytest.raises(InputError, match="drone, car"):
        way("ship", 0, 10.0, 100.0)
    for make in WAYS.values():
        with pytest.raises(InputError, match="trajectory"):
            make(0, 0.001, 100.0)
