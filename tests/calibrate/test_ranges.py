"""Corrections by anchor and by link: each link gets its own, and none gets another's."""

import numpy as np
import pytest

from robustnav.calibrate import LEAST_SQUARES, BiasCurve, Pairs, RangeCalibration, RangeLine, calibrate_ranges, fit_line
from robustnav.errors import InputError
from robustnav.records import Anchors, Ranges

SLOPE = np.array([[1.01, 0.99], [1.0, 1.02], [0.98, 1.005]])  # by anchor and tag
OFFSET = np.array([[0.1, -0.1], [0.3, 0.2], [-0.4, 0.5]])
ANCHORS = Anchors(("A", "B", "C"), np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, -2]]))


@pytest.fixture
def recording():
    """Return ranges of three anchors and two tags, and their true distances."""
    rng = np.random.default_rng(1)
    anchor, tag, d = rng.integers(0, 3, 1200), rng.integers(0, 2, 1200), rng.uniform(1, 20, 1200)
    r = SLOPE[anchor, tag] * d + OFFSET[anchor, tag] + 0.01 * rng.standard_normal(1200)
    return Ranges(np.arange(1200) * 0.1, anchor, tag, r, ANCHORS, ("0", "1")), d


def test_every_link_is_corrected_by_its_own_line(recording):
    ranges, d = recording
    found = calibrate_ranges(Pairs.of(ranges, d), "link", source="made")
    assert set(found.corrections) == {(a, t) for a in "ABC" for t in "01"}
    np.testing.assert_allclose(found.corrections["B", "1"].slope, 1.02, atol=0.002)
    fixed = found.apply(ranges)
    assert np.abs(fixed.distance - d).max() < 0.05
    np.testing.assert_allclose(np.sqrt(fixed.variance), 0.01, rtol=0.3)
    np.testing.assert_array_equal(fixed.anchor, ranges.anchor)
    order = np.random.default_rng(2).permutation(1200)
    assert calibrate_ranges(Pairs.of(ranges, d).where(order), "link").corrections.keys() == found.corrections.keys()


def test_groups_are_the_fits_of_their_pairs(recording):
    ranges, d = recording
    pairs = Pairs.of(ranges, d)
    everything = calibrate_ranges(pairs, fit=lambda p: fit_line(p, LEAST_SQUARES))
    assert everything.corrections[()] == fit_line(pairs, LEAST_SQUARES)
    of_b = calibrate_ranges(pairs, "anchor").corrections[("B",)]
    assert of_b == fit_line(pairs.where(ranges.anchor == 1))


def test_a_link_without_a_correction_stops_everything(recording):
    ranges, _ = recording
    one = RangeCalibration(
        "anchor", {("A",): RangeLine(1.0, 0.1, 0.01), ("B",): BiasCurve((1.0, 2.0), (0.1, 0.1), 0.01)}
    )
    with pytest.raises(InputError, match=r"no correction for C(.|\n)*A, B"):
        one.apply(ranges)
    kept = one.apply(ranges.where(ranges.anchor < 2))
    np.testing.assert_allclose(kept.distance, ranges.distance[ranges.anchor < 2] - 0.1)
    assert len(one.apply(ranges.where(np.zeros(1200, bool)))) == 0


def test_a_refused_group_is_named(recording):
    ranges, d = recording
    flat = np.where(ranges.anchor == 2, 5.0, d)
    with pytest.raises(InputError, match=r"C-0(.|\n)*1 distances"):
        calibrate_ranges(Pairs.of(ranges, flat), "link")
    with pytest.raises(InputError, match="by 'tag'"):
        calibrate_ranges(Pairs.of(ranges, d), "tag")
    with pytest.raises(InputError, match="without anchor"):
        calibrate_ranges(Pairs(d, ranges.distance), "anchor")
    with pytest.raises(InputError, match="key"):
        RangeCalibration("link", {("A",): RangeLine(1.0, 0.0, 0.1)})
    with pytest.raises(InputError, match="no correction"):
        RangeCalibration("all", {})
