"""Range differences as a record: what it refuses, and the readings a filter gets from it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav import ranging, records
from robustnav.errors import InputError
from robustnav.ranging import Anchors, RangeDifferences, Ranges

ANCHORS = Anchors(("A", "B", "C"), np.array([[0.0, 0, 0], [9, 0, -1], [0, 9, -2]]))


def differences(**changes):
    values = {
        "t": [0.0, 0.1, 0.1],
        "first": [2, 0, 1],
        "second": [0, 1, 2],
        "tag": [0, 0, 0],
        "difference": [1, -2, 3],
    }
    return RangeDifferences(**{**values, "anchors": ANCHORS, **changes})


def test_every_reading_carries_the_places_of_first_and_second():
    stream = differences().stream()
    np.testing.assert_array_equal(
        stream.values, [[1, 0, 9, -2, 0, 0, 0], [-2, 0, 0, 0, 9, 0, -1], [3, 9, 0, -1, 0, 9, -2]]
    )
    assert (stream.name, stream.unit, stream.frame) == ("tdoa", "m", "a")


def test_a_choice_of_rows_keeps_rows_together():
    some = differences().where(np.array([True, False, True]))
    np.testing.assert_array_equal(some.stream().values, differences().stream().values[[0, 2]])
    np.testing.assert_array_equal(some.t, [0.0, 0.1])
    assert len(some) == 2 and len(differences().where(np.zeros(3, bool))) == 0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"t": [0.0, -0.1, 0.1]}, "backwards in range differences"),
        ({"t": [0.0, 0.1]}, "shape"),
        ({"first": [2, 0, 3]}, "first, row 2(.|\n)*0 to 2"),
        ({"second": [-1, 1, 2]}, "second, row 0"),
        ({"second": [0.0, 1.0, 2.0]}, "integers"),
        ({"second": [0, 1]}, "shape"),
        ({"second": [0, 0, 2]}, "second, row 1(.|\n)*two different anchors"),
        ({"tag": [0, 0, 1]}, "tag, row 2"),
        ({"difference": [1.0, np.nan, 3.0]}, "difference, row 1"),
        ({"difference": [1.0, 2.0]}, "shape"),
        ({"lever_b": np.zeros(3)}, "lever_b"),
        ({"tags": ()}, "none"),
    ],
)
def test_differences_that_are_none_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        differences(**changes)


@given(st.lists(st.integers(-1, 3), min_size=3, max_size=3), st.lists(st.integers(-1, 3), min_size=3, max_size=3))
def test_exactly_pairs_of_different_anchors_are_accepted(first, second):
    good = all(0 <= a <= 2 and 0 <= b <= 2 and a != b for a, b in zip(first, second, strict=True))
    if good:
        assert len(differences(first=first, second=second)) == 3
        return
    with pytest.raises(InputError, match=r"range differences (first|second), row"):
        differences(first=first, second=second)


def test_records_give_the_same_names():
    assert (records.Anchors, records.Ranges, records.RangeDifferences) == (Anchors, Ranges, ranging.RangeDifferences)
