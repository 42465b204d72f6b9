"""Alignment of a moving carrier: from any attitude, honest, near a filter that knew, causal, robust, lost and found."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.datasheet.sensors import Imu, SensorSpec
from robustnav.engine.backends import functions_of
from robustnav.errors import EstimatorError, InputError
from robustnav.frames import euler_from_quat, quat_from_euler, quat_from_matrix, rotate, rotation_error
from robustnav.models import InertialNoise
from robustnav.records import Stream
from robustnav.run.feed import feed_of
from robustnav.run.loop import Start, run
from robustnav.run.moving import align_moving, fused_streams
from robustnav.run.moving_compass import with_compass
from robustnav.run.moving_setting import GnssAiding, InertialUnit, MovingStart, moving_ekf
from robustnav.run.moving_start import moving_starts, window_at
from robustnav.run.task import Task
from robustnav.sim.moving import MovingKit, Receiver, simulate_moving
from robustnav.sim.moving_ways import way
from robustnav.sim.sensor_errors import ErrorSwitches
from robustnav.units import DEG, DEG_PER_HOUR, MILLI_G

HZ, LATITUDE = 50.0, 47 * DEG
NOISE = InertialNoise(2e-4, 2e-3, 2e-6, 1e-4)
UNIT = InertialUnit(NOISE, 0.3 * DEG, 0.15)
IMU = Imu("made", SensorSpec(density=2**0.5 * 2e-4, random_walk=2e-6, turn_on_bias_sd=0.3 * DEG),
          SensorSpec(density=2**0.5 * 2e-3, random_walk=1e-4, turn_on_bias_sd=0.15))  # fmt: skip
ERRORS = ErrorSwitches(white_noise=True, random_walk=True, turn_on_bias=True)
BOTH = GnssAiding(0.1, 1.5)
ARM = (2.0, 0.0, -1.0)


def recording(name, seed, receiver=Receiver(), duration=20.0, **kit):  # noqa: B008 - frozen
    states = way(name, seed, duration, HZ)
    return states, simulate_moving(states, MovingKit(IMU, ERRORS, receiver, **kit), latitude=LATITUDE, seed=seed)


def task_of(log, aiding=BOTH):
    model = moving_ekf(log, UNIT, aiding).model
    fused = replace(log, streams=fused_streams(log, aiding))
    return Task(moving_ekf(log, UNIT, aiding), fused, feed_of(model, fused), {}, "auto")


def errors(states, said):
    rows = np.searchsorted(states.t, said.t - 1e-6)
    return rotation_error(states.q_nb[rows], said.state["q_nb"])


def found_at(said):
    return [float(word.split()[3]) for word in said.events if word.startswith("heading found")]


@pytest.mark.parametrize(
    "aiding", [GnssAiding(0.1, 0.3), GnssAiding(0.1), GnssAiding(position_sd=0.3)], ids=["both", "velocity", "position"]
)
def test_a_start_errs_as_it_says_at_any_attitude(aiding):
    settings, squares, tilts = MovingStart(tilt_sd=6 * DEG), [], []
    for seed in range(30):
        states, log = recording("drone", seed, Receiver(10.0, 0.1, 0.3, lever_b=ARM), 6.0)
        turn = quat_from_euler(np.random.default_rng(seed).uniform(-3, 3, 3))  # the unit is mounted anyhow
        axes = {
            n: Stream(n, log.streams[n].t, rotate(turn, log.streams[n].values), log.streams[n].unit)
            for n in ("gyro", "accel")
        }
        aiding = replace(aiding, lever_b=tuple(rotate(turn, np.array(ARM))))
        task = task_of(replace(log, streams={**log.streams, **axes}), aiding)
        row = 290
        window = window_at(task, row, settings)
        C_nb = rotate(states.q_nb[row], rotate(turn * [1, -1, -1, -1], np.eye(3))).T
        starts = moving_starts(task, window, aiding, 24)
        e = [_error(task, states, row, C_nb, start) for start in starts]
        k = int(np.argmin([abs(one[2]) for one in e]))
        tilts.append(np.linalg.norm(e[k][:2]))
        keep = [*range(6), *([6, 7, 8] if aiding.position_sd else [])]
        squares.append(e[k][keep] @ np.linalg.solve(starts[k].P[np.ix_(keep, keep)], e[k][keep]) / len(keep))
        assert abs(e[k][2]) < 12 * DEG
    assert 0.5 < np.mean(squares) < 1.2  # of 30 times 6 or 9 numbers, the heading's within a third of its variance
    assert np.median(tilts) < 4 * DEG


def _error(task, states, row, C_nb, start):
    parts = task.estimator.model.state_slices
    q = start.x[parts["q_nb"]]
    e = rotation_error(quat_from_matrix(C_nb), q)
    return np.concatenate([e, states.v_n[row] - start.x[parts["v_n"]], states.p_n[row] - start.x[parts["p_n"]]])


@pytest.mark.parametrize("name", ["drone", "car"])
def test_errors_are_as_large_as_stated_and_near_those_of_a_filter_that_knew(name):
    squares, late, knew, found = [], [], [], []
    for seed in range(16):
        states, log = recording(name, seed)
        said = align_moving(log, UNIT, BOTH)
        e = errors(states, said)
        found += found_at(said)
        rows = np.searchsorted(said.t, [2.0, 5.0, 10.0, 19.0])
        squares.append((e[rows] / said.sd["q_nb"][rows]) ** 2)
        late.append(e[-1])
        estimator = moving_ekf(log, UNIT, BOTH)
        start = Start.at(
            estimator.model,
            {**estimator.model.start_sd, "q_nb": 1e-3, "v_n": 0.01, "p_n": 0.01},
            **{block: getattr(states, block)[0] for block in ("q_nb", "v_n", "p_n")},
        )
        peer = run(estimator, replace(log, streams=fused_streams(log, BOTH)), start)
        knew.append(errors(states, peer)[-1])
    assert len(found) == 16 and np.median(found) < {"drone": 4.0, "car": 11.0}[name]
    mean = np.mean(squares, axis=0)
    assert mean.max() < 2.4 and mean.mean() < 1.4 and mean.mean() > 0.5  # 16 runs: 1 +- 0.7 covers 95 %
    rms = [np.sqrt(np.mean(np.square(one), axis=0)) for one in (late, knew)]
    assert np.linalg.norm(rms[0]) < 2.2 * np.linalg.norm(rms[1])  # 19 s on, the other still remembers


def test_while_the_heading_is_unknown_it_says_so():
    states, log = recording("car", 3)
    still = {
        n: replace(s, values=np.tile(s.values[:1] if n != "gyro" else 0 * s.values[:1], (len(s), 1)))
        for n, s in log.streams.items()
    }
    still["accel"] = replace(still["accel"], values=np.tile([0.0, 0.0, -9.808], (len(states.t), 1)))
    rng = np.random.default_rng(1)
    for name, sd in (("gnss_velocity", 0.1), ("gnss_position", 1.5)):
        still[name] = replace(still[name], values=rng.normal(0, sd, still[name].values.shape))
    said = align_moving(replace(log, streams=still), UNIT, BOTH)
    assert said.sd["q_nb"][:, 2].min() > 60 * DEG and said.sd["q_nb"][-1, :2].max() < 2 * DEG
    assert any(word.startswith("heading not found by") for word in said.events)


def test_nothing_looks_ahead():
    _, log = recording("car", 4)
    whole, part = (align_moving(one, UNIT, BOTH) for one in (log, log.between(0.0, 11.1)))
    n = len(part.t)
    for name, values in part.state.items():
        np.testing.assert_array_equal(values, whole.state[name][:n])
        np.testing.assert_array_equal(part.sd[name], whole.sd[name][:n])


def test_the_smoother_knows_from_the_start():
    states, log = recording("car", 5)
    forward, back = (align_moving(log, UNIT, BOTH, smooth=smooth) for smooth in (False, True))
    assert np.abs(errors(states, back)[:, 2]).max() < 6 * DEG < forward.sd["q_nb"][0, 2]
    assert back.estimator == "mekf-rts" and back.sd["q_nb"][0, 2] < 4 * DEG


def test_outliers_and_outages_cost_little_and_are_named():
    late = []
    for seed in range(4):
        states, log = recording("drone", seed, Receiver(outages=((8.0, 14.0),), outlier_share=0.15))
        said = align_moving(log, UNIT, BOTH)
        late.append(np.abs(errors(states, said)[-1]).max())
        assert any(word.startswith("no gnss_velocity from 7.") for word in said.events)
        assert not any("lost" in word for word in said.events) and found_at(said)[0] < 8.0
    assert max(late) < 4 * DEG


def test_a_filter_lost_by_a_knock_starts_again():
    states, log = recording("drone", 6, duration=40.0)
    gyro = log.streams["gyro"]
    knocked = gyro.values.copy()
    knocked[(gyro.t > 15.0) & (gyro.t < 15.2)] += [0.0, 15.0, 10.0]
    log = replace(log, streams={**log.streams, "gyro": replace(gyro, values=knocked)})
    said = align_moving(log, UNIT, BOTH)
    again = [word for word in said.events if word.startswith("lost and started again at ")]
    assert again and 16 < float(again[0].split()[5]) < 24
    assert np.abs(errors(states, said)[-1] / said.sd["q_nb"][-1]).max() < 4
    never = align_moving(log, UNIT, BOTH, MovingStart(restart=False))
    assert not any("lost" in word for word in never.events)


@pytest.mark.parametrize("one", [GnssAiding(position_sd=0.2), GnssAiding(0.1)], ids=["position", "velocity"])
def test_a_late_receiver_is_moved_back_and_its_arm_is_known(one):
    worse, better, squares = [], [], []
    for seed in range(3):
        states, log = recording("drone", seed, Receiver(position_sd=0.2, lever_b=ARM, delay=0.2))
        for told, out in (
            (one, worse),
            (replace(one, delay=0.2), worse),
            (replace(one, lever_b=ARM, delay=0.2), better),
        ):
            said = align_moving(log, UNIT, told)
            out.append(np.linalg.norm(errors(states, said)[-1]))
        squares.append((errors(states, said)[-1] / said.sd["q_nb"][-1]) ** 2)
    assert np.mean(better) < 0.5 * np.mean(worse) and max(better) < 3 * DEG
    assert np.mean(squares) < 2.5  # of 9 numbers, expected 1


def test_the_arm_is_turned_by_what_the_gyro_reads_without_its_bias():
    states, log = recording("drone", 2, Receiver(1.0, lever_b=ARM), 6.0)
    holes = log.streams["gyro"].values.copy()
    at = log.streams["gnss_velocity"].t
    holes[np.searchsorted(states.t, at[2]), 1] = np.nan  # the interval that holds the third reading
    log = replace(log, streams={**log.streams, "gyro": replace(log.streams["gyro"], values=holes)})
    told = replace(GnssAiding(0.1), lever_b=ARM)
    streams = fused_streams(log, told)
    model = moving_ekf(log, UNIT, told).model
    x, bias = model.nominal_state(), np.array([0.01, -0.02, 0.03])
    x[model.state_slices["gyro_bias"]] = bias
    for k in (0, 1, 2, 3):
        reading = streams["velocity"].values[k]
        row = np.searchsorted(states.t, at[k]) + (k == 2)
        np.testing.assert_array_equal(reading[6:], holes[row])
        seen = functions_of(model).measure(model.sensor_index("velocity"), x, reading[3:])
        np.testing.assert_allclose(seen, np.cross(holes[row] - bias, ARM), atol=1e-12)
    late = replace(log, streams={**log.streams, "gnss_velocity": replace(log.streams["gnss_velocity"], t=at + 4.0)})
    assert np.isnan(fused_streams(late, told)["velocity"].values[at + 4.0 > states.t[-1], 6:]).all()


def test_one_reading_of_a_compass_is_all_it_tells():
    states, log = recording("car", 7, compass_sd=8 * DEG)
    off = np.angle(np.exp(1j * (log.streams["heading"].values[0, 0] - euler_from_quat(states.q_nb)[0, 2])))
    said = align_moving(log, UNIT, replace(BOTH, heading_sd=10 * DEG))
    assert len(said.innovations["heading"].t) == 1
    assert any(word.startswith("1 of 101 heading readings") for word in said.events)
    early, bare = np.searchsorted(said.t, 1.5), align_moving(log, UNIT, BOTH)
    assert said.sd["q_nb"][early, 2] < 40 * DEG < bare.sd["q_nb"][np.searchsorted(bare.t, 1.5), 2]
    last = errors(states, said)[-1, 2]
    assert abs(last) < min(3 * DEG, abs(off)) and abs(last) < 4 * said.sd["q_nb"][-1, 2]


def with_mag(states, log, wrong=0.0, dip=65 * DEG, declination=10 * DEG):
    """Add a magnetometer on the carrier, its field turned about the vertical by ``wrong`` [rad]."""
    azimuth = declination + wrong
    field_n = 5e-5 * np.array([np.cos(dip) * np.cos(azimuth), np.cos(dip) * np.sin(azimuth), np.sin(dip)])
    field_b = rotate(states.q_nb * [1, -1, -1, -1], np.tile(field_n, (len(states.t), 1)))
    return replace(log, streams={**log.streams, "mag": Stream("mag", states.t, field_b, "T")})


def test_a_magnetometer_is_a_compass_that_can_be_outvoted():
    told = replace(BOTH, heading_sd=15 * DEG, declination=10 * DEG)
    early, late, lasting = [], [], []
    for seed in range(12):
        states, log = recording("car", seed)
        said = align_moving(with_mag(states, log), UNIT, told)
        assert len(said.innovations["heading"].t) == 1
        assert any(word.startswith("1 of 1001 mag readings fused as a heading") for word in said.events)
        k = np.searchsorted(said.t, 2.0)
        early.append(errors(states, said)[k, 2])
        late.append(errors(states, said)[-1, 2])
        assert said.sd["q_nb"][k, 2] < 45 * DEG
        off = align_moving(with_mag(states, log, wrong=120 * DEG), UNIT, told)
        lasting.append(errors(states, off)[-1, 2] / off.sd["q_nb"][-1, 2])
    assert np.sqrt(np.mean(np.square(early))) < 15 * DEG and np.sqrt(np.mean(np.square(late))) < 3 * DEG
    assert np.max(np.abs(lasting)) < 4  # a compass that is wrong by far is outvoted


def test_a_magnetometer_is_levelled_however_it_is_mounted():
    told, row = replace(BOTH, heading_sd=15 * DEG, declination=10 * DEG), 100
    for seed, angles in enumerate(([0.9, 0.4, 0.0], [-2.0, 0.3, 1.0], [3.0, -0.5, -2.0])):
        states, log = recording("car", seed, duration=6.0)
        turn = quat_from_euler(np.array(angles))
        log = with_mag(states, log)
        axes = {
            n: replace(log.streams[n], values=rotate(turn, log.streams[n].values)) for n in ("gyro", "accel", "mag")
        }
        log = replace(log, streams={**log.streams, **axes})
        task = task_of(log, told)
        heard, _ = with_compass(
            task, log, told, (row, moving_starts(task, window_at(task, row, MovingStart()), told, 24))
        )
        C_nb = rotate(states.q_nb[row], rotate(turn * [1, -1, -1, -1], np.eye(3))).T
        true = euler_from_quat(quat_from_matrix(C_nb))[2]
        (reading,) = heard.log.streams["heading"].values
        assert abs(np.angle(np.exp(1j * (reading[0] - true)))) < 15 * DEG


def test_a_compass_that_is_not_there_is_named():
    states, log = recording("car", 1, duration=6.0)
    told = replace(BOTH, heading_sd=15 * DEG, declination=0.0)
    full = with_mag(states, log)
    gone = replace(full.streams["mag"], values=np.full((len(states.t), 3), np.nan))
    steep = with_mag(states, log, dip=88 * DEG)
    for one, words in (
        (log, "no mag stream"),
        (replace(full, streams={**full.streams, "mag": gone}), "no mag reading after"),
        (steep, "too steep"),
    ):
        said = align_moving(one, UNIT, told)
        assert any(word.startswith(words) or words in word for word in said.events), said.events
        assert "heading" not in said.innovations
    silent = align_moving(full, UNIT, BOTH)  # no sd, no compass
    assert "heading" not in silent.innovations and not any("mag" in word for word in silent.events)


def test_the_earths_rate_counts_for_a_unit_that_feels_it():
    fine = InertialUnit(InertialNoise(1e-6, 3e-4, 2e-9, 1e-6), 0.1 * DEG_PER_HOUR, MILLI_G)
    imu = Imu("fine", SensorSpec(density=1.4e-6, turn_on_bias_sd=fine.gyro_bias_sd), SensorSpec(density=4e-4))
    states = way("drone", 8, 40.0, HZ)
    log = simulate_moving(states, MovingKit(imu, ERRORS, Receiver()), latitude=LATITUDE, seed=8)
    nowhere = replace(log, info={})
    said, blind = align_moving(log, fine, BOTH), align_moving(nowhere, fine, BOTH)
    told = align_moving(nowhere, fine, BOTH, MovingStart(latitude=LATITUDE))
    np.testing.assert_array_equal(said.state["q_nb"], told.state["q_nb"])
    scaled = [np.abs(errors(states, one)[-1] / one.sd["q_nb"][-1]).max() for one in (said, blind)]
    assert scaled[0] < 4 < scaled[1]
    assert any(word.startswith("no latitude") for word in blind.events)


def test_missing_readings_and_streams_are_named():
    states, log = recording("drone", 9)
    velocity = log.streams["gnss_velocity"]
    holes = velocity.values.copy()
    holes[::3, 1] = np.nan
    log = replace(log, streams={**log.streams, "gnss_velocity": replace(velocity, values=holes)})
    said = align_moving(log, UNIT, GnssAiding(0.1))
    assert "34 of 100 velocity readings missing: not fused" in said.events
    assert "gnss_position without position_sd: not fused" in said.events
    assert np.abs(errors(states, said)[-1]).max() < 3 * DEG
    bare = replace(log, streams={n: s for n, s in log.streams.items() if n != "gnss_position"})
    assert "no gnss_position stream: not fused" in align_moving(bare, UNIT, BOTH).events


def test_what_cannot_be_is_refused():
    _, log = recording("drone", 0, duration=5.0)
    bare = {n: s for n, s in log.streams.items() if not n.startswith("gnss")}
    with pytest.raises(InputError, match="no GNSS to align with"):
        align_moving(replace(log, streams=bare), UNIT, BOTH)
    for change in ({"frame": "b"}, {"unit": "km/h"}, {"values": log.streams["gnss_velocity"].values[:, :2]}):
        wrong = {**log.streams, "gnss_velocity": replace(log.streams["gnss_velocity"], **change)}
        with pytest.raises(InputError, match="'gnss_velocity'"):
            align_moving(replace(log, streams=wrong), UNIT, BOTH)
    far = {**log.streams, "gnss_velocity": replace(log.streams["gnss_velocity"], t=log.streams["gnss_velocity"].t + 99)}
    with pytest.raises(EstimatorError, match="no tilt to start from"):
        align_moving(replace(log, streams=far), UNIT, GnssAiding(0.1))
    _, steered = recording("drone", 0, duration=5.0, compass_sd=0.1)
    empty = replace(log.streams["gnss_velocity"], t=np.zeros(0), values=np.zeros((0, 3)))
    with pytest.raises(EstimatorError, match="no tilt to start from"):
        align_moving(
            replace(steered, streams={**steered.streams, "gnss_velocity": empty}), UNIT, GnssAiding(0.1, heading_sd=0.1)
        )
    for make, bad in (
        (GnssAiding, {}),
        (GnssAiding, {"velocity_sd": 0.0}),
        (GnssAiding, {"velocity_sd": 1.0, "lever_b": (0.0, float("nan"), 0.0)}),
        (GnssAiding, {"velocity_sd": 1.0, "declination": 0.1}),
        (GnssAiding, {"velocity_sd": 1.0, "heading_sd": 0.1, "declination": 10.0}),
        (MovingStart, {"headings": 3}),
        (MovingStart, {"window": 0.0}),
        (MovingStart, {"latitude": 2.0}),
        (lambda **k: InertialUnit(NOISE, **k), {"gyro_bias_sd": 0.0, "accel_bias_sd": 1.0}),
    ):
        with pytest.raises(InputError):
            make(**bad)
    with pytest.raises(InputError, match="nothing"):
        InertialUnit.from_datasheet(
            "nothing", gyro_bias_density=1e-6, accel_bias_density=1e-4, gyro_bias_sd=0.1, accel_bias_sd=0.1
        )
