"""Whole simulations: physics of the ideal sensors, records, the study's setting."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from robustnav.datasheet.presets import imu, magnetometer
from robustnav.errors import InputError
from robustnav.frames import matrix_from_quat, quat_from_euler, rotation_error, triad
from robustnav.sim import attitude_cases
from robustnav.sim.batch import Environment, Sensors, simulate
from robustnav.sim.sensor_errors import ALL_ERRORS, NO_ERRORS, STUDY_ERRORS
from robustnav.sim.trajectory import Motion, case_one, case_two, motion_from_attitude

DEG = np.pi / 180
PLACE = attitude_cases.environment()
IDEAL = Sensors(imu("mpu9250"), magnetometer("ak8963"), NO_ERRORS)


@dataclass(frozen=True)
class Fixed:
    """A given motion as a trajectory."""

    motion: Motion

    def sample(self):
        return self.motion


def at_rest(euler, n=3):
    return Fixed(motion_from_attitude(np.arange(n) / 100.0, np.tile(quat_from_euler(euler), (n, 1))))


def test_at_rest_and_level_the_accelerometer_reads_minus_g_down():
    batch = simulate(at_rest([0, 0, 0.7]), IDEAL, PLACE, runs=1, seed=0)
    np.testing.assert_allclose(batch.accel[0], np.tile([0, 0, -9.80665], (3, 1)), atol=1e-12)
    assert not batch.gyro.any() and not batch.gyro_bias.any()


def test_signs_of_tilt_and_heading():
    nose_up = simulate(at_rest([0, 30 * DEG, 0]), IDEAL, PLACE, runs=1, seed=0)
    assert nose_up.accel[0, 0, 0] == pytest.approx(9.80665 * 0.5)  # pushed forward by the support
    right_down = simulate(at_rest([30 * DEG, 0, 0]), IDEAL, PLACE, runs=1, seed=0)
    assert right_down.accel[0, 0, 1] == pytest.approx(-9.80665 * 0.5)
    east = simulate(at_rest([0, 0, 90 * DEG]), IDEAL, PLACE, runs=1, seed=0)
    np.testing.assert_allclose(east.mag[0, 0], [0, -24e-6, 48e-6 * np.sin(60 * DEG)], atol=1e-12)  # north is left


def test_specific_force_is_acceleration_less_gravity_in_body_axes():
    motion = case_two().sample()
    acceleration_n = np.stack([np.sin(motion.t), np.cos(motion.t), 0.5 * motion.t], axis=1)
    batch = simulate(Fixed(replace(motion, acceleration_n=acceleration_n)), IDEAL, PLACE, runs=1, seed=0)
    back_n = np.einsum("nij,nj->ni", matrix_from_quat(motion.q_nb), batch.accel[0])
    np.testing.assert_allclose(back_n, acceleration_n - [0, 0, 9.80665], atol=1e-12)
    falling = Fixed(replace(motion, acceleration_n=np.tile([0, 0, 9.80665], (len(motion.t), 1))))
    np.testing.assert_allclose(simulate(falling, IDEAL, PLACE, runs=1, seed=0).accel, 0.0, atol=1e-12)


def test_ideal_sensors_give_back_the_attitude():
    batch = simulate(case_two(), IDEAL, PLACE, runs=1, seed=0)
    np.testing.assert_allclose(np.linalg.norm(batch.accel[0], axis=1), 9.80665, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(batch.mag[0], axis=1), 48e-6, rtol=1e-12)
    error = rotation_error(triad(batch.accel[0], batch.mag[0]), batch.q_nb)
    assert np.abs(error).max() < 1e-12
    np.testing.assert_array_equal(batch.gyro[0], case_two().sample().omega_b)


def test_study_noise_is_the_assumed_one():
    batch = simulate(case_two(), attitude_cases.sensors(), PLACE, runs=30, seed=5)
    ideal = simulate(case_two(), IDEAL, PLACE, runs=1, seed=5)
    gyro = batch.gyro - batch.gyro_bias - ideal.gyro
    for noise, sd in (
        (gyro, 0.01 * DEG * np.sqrt(50)),
        (batch.accel - ideal.accel, 300e-6 * 9.80665 * np.sqrt(50)),
        (batch.mag - ideal.mag, 0.5e-6),
        (batch.gyro_bias[:, -1], 1e-4 * DEG * np.sqrt(10.0)),
    ):
        assert noise.std() == pytest.approx(sd, rel=4 / np.sqrt(2 * noise.size))
    assert not batch.gyro_bias[:, 0].any()
    assert batch.conventions[0].endswith("errors: white_noise, random_walk")
    assert batch.conventions[2].endswith("errors: white_noise")


def test_assumptions_state_what_is_used():
    value = {row.name: row.value for row in attitude_cases.assumptions()}
    assert len(value) == len(attitude_cases.assumptions())
    assert all(row.why for row in attitude_cases.assumptions())
    used = attitude_cases.sensors()
    assert used.imu.gyro.density == pytest.approx(value["gyro_density_dps_rthz"] * DEG)
    assert used.imu.gyro.random_walk == pytest.approx(value["bias_walk_dps_rts"] * DEG)
    assert used.imu.accel.density == pytest.approx(value["accel_density_ug_rthz"] * 1e-6 * 9.80665)
    assert used.magnetometer.field.noise_rms_sd == pytest.approx(value["mag_sd_ut"] * 1e-6)
    assert (value["field_ut"], value["dip_deg"], value["gravity_m_s2"]) == (48.0, 60.0, PLACE.gravity)
    for case, trajectory in (("one", case_one()), ("two", case_two())):
        for k, axis in enumerate(("roll", "pitch", "yaw")):
            assert trajectory.amplitude[k] == pytest.approx(value[f"case_{case}_{axis}_amplitude_deg"] * DEG)
        assert trajectory.rate_hz == value["rate_hz"] and set(trajectory.phase) == {value["phase_deg"]}
    assert np.degrees(np.arctan2(PLACE.field_n[2], PLACE.field_n[0])) == pytest.approx(60.0)
    assert np.linalg.norm(PLACE.field_n) == pytest.approx(48e-6)


def test_slow_magnetometer_has_its_own_times():
    sensors = replace(attitude_cases.sensors(), magnetometer_rate_hz=8.0 + 1 / 3)
    batch = simulate(case_two(), sensors, PLACE, runs=2, seed=1)
    np.testing.assert_allclose(batch.t_mag, np.arange(84) * 0.12)
    ideal = simulate(case_two(), replace(sensors, errors=NO_ERRORS), PLACE, runs=1, seed=1)
    full = simulate(case_two(), IDEAL, PLACE, runs=1, seed=1)
    np.testing.assert_array_equal(ideal.mag, full.mag[:, ::12])
    assert np.isfinite(batch.mag).all()


def test_magnetometer_density_counts_at_its_own_rate():
    compass = replace(IDEAL.magnetometer, field=replace(IDEAL.magnetometer.field, noise_rms_sd=None, density=1e-7))
    sensors = Sensors(IDEAL.imu, compass, STUDY_ERRORS, magnetometer_rate_hz=10.0)
    batch = simulate(case_two(), sensors, PLACE, runs=20, seed=1)
    ideal = simulate(case_two(), replace(sensors, errors=NO_ERRORS), PLACE, runs=1, seed=1)
    assert (batch.mag - ideal.mag).std() == pytest.approx(1e-7 * np.sqrt(5.0), rel=4 / np.sqrt(2 * batch.mag.size))


def test_log_of_a_run():
    batch = simulate(case_two(), attitude_cases.sensors(), PLACE, runs=range(4, 7), seed=1)
    log = batch.log(5)
    np.testing.assert_array_equal(log.stream("gyro").values, batch.gyro[1])
    np.testing.assert_array_equal(log.stream("accel").values, batch.accel[1])
    np.testing.assert_array_equal(log.stream("mag").values, batch.mag[1])
    assert [log.streams[name].unit for name in ("gyro", "accel", "mag")] == ["rad/s", "m/s^2", "T"]
    np.testing.assert_array_equal(log.truth.q_nb, batch.q_nb)
    assert (log.truth.kind, log.truth.north) == ("simulated", "magnetic")
    assert len(log.conventions) == 3
    for run in (3, 7, -1):
        with pytest.raises(InputError, match="4 to 6"):
            batch.log(run)


def test_without_a_magnetometer():
    batch = simulate(case_two(), replace(IDEAL, magnetometer=None), PLACE, runs=2, seed=1)
    assert batch.mag.shape == (2, 0, 3)
    assert set(batch.log(0).streams) == {"gyro", "accel"}


@pytest.mark.parametrize("name", ["mpu9250", "bmi088", "icm42688p", "adis16470"])
def test_every_preset_simulates_with_every_error(name):
    sensors = Sensors(imu(name), magnetometer("bmm150"), ALL_ERRORS, magnetometer_rate_hz=25.0)
    batch = simulate(case_two(), sensors, PLACE, runs=3, seed=2)
    again = simulate(case_two(), sensors, PLACE, runs=2, seed=2)
    np.testing.assert_array_equal(batch.gyro[:2], again.gyro)
    np.testing.assert_array_equal(batch.accel[:2], again.accel)
    np.testing.assert_array_equal(batch.mag[:2], again.mag)
    for readings, spec in ((batch.gyro, sensors.imu.gyro), (batch.accel, sensors.imu.accel)):
        bits = readings / spec.resolution
        np.testing.assert_allclose(bits, np.rint(bits), atol=1e-6)
        assert np.abs(readings).max() <= spec.range_max
    assert np.abs(batch.gyro_bias).max() > 0


@pytest.mark.parametrize(
    "change",
    [
        {"runs": 0},
        {"runs": range(-1, 2)},
        {"seed": -1},
        {"sensors": replace(IDEAL, magnetometer_rate_hz=30.0)},
        {"sensors": replace(IDEAL, magnetometer_rate_hz=200.0)},
        {"sensors": replace(IDEAL, magnetometer_rate_hz=0.0)},
        {"sensors": replace(IDEAL, magnetometer_rate_hz=float("nan"))},
    ],
)
def test_bad_simulation(change):
    settings = {"trajectory": case_two(), "sensors": IDEAL, "environment": PLACE, "runs": 1, "seed": 0} | change
    with pytest.raises(InputError):
        simulate(**settings)


@pytest.mark.parametrize(
    "values",
    [
        (0.0, (1e-5, 0.0, 0.0)),
        (float("nan"), (1e-5, 0.0, 0.0)),
        (9.8, (0.0, 0.0, 0.0)),
        (9.8, (1e-5, 0.0)),
        (9.8, (1e-5, 0.0, float("inf"))),
        (9.8, (1e-5, 1e-6, 0.0)),
        (9.8, (1e-5, 0.0, 0.0), "grid"),
    ],
)
def test_bad_environment(values):
    with pytest.raises(InputError):
        Environment(*values)
    assert Environment(9.8, (1e-5, 1e-6, 0.0), "true").north == "true"
