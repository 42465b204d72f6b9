"""Anchors and ranges as records: what they refuse, and the readings a filter gets from them."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.logs import RangeRecording
from robustnav.records import Anchors, Log, Ranges, Stream

PLACES = np.array([[0.0, 0, 0], [9, 0, -1], [0, 9, -2]])
ANCHORS = Anchors(("A", "B", "C"), PLACES)


def ranges(**changes):
    values = {"t": [0.0, 0.1, 0.1], "anchor": [2, 0, 1], "tag": [0, 0, 0], "distance": [1.0, 2.0, 3.0]}
    return Ranges(**{**values, "anchors": ANCHORS, **changes})


def test_every_reading_carries_the_place_of_its_anchor():
    stream = ranges().stream()
    np.testing.assert_array_equal(stream.values, [[1, 0, 9, -2], [2, 0, 0, 0], [3, 9, 0, -1]])
    assert (stream.name, stream.unit, stream.frame) == ("range", "m", "a")


def test_a_choice_of_rows_keeps_rows_together():
    some = ranges(variance=[0.1, 0.2, 0.3]).where(np.array([True, False, True]))
    np.testing.assert_array_equal(some.stream().values, [[1, 0, 9, -2], [3, 9, 0, -1]])
    np.testing.assert_array_equal(some.variance, [0.1, 0.3])
    assert len(ranges().where(np.zeros(3, bool))) == 0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"t": [0.0, -0.1, 0.1]}, "backwards"),
        ({"t": [0.0, np.nan, 0.1]}, "row 1"),
        ({"t": [0.0, 0.1]}, "shape"),
        ({"anchor": [2, 0, 3]}, "anchor, row 2(.|\n)*0 to 2"),
        ({"anchor": [2, -1, 0]}, "anchor, row 1"),
        ({"anchor": [2.0, 0.0, 0.0]}, "integers"),
        ({"anchor": [2, 0]}, "shape"),
        ({"tag": [0, 1, 0]}, "tag, row 1"),
        ({"distance": [1.0, np.nan, 3.0]}, "distance, row 1"),
        ({"distance": [1.0, np.inf, 3.0]}, "distance, row 1"),
        ({"variance": [1.0, -1.0, 3.0]}, "variance, row 1"),
        ({"variance": [1.0, 1.0]}, "shape"),
        ({"lever_b": np.zeros((2, 3))}, "lever_b"),
        ({"tags": ()}, "none"),
        ({"tags": ("x", "x")}, "twice"),
    ],
)
def test_ranges_that_are_none_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        ranges(**changes)


@pytest.mark.parametrize(
    ("ids", "places", "sd", "words"),
    [
        ((), np.zeros((0, 3)), None, "none"),
        (("A", "A"), PLACES[:2], None, "'A' twice"),
        (("A", ""), PLACES[:2], None, "printable"),
        (("A", "B\n"), PLACES[:2], None, "printable"),
        (("A", "B"), PLACES, None, "shape"),
        (("A", "B"), [[0, 0, 0], [0, 0, np.nan]], None, "finite"),
        (("A", "B"), PLACES[:2], [[1, 1, 1], [1, 1, 0]], "> 0"),
        (("A", "B"), PLACES[:2], [1, 1], "shape"),
    ],
)
def test_anchors_that_are_none_are_refused(ids, places, sd, words):
    with pytest.raises(InputError, match=words):
        Anchors(ids, places, sd)


def test_a_log_takes_the_ranges_as_one_sensor():
    gyro = Stream("gyro", np.arange(3.0), np.zeros((3, 3)), "rad/s")
    recording = RangeRecording(ranges(), Log({"gyro": gyro}, "made"))
    log = recording.log_with(recording.ranges)
    assert list(log.streams) == ["gyro", "range"]
    assert list(recording.log.streams) == ["gyro"]
    with pytest.raises(InputError, match="one already"):
        recording.log_with(recording.ranges, "gyro")
