"""The offset between two clocks, by simulation: inside its interval, told from a lever, refused without motion."""

import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.calibrate.robust import HUBER, LEAST_SQUARES, STUDENT_T
from robustnav.calibrate.time_offset import OffsetOptions, offset_of_positions, offset_of_ranges
from robustnav.calibrate.time_offset_fit import robust_cost
from robustnav.errors import EstimatorError, InputError
from robustnav.records import Anchors, Ranges, Stream

DATA = os.environ.get("ROBUSTNAV_DATA")
ANCHORS = Anchors(tuple("abcd"), np.array([[-8, -6, -2.0], [8, -6, -0.5], [8, 6, -2], [-8, 6, -1]]))
BIAS = np.array([0.05, -0.03, 0.1, 0.0])
TIMES = np.arange(0, 100, 0.1)


def path(t, speed=None):
    """Return positions (n, 3): a loop at a changing speed, or round a circle of 5 m at a constant one."""
    if speed is not None:
        return np.column_stack([5 * np.cos(speed * t / 5), 5 * np.sin(speed * t / 5), -np.ones_like(t)])
    s = 0.8 * t + 1.2 * np.sin(0.35 * t)
    return np.column_stack([6 * np.sin(0.18 * s), 4 * np.sin(0.31 * s + 0.4), -1 + 0.2 * np.sin(0.2 * t)])


def track(speed=None, lag=0.0):
    return Stream("position", TIMES, path(TIMES - lag, speed), "m", "a")


def made(rng, *, offset=0.0, lever=0.0, late=0.0, speed=None, bias=BIAS):
    t = np.sort(rng.uniform(3, 97, 1500))
    k = rng.integers(0, 4, t.size)
    p, h = path(t - offset, speed), 1e-4
    v = path(t - offset + h, speed) - path(t - offset - h, speed)
    p = p + lever * v / np.linalg.norm(v, axis=1, keepdims=True)
    e = 0.1 * rng.standard_normal(t.size) + (rng.random(t.size) < late) * rng.exponential(1.5, t.size)
    return Ranges(t, k, np.zeros(t.size, int), np.linalg.norm(p - ANCHORS.p_a[k], axis=1) + bias[k] + e, ANCHORS)


@pytest.mark.parametrize("offset", [-0.4, 0.0, 0.18])
def test_the_offset_lies_in_its_interval_and_biases_come_out(offset):
    rng = np.random.default_rng(3)
    found = offset_of_ranges(made(rng, offset=offset, late=0.05), track(), OffsetOptions(level=0.999))
    assert found.offset.low < offset < found.offset.high < found.offset.low + 0.1
    np.testing.assert_allclose(list(found.biases.values()), BIAS, atol=0.04)
    assert list(found.biases) == list("abcd")


def test_the_interval_covers_as_often_as_it_says():
    rng = np.random.default_rng(4)
    inside = 0
    for _ in range(40):
        found = offset_of_ranges(made(rng, offset=0.18), track())
        inside += found.offset.low <= 0.18 <= found.offset.high
    assert inside >= 34  # binomial, 0.95: less happens once in 100


def test_a_lever_is_told_from_an_offset_when_the_speed_changes():
    found = offset_of_ranges(made(np.random.default_rng(5), lever=-0.2), track())
    assert found.offset.value == pytest.approx(0.2, abs=0.08)  # alone it passes for one
    assert found.offset_beside.low < 0.0 < found.offset_beside.high
    assert found.lever_beside.low < -0.2 < found.lever_beside.high
    assert found.cost_lever < found.cost_offset and "lever arm" in found.warning
    other = offset_of_ranges(made(np.random.default_rng(5), offset=0.2), track())
    assert other.cost_offset < other.cost_lever
    assert other.cost_both <= other.cost_offset + 1e-6 < other.cost_none


def test_at_one_speed_offset_and_lever_are_the_same_thing():
    bias = np.zeros(4)
    found = offset_of_ranges(made(np.random.default_rng(6), offset=0.2, speed=1.0, bias=bias), track(1.0))
    assert found.offset.value == pytest.approx(0.2, abs=0.03)
    assert found.lever_alone.value == pytest.approx(-0.2, abs=0.03)
    assert found.cost_lever == pytest.approx(found.cost_offset, rel=0.01)
    assert found.offset_beside is None and np.isnan(found.cost_both)
    assert "same thing" in found.warning


