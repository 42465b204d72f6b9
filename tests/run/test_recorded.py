"""Attitude estimators on recordings: the start, true north, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.evaluate import evaluate
from robustnav.frames import quat_from_euler, rotation_error
from robustnav.records import Log, Stream
from robustnav.run.recorded import ESTIMATORS, Sensors, estimator_for, first_readings, run_recorded
from robustnav.sim.attitude_cases import environment, sensors
from robustnav.sim.batch import simulate
from robustnav.sim.trajectory import case_two, steady_turn
from robustnav.units import DEG, DPS

KIT = Sensors("mpu9250", "ak8963")


@pytest.fixture(scope="module")
def turning():
    return simulate(case_two(), sensors(), environment(), runs=1, seed=4).log(0)


def with_stream(log: Log, name: str, values) -> Log:
    old = log.streams[name]
    return replace(log, streams={**log.streams, name: Stream(name, old.t, values, old.unit)})


def test_the_start_is_right_while_the_carrier_turns(turning):
    """Case II turns at 84 deg/s from its first sample; a plain mean over half a second is 20 deg off."""
    first = first_readings(turning)
    off = np.linalg.norm(rotation_error(first.q_nb, turning.truth.q_nb[0])) / DEG
    assert off < 0.5
    assert first.dip_deg == pytest.approx(60.0, abs=0.5)
    assert first.field == pytest.approx(48e-6, rel=0.01)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_every_estimator_tracks_a_turning_carrier(turning, name):
    run = run_recorded(name, turning, KIT)
    assert run.estimator == name
    assert evaluate(run, turning.truth).values["total_deg"] < 3.0


def test_a_declination_turns_the_result_and_nothing_else(turning):
    plain = run_recorded("mekf", turning, KIT)
    true = run_recorded("mekf", replace(turning, info={"declination_deg": 10.0}), KIT)
    off = rotation_error(true.state["q_nb"], plain.state["q_nb"])
    np.testing.assert_allclose(off, np.tile([0, 0, 10 * DEG], (len(off), 1)), atol=1e-9)
    assert true.settings["north"] == "true"
    np.testing.assert_array_equal(true.state["gyro_bias"], plain.state["gyro_bias"])


def test_without_a_magnetometer_tilt_still_holds():
    log = simulate(steady_turn(20 * DPS, 20.0, 100.0), sensors(), environment(), runs=1, seed=2).log(0)
    log = replace(log, streams={n: s for n, s in log.streams.items() if n != "mag"})
    run = run_recorded("mekf", log, KIT)
    assert evaluate(run, log.truth).values["inclination_deg"] < 0.5
    assert any("no mag stream" in e for e in run.events)


def test_a_slow_magnetometer_is_designed_for_its_own_rate():
    carried = replace(sensors(), magnetometer_rate_hz=20.0)
    log = simulate(case_two(), carried, environment(), runs=1, seed=5).log(0)
    slow, _ = estimator_for("h2", log, KIT)
    fast, _ = estimator_for("h2", simulate(case_two(), sensors(), environment(), runs=1, seed=5).log(0), KIT)
    assert np.abs(slow.table.gains[-1, 1]).max() > np.abs(fast.table.gains[-1, 1]).max()
    assert evaluate(run_recorded("h2", log, KIT), log.truth).values["total_deg"] < 3.0


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda log: replace(log, streams={"gyro": log.streams["gyro"]}), "accel"),
        (lambda log: with_stream(log, "accel", np.full((1001, 3), np.nan)), "accel"),
        (lambda log: with_stream(log, "gyro", np.full((1001, 3), np.nan)), "gyro"),
        (lambda log: with_stream(log, "mag", log.streams["accel"].values * 1e-6), "along gravity"),
        (lambda log: with_stream(log, "accel", np.zeros((1001, 3))), "accel"),
    ],
)
def test_a_start_that_cannot_be_found_names_what_is_wrong(turning, spoil, words):
    with pytest.raises(InputError, match=words):
        estimator_for("mekf", spoil(turning), KIT)


def test_unknown_names_are_refused(turning):
    with pytest.raises(InputError, match="kalman"):
        estimator_for("kalman", turning, KIT)
    with pytest.raises(InputError, match="bno055"):
        estimator_for("h2", turning, Sensors("bno055", "ak8963"))


def test_both_models_start_at_the_same_attitude(turning):
    quaternion, euler = (estimator_for(n, turning, KIT)[1].x for n in ("mekf", "ekf-euler"))
    np.testing.assert_allclose(rotation_error(quat_from_euler(euler[:3]), quaternion[:4]), 0, atol=1e-12)
