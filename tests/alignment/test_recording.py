"""From a recording to increments: no turn is lost, nothing is made up, nonsense is refused with its place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robustnav.alignment.recording import nearest, readings_of
from robustnav.errors import InputError
from robustnav.frames import rotvec_from_quat
from robustnav.records import Log, Stream
from robustnav.sim.alignment import load_scenario, simulate_alignment
from robustnav.sim.alignment_log import alignment_log
from robustnav.units import DEG

G = 9.80665


def log_of(t, gyro, accel, *more):
    streams = (Stream("gyro", t, gyro, "rad/s"), Stream("accel", t, accel, "m/s^2"), *more)
    return Log({s.name: s for s in streams}, "made")


def resting(seconds=6.0, rate=50.0, *more):
    """A unit that nods by 5 degrees about right, every reading a mean over the interval before it."""
    t = np.arange(1, round(seconds * rate) + 1) / rate
    edges = np.append(0.0, t)
    pitch = 5 * DEG * np.sin(2 * edges)
    gyro = np.zeros((len(t), 3))
    gyro[:, 1] = np.diff(pitch) * rate
    middle = (pitch[1:] + pitch[:-1]) / 2
    accel = G * np.stack([np.sin(middle), 0 * t, -np.cos(middle)], axis=1)
    return log_of(t, gyro, accel, *more)


def changed(log, name, **changes):
    return replace(log, streams={**log.streams, name: replace(log.streams[name], **changes)})


def rows(log, keep):
    cut = {n: replace(s, t=s.t[keep], values=s.values[keep]) for n, s in log.streams.items()}
    return replace(log, streams=cut)


def test_a_simulated_recording_gives_the_increments_it_was_made_of():
    scenario = replace(load_scenario("h-10-10-60", "gusts"), duration=6.0)
    made, data = alignment_log(scenario, 3), simulate_alignment(scenario, 3)
    found = readings_of(made, 0.1)
    np.testing.assert_allclose(found.increments.rows, data.increments.rows, atol=1e-11)
    np.testing.assert_array_equal(found.reference, data.velocity.values[:, :2])
    np.testing.assert_allclose(found.t, data.velocity.t, atol=1e-12)
    assert found.events == () and np.isnan(found.field_b).all()
    np.testing.assert_array_equal(made.truth.q_nb, data.truth.q_nb)


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_an_odd_rate_and_jittering_stamps_lose_no_turn(jitter):
    """286 Hz does not divide a tenth of a second; the turn over each period is that of the axis all the same."""
    rng = np.random.default_rng(1)
    t = (np.arange(1, 4000) + jitter * rng.uniform(-1, 1, 3999)) / 286.0
    edges = np.append(t[0] - 1 / 286, t)
    gyro = np.zeros((len(t), 3))
    gyro[:, 2] = np.diff(np.sin(edges)) / np.diff(edges)
    found = readings_of(log_of(t, gyro, np.tile([0.0, 0.0, -G], (len(t), 1))), 0.1)
    turn = rotvec_from_quat(found.increments.rotation)[:, 2]
    np.testing.assert_allclose(turn, np.sin(found.t) - np.sin(found.t - 0.1), atol=1e-5)
    np.testing.assert_allclose(turn.sum(), np.sin(found.t[-1]) - np.sin(found.t[0] - 0.1), atol=1e-5)
    assert found.increments.dt == 0.1 and found.rate_hz == pytest.approx(286, rel=0.02)


def test_periods_end_where_the_reference_is_read():
    stamps = 0.237 + 0.5 * np.arange(11)
    found = readings_of(resting(6.0, 50.0, Stream("velocity", stamps, np.ones((11, 2)), "m/s", "n")), 0.1)
    read = ~np.isnan(found.reference[:, 0])
    np.testing.assert_allclose(found.t[read], stamps[:], atol=1e-9)
    assert found.t[0] == pytest.approx(0.137)
    assert "11 of 11" in found.events[0]


@settings(max_examples=60, deadline=None)
@given(arrays(float, st.integers(0, 30), elements=st.floats(-1.0, 4.0)), st.sampled_from([0.1, 0.25, 0.5]))
def test_the_nearest_reading_counts_once(stamps, period):
    t = np.sort(stamps)
    ends = 0.3 + period * np.arange(1, 11)
    found = nearest(Stream("x", t, np.arange(len(t), dtype=float)[:, None], "m"), ends, period)[:, 0]
    used = found[~np.isnan(found)]
    assert len(set(used)) == len(used)
    for end, index in zip(ends, found, strict=True):
        off = np.abs(t - end)
        if np.isnan(index):
            assert not (off < period / 2 - 1e-9).any()
        else:
            assert off[int(index)] == pytest.approx(off.min())
            assert off[int(index)] <= period / 2 + 1e-9


def test_a_row_with_a_missing_number_is_no_reading():
    stream = Stream("x", np.array([0.09, 0.1]), np.array([[1.0, 2.0], [3.0, np.nan]]), "m")
    np.testing.assert_array_equal(nearest(stream, np.array([0.1, 0.2]), 0.1)[0], [1.0, 2.0])


@pytest.mark.parametrize("lost", ["cut", "nan"])
def test_a_lost_sample_is_a_gap_and_only_the_longest_piece_is_taken_when_asked(lost):
    log = resting()
    if lost == "cut":
        log = rows(log, np.arange(300) != 99)
    else:
        values = log.streams["accel"].values.copy()
        values[99, 2] = np.nan
        log = changed(log, "accel", values=values)
    with pytest.raises(InputError, match=r"1 gap, the longest 0.04 s after 1.980 s(.|\n)*--start 2.020 --stop 6.000"):
        readings_of(log, 0.1)
    found = readings_of(log, 0.1, longest=True)
    assert found.t[0] - 0.1 == pytest.approx(2.0) and found.t[-1] == pytest.approx(6.0)
    assert "longest piece" in found.events[-1]


def test_a_repeated_stamp_is_named_and_left_out():
    log, twice = resting(), np.sort(np.append(np.arange(300), 40))
    found = readings_of(rows(log, twice), 0.1)
    np.testing.assert_array_equal(found.increments.rows, readings_of(log, 0.1).increments.rows)
    assert "1 inertial readings" in found.events[0]


def spoiled(kind):
    log = resting(6.0, 50.0, Stream("velocity", np.arange(1.0, 6.0), np.ones((5, 2)), "m/s", "n"))
    gyro, accel, velocity = (log.streams[name] for name in ("gyro", "accel", "velocity"))
    cut = {n: s for n, s in log.streams.items() if n != "gyro"}
    return {
        "no gyro": lambda: replace(log, streams=cut),
        "degrees": lambda: changed(log, "gyro", values=gyro.values / DEG),
        "axes": lambda: changed(log, "gyro", values=40 * gyro.values[:, [1, 0, 2]]),
        "g": lambda: changed(log, "accel", values=accel.values / G),
        "unit": lambda: changed(log, "accel", unit="m/s"),
        "apart": lambda: changed(log, "accel", t=accel.t + 0.01),
        "fewer": lambda: changed(log, "accel", t=accel.t[1:], values=accel.values[1:]),
        "short": lambda: log.between(0.0, 1.9),
        "empty": lambda: log.between(100.0, 200.0),
        "missing": lambda: changed(log, "gyro", values=np.full_like(gyro.values, np.nan)),
        "body": lambda: changed(log, "velocity", frame="b"),
        "one column": lambda: changed(log, "velocity", values=velocity.values[:, :1]),
        "fast": lambda: changed(log, "velocity", values=100 * velocity.values),
        "elsewhen": lambda: changed(log, "velocity", t=velocity.t + 1000.0),
    }[kind]()


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("no gyro", "no stream 'gyro'"),
        ("degrees", "rad/s, not deg/s"),
        ("axes", "disagree"),
        ("g", "1 m/s"),
        ("unit", "expected  3 columns in m/s"),
        ("apart", "row 0|row"),
        ("fewer", "300 and 299"),
        ("short", "too short"),
        ("empty", "0 and 0 readings"),
        ("missing", "no readings"),
        ("body", "frame n"),
        ("one column", "2 columns"),
        ("fast", "100 m/s"),
        ("elsewhen", "one clock"),
    ],
)
def test_what_cannot_be_aligned_is_refused(kind, words):
    with pytest.raises(InputError, match=words):
        readings_of(spoiled(kind), 0.1)


@pytest.mark.parametrize("period", [0.0, -0.1, float("nan")])
def test_a_period_is_positive(period):
    with pytest.raises(InputError, match="increments, dt"):
        readings_of(resting(), period)


def test_a_calm_base_and_one_that_swings_hard_both_pass():
    """Specific force that stands still says nothing against a gyro; the published sway turns at 190 deg/s."""
    log = resting()
    calm = changed(changed(log, "gyro", values=np.full((300, 3), 1e-3)), "accel", values=np.tile([0, 0, -G], (300, 1)))
    assert len(readings_of(calm, 0.1).t) == 60
    hard = alignment_log(replace(load_scenario("s-10-10-60"), duration=3.0), 0)
    assert len(readings_of(hard, 0.1).t) == 30


@settings(max_examples=50, deadline=None)
@given(arrays(float, st.integers(2, 60), elements=st.floats(0.0, 0.4)), st.floats(-1e9, 1e9))
def test_any_stamps_are_aligned_or_refused(steps, start):
    """What is kept holds all the specific force of its time."""
    t = start + np.cumsum(steps)
    log = log_of(t, np.zeros((len(t), 3)), np.tile([0.0, 0.0, -G], (len(t), 1)))
    try:
        found = readings_of(log, 0.1, longest=True)
    except InputError:
        return
    np.testing.assert_allclose(found.increments.velocity[:, 2], -0.1 * G, rtol=1e-3)