def test_positions_give_the_same():
    rng = np.random.default_rng(7)
    t = np.arange(4, 96, 0.2)
    p = path(t - 0.15) + [0.3, -0.2, 0.0] + 0.05 * rng.standard_normal((t.size, 3))
    p[40] = np.nan
    found = offset_of_positions(Stream("p_n", t, p, "m", "a"), track())
    assert found.offset.low < 0.15 < found.offset.high
    assert found.biases["x"] == pytest.approx(0.3, abs=0.02) and found.rows % 3 == 0
    # moving both clocks by the same amount changes nothing
    moved = offset_of_positions(Stream("p_n", t, p, "m", "a"), track(lag=0.1))
    assert found.offset.value - moved.offset.value == pytest.approx(0.1, abs=2e-3)


def test_gaps_and_standstill_are_left_out():
    rng = np.random.default_rng(8)
    ranges = made(rng, offset=0.1)
    hole = track()
    values = hole.values.copy()
    values[300:400] = np.nan
    found = offset_of_ranges(ranges, Stream("position", TIMES, values, "m", "a"))
    inside = (ranges.t > 30) & (ranges.t < 40)
    assert found.rows < len(ranges) - 0.8 * inside.sum()
    assert found.offset.low < 0.1 < found.offset.high


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (lambda r: (r, track(0.1)), InputError, "0.3 m/s"),
        (lambda r: (r.where(r.t < 12), track()), InputError, "blocks of time"),
        (lambda r: (r, Stream("p", TIMES, path(TIMES)[:, :2], "m", "a")), InputError, "reference track"),
        (lambda r: (r, Stream("p", np.repeat(TIMES[:500], 2), path(TIMES), "m", "a")), InputError, "ascend"),
        (lambda r: (r, track(), OffsetOptions(largest=0.0)), InputError, "largest"),
        (lambda r: (r, track(), OffsetOptions(level=1.0)), InputError, "level"),
        (lambda r: (r, track(lag=0.6), OffsetOptions(largest=0.3)), EstimatorError, "widen"),
    ],
)
def test_bad_input_is_refused(change, error, words):
    with pytest.raises(error, match=words):
        offset_of_ranges(*change(made(np.random.default_rng(9))))


def test_several_tags_are_refused():
    r = made(np.random.default_rng(10))
    two = Ranges(r.t, r.anchor, np.arange(len(r)) % 2, r.distance, r.anchors, ("a", "b"))
    with pytest.raises(InputError, match="several tags"):
        offset_of_ranges(two, track())


@pytest.mark.parametrize("loss", [HUBER, STUDENT_T, LEAST_SQUARES])
def test_the_cost_is_the_integral_of_weight_times_residual(loss):
    u, h = np.array([-7.0, -1.0, 0.2, 1.2, 4.0]), 1e-6
    for one in u:
        slope = (robust_cost(loss, np.array([one + h])) - robust_cost(loss, np.array([one - h]))) / (2 * h)
        assert slope == pytest.approx(float(loss.weight(np.array([one]))[0] * one), rel=1e-5, abs=1e-7)


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
@pytest.mark.parametrize(("case", "offset", "lever"), [("A/Case_1", 0.183, -0.19), ("B/Case_3", 0.177, -0.20)])
def test_the_outdoor_set_lags_by_as_much_as_a_lever_would_explain(case, offset, lever):
    from robustnav.logs import read_uwb_hyu

    recording = read_uwb_hyu(Path(DATA) / "uwb" / "hyu" / "dynamic" / "LOS" / f"Trajectory_{case}")
    found = offset_of_ranges(recording.ranges, recording.reference["position"])
    assert found.offset.value == pytest.approx(offset, abs=0.01)
    assert found.lever_alone.value == pytest.approx(lever, abs=0.015)
    assert found.cost_lever < 1.06 * found.cost_offset < 0.7 * found.cost_none
    assert "lever arm" in found.warning
