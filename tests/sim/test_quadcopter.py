"""The published quadcopter setting: plausible flight, one log with everything, assumptions that are true."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.datasheet.presets import imu
from robustnav.frames import euler_from_quat
from robustnav.sim import attitude_cases, quadcopter
from robustnav.sim.batch import Sensors, simulate
from robustnav.sim.quadcopter import Carried, simulate_flights
from robustnav.sim.ranging import simulate_ranging
from robustnav.sim.ranging_path import SampledPath
from robustnav.sim.sensor_errors import ALL_ERRORS

PLACE = attitude_cases.environment()
CARRIED = Carried(Sensors(imu("mpu9250"), None, ALL_ERRORS), 50.0, PLACE)


def test_the_flight_stays_within_what_its_description_says():
    path = quadcopter.flight()
    states = path.at(np.linspace(0, path.duration, 20000))
    assert 60 <= path.duration <= 90
    speed, acceleration = np.linalg.norm(states.v_n, axis=1), np.linalg.norm(states.a_n, axis=1)
    assert 5.1 < speed.max() < 5.3 and 7.5 < acceleration.max() < 8.0
    assert 30 < np.degrees(np.abs(euler_from_quat(states.q_nb)[:, :2]).max()) < 37
    np.testing.assert_allclose(states.p_n[[0, -1]], 0.0, atol=1e-9)
    assert sum(segment.turn for segment in path.segments) == pytest.approx(2 * np.pi)


def test_a_log_holds_imu_ranges_and_a_truth_that_agree():
    one = quadcopter.ranges_setup(quadcopter.measured_errors())
    flights = simulate_flights(quadcopter.flight(), one, CARRIED, runs=range(3, 5), seed=9)
    log = flights.log(4)
    assert set(log.streams) == {"gyro", "accel", "range"}
    np.testing.assert_array_equal(log.truth.p_n, quadcopter.flight().at(log.truth.t).p_n)
    assert log.truth.north == "magnetic" and len(log.truth.t) == len(log.streams["gyro"])
    ranges = log.streams["range"].values
    p = np.stack([np.interp(log.streams["range"].t, log.truth.t, x) for x in log.truth.p_n.T], axis=1)
    error = ranges[:, 0] - np.linalg.norm(p - ranges[:, 1:], axis=1)
    assert np.median(np.abs(error)) < 0.15 and 0.001 < np.mean(np.abs(error) > 0.8) < 0.05
    alone = simulate_ranging(quadcopter.flight().at(one.events.t), one, runs=5, seed=9)
    np.testing.assert_array_equal(alone.stream(4).values, ranges)
    sampled = SampledPath(quadcopter.flight(), 50.0)
    np.testing.assert_array_equal(
        simulate(sampled, CARRIED.sensors, PLACE, runs=5, seed=9).accel[4], log.streams["accel"].values
    )


def test_differences_of_the_flight():
    one = quadcopter.differences_setup(replace(quadcopter.measured_errors(), outliers=None))
    flights = simulate_flights(quadcopter.flight(), one, CARRIED, runs=1, seed=0)
    values = flights.log(0).streams["tdoa"].values
    apart = np.linalg.norm(values[:, 4:] - values[:, 1:4], axis=1)
    assert values.shape[1] == 7 and np.mean(np.abs(values[:, 0]) < apart + 0.5) > 0.95


def test_published_ranges_follow_their_line(in_band):
    one = quadcopter.ranges_setup(quadcopter.published_errors())
    track = quadcopter.flight().at(one.events.t)
    seen = simulate_ranging(track, one, runs=3, seed=1)
    true = np.linalg.norm(track.p_n - one.anchors.p_a[one.events.second], axis=1)
    in_band(seen.values - (1.0045 * true + 0.075), 0.05**2)


def test_assumptions_are_the_figures_in_use():
    stated = {one.name: one.value for one in quadcopter.assumptions()}
    published, measured = quadcopter.published_errors(), quadcopter.measured_errors()
    assert (published.line.slope, published.line.offset) == (stated["line_slope"], stated["line_offset_m"])
    assert published.white_sd == stated["white_sd_m"]
    assert (measured.colour.sd, measured.colour.tau) == (stated["colour_sd_m"], stated["colour_tau_s"])
    assert (measured.nlos.share, measured.outliers.share) == (stated["nlos_share"], stated["outlier_share"])
    one = quadcopter.ranges_setup(published)
    assert (len(one.anchors.ids), one.schedule.rounds_hz) == (stated["anchors"], stated["rounds_hz"])
    assert quadcopter.flight().duration == stated["flight_s"] and quadcopter.flight().gravity == stated["gravity_m_s2"]
    assert all(one.why for one in quadcopter.assumptions())
