"""Methods see no reference and no future; positions of a run at other times."""

import numpy as np
import pytest

from robustnav.benchmark.uwb_methods import METHODS, positions_at, snapshot_positions
from robustnav.errors import InputError
from robustnav.logs import RangeRecording
from robustnav.records import Anchors, Log, Ranges, Run

ANCHORS = Anchors(tuple("abcde"), np.array([[0, 0, 0], [9, 0, -3], [9, 8, 0], [0, 8, -3], [4, 4, -6.0]]))


def place(t):
    return np.column_stack([2 + 0.3 * t, 3 + 0 * t, -1 - 0.1 * t])


def made(seconds=3.0, tags=("tag",)):
    t = np.arange(0, seconds, 0.02)
    anchor = np.arange(len(t)) % 5
    distance = np.linalg.norm(place(t) - ANCHORS.p_a[anchor], axis=1)
    ranges = Ranges(t, anchor, np.zeros(len(t), int), distance, ANCHORS, tags)
    return RangeRecording(ranges, Log({}, "made"))


def test_snapshots_follow_and_hold():
    recording = made()
    t = np.array([-0.5, 0.0, 0.1, 1.0, 2.0, 2.98, 9.0])
    found = METHODS["snapshot"](recording, t)
    np.testing.assert_array_equal(np.isnan(found[:, 0]), [True, True, False, False, False, False, False])
    assert np.abs(found[2:6] - place(t[2:6])).max() < 0.2  # ranges are up to 0.1 s old, at 0.3 m/s
    np.testing.assert_array_equal(found[6], found[5])


@pytest.mark.parametrize("now", [0.5, 1.99])
def test_snapshots_see_no_future(now):
    recording = made()
    later = recording.ranges.t > now
    other = np.where(later, 7.0, recording.ranges.distance)
    changed = RangeRecording(
        Ranges(recording.ranges.t, recording.ranges.anchor, recording.ranges.tag, other, ANCHORS), recording.log
    )
    t = np.linspace(0.2, now, 5)
    np.testing.assert_array_equal(snapshot_positions(recording, t), snapshot_positions(changed, t))
    assert not np.array_equal(snapshot_positions(recording, t + 0.3), snapshot_positions(changed, t + 0.3))


def test_several_tags_are_refused():
    with pytest.raises(InputError, match="2 tags"):
        snapshot_positions(made(tags=("front", "back")), np.zeros(1))


def test_a_run_is_carried_on_by_its_velocity_or_interpolated():
    t = np.array([0.0, 1.0, 1.0, 2.0])
    p = np.array([[0.0, 0, 0], [5, 5, 5], [1, 2, 3], [4, 4, 4]])
    v = np.array([[1.0, 0, 0], [9, 9, 9], [0, 1, 0], [0, 0, 2]])
    run = Run("ekf", "uwb", t, {"p_n": p, "v_n": v}, {}, {})
    at = np.array([-0.1, 0.5, 1.0, 1.5, 2.5])
    causal = positions_at(run, at)
    np.testing.assert_allclose(causal[1:], [[0.5, 0, 0], [1, 2, 3], [1, 2.5, 3], [4, 4, 5]])
    assert np.isnan(causal[0]).all()
    smoothed = positions_at(run, at, smoothed=True)
    assert np.isnan(smoothed[0]).all()
    np.testing.assert_allclose(smoothed[[2, 3, 4]], [[1, 2, 3], [2.5, 3, 3.5], [4, 4, 5]])
