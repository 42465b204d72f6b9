"""Anchors from a moving tag: with and without known ones, free and smooth tracks."""

import numpy as np
import pytest

from robustnav.survey import Known, Measured, Options, survey_anchors

IDS = tuple("ABCDEF")


def some_known(hall, count=4):
    return Known(np.where(np.arange(6)[:, None] < count, hall, np.nan))


@pytest.mark.parametrize("options", [Options(), Options(knot_s=0.25, acceleration_sd=2.0)], ids=["free", "smooth"])
def test_two_new_anchors_beside_four_known_ones(options, hall, tag):
    apart = 0.0 if options.knot_s is None else 0.04
    ranges = tag(hall, 0.05, np.random.default_rng(0), seconds=16.0, every=0.5, apart=apart)
    found = survey_anchors(Measured(IDS, tag=ranges), some_known(hall), options=options)
    assert found.verdict == "unique"
    e, C = (found.p_a - hall)[4:].ravel(), found.covariance[12:, 12:]
    assert e @ np.linalg.solve(C, e) < 22.5  # chi-square, 6 degrees, 0.999
    assert np.abs(e).max() < 0.6


def test_no_anchor_known_at_all(hall, tag):
    ranges = tag(hall, 0.03, np.random.default_rng(1), seconds=14.0, every=0.5)
    found = survey_anchors(Measured(IDS, tag=ranges))
    assert found.verdict == "ambiguous" and len(found.alternatives) == 1
    assert min(np.abs(p - hall).max() for p in (found.p_a, found.alternatives[0].p_a)) < 0.25


def test_a_tag_at_one_height_mirrors_an_anchor_that_only_it_hears(hall, tag):
    ranges = tag(hall, 0.03, np.random.default_rng(2), every=0.4)
    level = np.column_stack([4 + 3 * np.cos(0.5 * ranges.t), 3 + 2.5 * np.sin(0.7 * ranges.t), -np.ones(len(ranges.t))])
    noise = 0.03 * np.random.default_rng(3).standard_normal(len(ranges.t))
    d = np.linalg.norm(level - hall[ranges.anchor], axis=1) + noise
    flat = type(ranges)(ranges.t, ranges.anchor, d, ranges.sd)
    known = some_known(hall, 5)
    found = survey_anchors(Measured(IDS, tag=flat), Known(known.p_a, tag_z=-1.0))
    # F stands half a metre above the tag's level, its image half a metre below
    assert found.verdict in ("ambiguous", "degenerate")
    places = [found.p_a[5], *(a.p_a[5] for a in found.alternatives)]
    assert min(np.linalg.norm(p - hall[5]) for p in places) < 1.0


def test_stamps_with_too_few_ranges_are_left_out_and_said_so(hall, tag):
    ranges = tag(hall, 0.02, np.random.default_rng(4), seconds=14.0, every=0.5)
    short = ~((ranges.t == ranges.t[60]) & (ranges.anchor > 2))
    cut = type(ranges)(ranges.t[short], ranges.anchor[short], ranges.distance[short], ranges.sd[short])
    found = survey_anchors(Measured(IDS, tag=cut), some_known(hall))
    assert np.isnan(found.tag_residuals).sum() == 3
    assert found.verdict == "unique"


def test_links_beside_a_tag_are_worth_something(hall, tag, links):
    rng = np.random.default_rng(5)
    ranges = tag(hall, 0.05, rng, seconds=12.0, every=0.5)
    alone = survey_anchors(Measured(IDS, tag=ranges), some_known(hall))
    more = survey_anchors(
        Measured(IDS, links(hall, 0.05, rng, pairs=[(3, 4), (0, 5), (4, 5)]), ranges), some_known(hall)
    )
    assert more.verdict == "unique"
    assert np.trace(more.covariance) < np.trace(alone.covariance)
