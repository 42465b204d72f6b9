"""Records refuse what they cannot carry, name the row, and change nothing on the way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robustnav.errors import InputError
from robustnav.records import Log, Score, Stream, Truth

T = np.array([0.0, 0.5, 0.5, 1.0])


def stream(t=T, values=None, name="gyro"):
    return Stream(name, t, np.zeros((len(t), 3)) if values is None else values, "rad/s")


@pytest.mark.parametrize("row", [1, 2, 3])
def test_time_going_backwards_names_its_row(row):
    t = np.arange(4.0)
    t[row] = t[row - 1] - 0.25
    with pytest.raises(InputError) as error:
        stream(t)
    assert error.value.place == f"row {row}"
    assert "'gyro'" in error.value.thing
    assert f"{t[row]:.6f} s after {t[row - 1]:.6f} s" in error.value.got


def test_repeated_times_are_allowed():
    assert len(stream(T)) == 4


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_time_must_be_finite(bad):
    t = np.arange(4.0)
    t[2] = bad
    with pytest.raises(InputError) as error:
        stream(t)
    assert error.value.place == "row 2"


@given(hnp.arrays(float, st.integers(0, 20), elements=st.floats(-1e9, 1e9)))
def test_exactly_the_sorted_times_are_accepted(t):
    backwards = [k for k in range(1, len(t)) if t[k] < t[k - 1]]
    if not backwards:
        assert len(stream(t)) == len(t)
        return
    with pytest.raises(InputError) as error:
        stream(t)
    assert error.value.place == f"row {backwards[0]}"


def test_nan_is_a_missing_value_and_infinity_is_an_error():
    values = np.zeros((4, 3))
    values[1, 2] = np.nan
    assert np.isnan(stream(values=values).values[1, 2])
    values[3, 0] = -np.inf
    with pytest.raises(InputError) as error:
        stream(values=values)
    assert error.value.place == "row 3"


@pytest.mark.parametrize("shape", [(4,), (3, 3), (5, 3), (4, 3, 1), (0, 3)])
def test_values_must_have_a_row_a_time(shape):
    with pytest.raises(InputError, match="gyro"):
        stream(values=np.zeros(shape))


def test_time_must_be_a_row_of_numbers():
    with pytest.raises(InputError, match=r"shape \(2, 2\)"):
        Stream("gyro", np.zeros((2, 2)), np.zeros((2, 3)), "rad/s")


def test_values_become_contiguous_double():
    one = stream(values=np.asfortranarray(np.ones((4, 3), np.float32)))
    assert one.values.dtype == np.float64
    assert one.values.flags.c_contiguous


def test_records_are_frozen():
    with pytest.raises(AttributeError):
        stream().unit = "deg/s"


def test_rate_is_intervals_over_span():
    assert stream(np.array([0.0, 0.1, 0.2, 0.4])).rate_hz == pytest.approx(7.5)
    for few in ([], [1.0], [1.0, 1.0]):
        assert np.isnan(stream(np.array(few)).rate_hz)


@given(hnp.arrays(float, st.integers(0, 20), elements=st.floats(-5, 5)), st.floats(-6, 6), st.floats(-6, 6))
def test_between_keeps_both_ends(times, start, stop):
    t = np.sort(times)
    values = np.arange(3.0 * len(t)).reshape(-1, 3)
    cut = stream(t, values).between(start, stop)
    keep = (t >= start) & (t <= stop)
    np.testing.assert_array_equal(cut.t, t[keep])
    np.testing.assert_array_equal(cut.values, values[keep])
    assert (cut.name, cut.unit, cut.frame) == ("gyro", "rad/s", "b")


@pytest.mark.parametrize(("name", "width"), [("q_nb", 4), ("p_n", 3), ("v_n", 3)])
def test_truth_arrays_must_fit_their_times(name, width):
    Truth(T, **{name: np.zeros((4, width))})
    for shape in ((3, width), (4, width + 1), (4,)):
        with pytest.raises(InputError, match=name):
            Truth(T, **{name: np.zeros(shape)})


def test_truth_time_is_checked_too():
    with pytest.raises(InputError, match="truth"):
        Truth(T[::-1].copy())


def test_a_log_names_the_streams_it_has():
    log = Log({"gyro": stream(), "accel": stream(name="accel")}, "flight.ulg")
    assert log.stream("gyro").name == "gyro"
    with pytest.raises(InputError) as error:
        log.stream("mag")
    assert error.value.place == "flight.ulg"
    assert "gyro, accel" in error.value.got
    with pytest.raises(InputError, match="none"):
        Log({}, "empty").stream("mag")


def test_a_cut_log_keeps_everything_but_the_rows():
    truth = Truth(T, q_nb=np.tile([1.0, 0, 0, 0], (4, 1)))
    log = Log({"gyro": stream()}, "a", ("c",), 7, truth, truth, ("s",), {"year": 2026.0})
    cut = log.between(0.5, 0.9)
    np.testing.assert_array_equal(cut.stream("gyro").t, [0.5, 0.5])
    kept = ("source", "conventions", "origin_ns", "truth", "estimate", "skipped", "info")
    assert all(getattr(cut, name) == getattr(log, name) for name in kept)


def test_a_score_carries_its_counts():
    score = Score("mekf", "optical", {"rms_deg": 0.5}, 100)
    assert score.samples == 100
    assert score.notes == ()
