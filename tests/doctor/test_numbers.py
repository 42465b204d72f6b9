"""The numbers behind the findings, each against a case whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robustnav.doctor import Diagnosis, Finding, examine
from robustnav.doctor.axes import ALL_AXES, AxisMatch, axes_name, match_axes
from robustnav.doctor.judge_sensors import FIELD_UNITS, FORCE_UNITS, nearest_unit
from robustnav.doctor.motion import motion, running_integral
from robustnav.doctor.readings import readings
from robustnav.doctor.timing import timing
from robustnav.doctor.turning import explained, interval_rates
from robustnav.doctor.vectors import match_vectors
from robustnav.doctor.world import attitude_at, declination_deg, dip_deg, place, tilt_deg
from robustnav.earth import magnetic_field, normal_gravity
from robustnav.frames import quat_conjugate, quat_from_euler, quat_from_rotvec, rotate
from robustnav.records import Log, Stream, Truth

RNG = np.random.default_rng(11)


def gyro(t, values):
    return Stream("gyro", np.asarray(t, float), np.asarray(values, float), "rad/s")


def still(n=500, dt=0.01, **changes):
    """A standing log: noise on a constant field."""
    t = np.arange(n) * dt
    values = {
        "gyro": 1e-3 * RNG.standard_normal((n, 3)),
        "accel": [0, 0, -9.81] + 0.01 * RNG.standard_normal((n, 3)),
        "mag": [2e-5, 0, 4e-5] + 1e-7 * RNG.standard_normal((n, 3)),
    } | changes
    units = {"gyro": "rad/s", "accel": "m/s^2", "mag": "T"}
    return Log({name: Stream(name, t, v, units[name]) for name, v in values.items()}, "still")


def levels(log, check):
    return {f.level for f in examine(log).of(check)}


def test_timing_counts_gaps_repeats_and_stretched_intervals():
    t = np.concatenate([np.arange(10) * 0.01, [0.09, 0.11, 0.12, 0.15]])  # a repeat, one of 2, one of 3 intervals
    out = timing(gyro(t, np.zeros((len(t), 3))))
    assert (out.rows, out.repeats, out.gaps, out.stretched) == (14, 1, 1, 2)
    assert out.interval_s == pytest.approx(0.01)
    assert (out.largest_gap_s, out.largest_gap_at_s) == pytest.approx((0.03, 0.12))
    assert out.rate_hz == pytest.approx(13 / 0.15)


@pytest.mark.parametrize("t", [[], [1.0], [2.0, 2.0, 2.0]])
def test_useless_time_is_an_error(t):
    log = Log({"gyro": gyro(t, np.ones((len(t), 3)))}, "no time")
    assert levels(log, "T") == {"error"}


def test_repeated_stamps_are_a_warning():
    log = still()
    stream = log.streams["accel"]
    t = stream.t.copy()
    t[5] = t[4]
    assert "warning" in levels(replace(log, streams={"accel": replace(stream, t=t)}), "T")


def test_lost_samples_are_a_warning_and_few_are_not():
    log = still()
    keep = np.ones(500, bool)
    keep[100:400:3] = False
    lossy = {n: replace(s, t=s.t[keep], values=s.values[keep]) for n, s in log.streams.items()}
    assert levels(replace(log, streams=lossy), "T") == {"warning"}
    assert levels(log, "T") == {"ok"}


@pytest.mark.parametrize(
    ("values", "level"),
    [
        (np.full((500, 3), np.nan), "error"),
        (np.tile([0.0, 0.0, -9.81], (500, 1)), "error"),
        ([0, 0, -9.81] + 0.01 * RNG.standard_normal((500, 3)) * [1, 1, 0], "error"),
        (
            np.where(np.arange(500)[:, None] % 5 == 0, np.nan, [0, 0, -9.81] + 0.01 * RNG.standard_normal((500, 3))),
            "warning",
        ),
    ],
)
def test_dead_and_lost_readings_are_named(values, level):
    assert levels(still(accel=values), "Q") == {level}


def test_a_limited_sensor_is_named_and_a_quantised_one_is_not():
    swing = 6 * np.sin(np.linspace(0, 20, 500))[:, None] + 0.01 * RNG.standard_normal((500, 3))
    assert levels(still(gyro=swing), "Q") == set()
    assert levels(still(gyro=np.clip(swing, [-9, -4.36, -9], [9, 4.36, 9])), "Q") == {"error"}
    coarse = np.round(RNG.standard_normal((500, 3))) * 1e-3
    assert levels(still(gyro=coarse), "Q") == set()


def test_held_readings_are_counted():
    values = np.repeat(RNG.standard_normal((100, 3)), 5, axis=0)
    out = readings(Stream("mag", np.arange(500.0), values, "T"))
    assert (out.held, out.missing, out.constant) == (400, 0, ())


def test_units_are_told_apart_over_the_whole_range_of_the_earth():
    for name, factor in FIELD_UNITS.items():
        for field in (22e-6, 38e-6, 67e-6):
            assert nearest_unit(field / factor, np.sqrt(22e-6 * 67e-6), FIELD_UNITS) == name
    for name, factor in FORCE_UNITS.items():
        for size in (7.0, 9.8, 14.0):
            assert nearest_unit(size / factor, 9.81, FORCE_UNITS) == name


def test_size_limits_of_the_accelerometer():
    def level(scale):
        return levels(still(accel=[0, 0, -9.81 * scale] + 0.01 * RNG.standard_normal((500, 3))), "F")

    assert [level(s) for s in (1.0, 1.01, 1.03, 0.96, 1.07)] == [{"ok"}, {"ok"}, {"warning"}, {"warning"}, {"error"}]


def test_the_48_axes_are_all_different_and_well_named():
    assert len({axes_name(M) for M in ALL_AXES}) == 48
    assert axes_name(ALL_AXES[0]) == "+x+y+z"
    np.testing.assert_allclose(ALL_AXES @ np.swapaxes(ALL_AXES, 1, 2), np.tile(np.eye(3), (48, 1, 1)))
    for M in ALL_AXES:
        match = AxisMatch(0.0, axes_name(M), 1.0, 0.0)
        assert match.proper == (np.linalg.det(M) > 0)


@pytest.mark.parametrize("k", range(0, 48, 5))
def test_the_axes_that_were_changed_are_found(k):
    truth = RNG.standard_normal((50, 3)) * [1.0, 0.7, 0.4]
    measured = truth @ ALL_AXES[k]  # truth = M measured
    assert match_axes(lambda M: explained(truth, measured @ M.T)).best == axes_name(ALL_AXES[k])


def test_running_integral_is_exact_for_a_straight_line():
    t = np.sort(RNG.uniform(0, 5, 50))
    rate = np.column_stack([t, 2 * t, np.ones_like(t)])
    angle = running_integral(t, rate)
    want = np.column_stack([t**2 / 2, t**2, t])
    np.testing.assert_allclose(angle, want - want[0], atol=1e-12)


def test_motion_of_a_known_swing():
    t = np.arange(0, 20, 0.01)
    rate = np.zeros((len(t), 3))
    moving = (t >= 5) & (t < 7)
    rate[moving, 0] = 0.5 * np.pi * np.sin(np.pi * (t[moving] - 5))  # out one radian and back
    out = motion(gyro(t, rate + 0.01))
    np.testing.assert_allclose(out.swept_deg, [np.rad2deg(1.0), 0, 0], atol=0.1)
    assert out.unchecked == ("y", "z")
    # The fastest half second lies about the top of the half sine: 0.25 s to either side of it.
    assert out.peak_dps == pytest.approx(np.rad2deg(2 * np.sin(np.pi * 0.25) / 2 / 0.5), rel=0.01)
    assert not out.enough
    assert 5 <= out.moving_from_s < 5.1
    assert 6.9 < out.moving_to_s <= 7
    np.testing.assert_allclose(out.quiet_mean_dps, np.rad2deg([0.01] * 3))


def test_interval_rates_of_a_constant_turn():
    t, omega = np.arange(0, 4, 0.004), np.array([0.3, -0.2, 0.5])
    ta = np.concatenate([np.arange(-1, 2, 0.02), [3.0, 3.02, 3.02, 3.04, 9.0]])
    q = quat_from_rotvec(ta[:, None] * omega)
    q[10] = np.nan
    rates = interval_rates(gyro(t, np.tile(omega, (len(t), 1))), ta, q)
    np.testing.assert_allclose(rates.attitude, np.tile(omega, (len(rates.start), 1)), atol=1e-9)
    np.testing.assert_allclose(rates.gyro, rates.attitude, atol=1e-9)
    assert rates.start.min() >= 0
    assert (rates.stop - rates.start).max() < 0.06


def test_vectors_find_a_gyro_turned_against_them():
    t = np.arange(0, 20, 0.01)
    angles = np.column_stack([0.5 * np.sin(t), 0.4 * np.sin(1.7 * t), 0.6 * np.sin(0.6 * t)])
    q = quat_from_euler(angles)
    rates = interval_rates(gyro(t, np.zeros((len(t), 3))), t, q).attitude
    values = np.vstack([rates, rates[-1:]])
    accel = Stream("accel", t, rotate(quat_conjugate(q), [0, 0, -9.81]), "m/s^2")
    mag = Stream("mag", t, rotate(quat_conjugate(q), [2e-5, 0, 4e-5]), "T")
    for k in (0, 7, 29):
        match = match_vectors(gyro(t, 0.5 * values @ ALL_AXES[k]), [accel, mag])
        assert match.axes.best == axes_name(ALL_AXES[k])
    match = match_vectors(gyro(t, np.rad2deg(values)), [accel, mag])
    assert match.axes.best == "+x+y+z"
    assert match.scale == pytest.approx(np.deg2rad(1), rel=0.02)


def test_attitude_between_stamps_survives_a_change_of_sign():
    t = np.arange(0, 2, 0.1)
    q = quat_from_euler(np.column_stack([0.2 * t, 0 * t, 3 * t]))
    truth = Truth(t, np.where(np.arange(20)[:, None] % 2 == 0, q, -q))
    at = np.array([-0.1, 0.05, 1.23, 5.0])
    out, known = attitude_at(truth, at)
    np.testing.assert_array_equal(known, [False, True, True, False])
    want = quat_from_euler(np.column_stack([0.2 * at, 0 * at, 3 * at]))[known]
    np.testing.assert_allclose(np.abs(np.sum(out[known] * want, axis=1)), 1, atol=1e-5)


def test_attitude_is_unknown_in_a_long_gap():
    t = np.concatenate([np.arange(0, 1, 0.01), np.arange(3, 4, 0.01)])
    truth = Truth(t, np.tile([1.0, 0, 0, 0], (len(t), 1)))
    np.testing.assert_array_equal(attitude_at(truth, np.array([0.5, 2.0, 3.5]))[1], [True, False, True])


def test_world_angles():
    assert tilt_deg(np.array([0.0, 0, -9.8])) == pytest.approx(0)
    assert tilt_deg(np.array([0.0, 0, 9.8])) == pytest.approx(180)
    assert declination_deg(np.array([1.0, 1.0, 3.0])) == pytest.approx(45)
    log = still(mag=np.tile([2e-5, 0, 4e-5], (500, 1)))
    assert dip_deg(log.streams["accel"], log.streams["mag"])[0] == pytest.approx(np.rad2deg(np.arctan2(4, 2)), abs=0.02)


def test_place_uses_the_model_where_the_log_says_where_and_when():
    info = {"latitude_deg": 47.4, "longitude_deg": 8.5, "height_m": 488.0, "year": 2022.3}
    here = place(replace(still(), info=info))
    field = magnetic_field(47.4, 8.5, 488.0, 2022.3)
    assert here.gravity == normal_gravity(np.deg2rad(47.4), 488.0)
    assert (here.field_t, here.dip_deg) == (field.norm, field.dip_deg)
    assert place(replace(still(), info=info | {"year": 1999.0})).dip_deg is None
    assert place(still()) is None


def test_logs_of_any_content_are_examined():
    t = np.arange(5.0)
    ranges = Stream("range", t, np.ones((5, 4)), "m", "a")
    for streams in (
        {},
        {"range": ranges},
        {"gyro": gyro(t, np.zeros((5, 3)))},
        {"accel": replace(ranges, name="accel")},
    ):
        for truth in (None, Truth(t, np.full((5, 4), np.nan)), Truth(t, p_n=np.zeros((5, 3)))):
            for role in ("truth", "estimate"):
                found = examine(Log(dict(streams), "odd", **{role: truth}))
                assert isinstance(found.to_dict()["facts"], dict)


def test_worst_is_the_highest_level_and_json_has_no_nan():
    low, high = Finding("T", "info", "a"), Finding("F", "error", "b")
    found = Diagnosis("x", (low, high), {"a": np.array([1.0, np.nan]), "b": np.int64(3), "c": (np.float64("inf"), "t")})
    assert found.worst == "error"
    assert Diagnosis("x", ()).worst == "ok"
    assert found.to_dict()["facts"] == {"a": [1.0, None], "b": 3, "c": [None, "t"]}
    assert found.of("T") == (low,)
    assert found.at("error") == (high,)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(data=st.data())
def test_any_numbers_are_examined(data):
    """Whatever a reader lets through, the doctor answers with findings, never with a fault of its own."""
    n = data.draw(st.integers(0, 30))
    number = st.floats(-1e308, 1e308) | st.sampled_from([0.0, 1.0, -9.81, float("nan")])
    streams = {}
    for name, unit in (("gyro", "rad/s"), ("accel", "m/s^2"), ("mag", "T")):
        t = np.sort(data.draw(arrays(float, n, elements=st.floats(-1e300, 1e300) | st.floats(-9, 9))))
        streams[name] = Stream(name, t, data.draw(arrays(float, (n, 3), elements=number)), unit)
    q = quat_from_rotvec(data.draw(arrays(float, (n, 3), elements=st.floats(-3, 3))))
    info = {"latitude_deg": data.draw(number), "longitude_deg": data.draw(number), "year": data.draw(number)}
    truth = Truth(streams["gyro"].t, q, "optical", data.draw(st.sampled_from(["magnetic", "true"])))
    for role in ("truth", "estimate"):
        examine(Log(streams, "any", info=info, **{role: truth}))
