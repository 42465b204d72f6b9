import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.report.decimate import MAX_POINTS, decimate


def test_short_traces_stay_as_they_are():
    t = np.arange(float(MAX_POINTS))
    assert decimate(t, t)[2] is False


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 3]), st.integers(50, 3000), st.sampled_from([0.0, 0.3, 1.0]))
def test_points_come_from_the_trace_in_order_with_ends_and_extremes(seed, columns, n, missing):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.integers(0, 3, n)).astype(float)
    values = rng.normal(size=(n, columns)) ** 3
    values[rng.random(values.shape) < missing] = np.nan
    got_t, got, fewer = decimate(t, values, points=40)
    assert fewer and len(got_t) <= 40 and (np.diff(got_t) >= 0).all()
    assert (got_t[0], got_t[-1]) == (t[0], t[-1])
    rows = {row.tobytes() for row in np.column_stack([t, values])}
    assert all(row.tobytes() in rows for row in np.column_stack([got_t, got]))
    for k in range(columns):
        if np.isfinite(values[:, k]).any():
            assert np.nanmax(got[:, k]) == np.nanmax(values[:, k])
            assert np.nanmin(got[:, k]) == np.nanmin(values[:, k])


def test_every_spike_and_every_hole_stays():
    t = np.arange(100_000.0)
    values = np.zeros(100_000)
    spikes = np.arange(50, 100_000, 1000)
    values[spikes] = 1.0
    values[40_000:41_000] = np.nan
    got_t, got, _ = decimate(t, values)
    shown = spikes[(spikes < 40_000) | (spikes >= 41_000)]
    assert set(shown) <= set(got_t[got == 1.0])
    hole = got[(got_t >= 40_200) & (got_t < 40_800)]
    assert hole.size and np.isnan(hole).all()
    assert len(got_t) <= MAX_POINTS


@pytest.mark.parametrize("t", [np.zeros(5000), np.r_[np.zeros(4999), 1.0]])
def test_repeated_times_are_no_trouble(t):
    values = np.arange(5000.0)
    assert decimate(t, values)[1].max() == 4999
