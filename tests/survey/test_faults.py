"""Ranges that do not fit are named, and what is left is right."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.survey import Frame, Known, Measured, Options, TagRanges, survey_anchors
from robustnav.survey.build import build
from robustnav.survey.faults import standardised
from robustnav.survey.network import descend, residuals
from robustnav.survey.starts import to_frame

SD = 0.02


def plane(count=6):
    rng = np.random.default_rng(8)
    return to_frame(rng.uniform(-6, 6, (count, 3)) * [1, 1, 0], (0, 1, 2), True)


def heights(count=6):
    return Known(np.column_stack([np.full((count, 2), np.nan), np.zeros(count)]))


@pytest.mark.parametrize("row", [4, 9])
def test_one_wrong_link_of_many_is_named_alone(row, links):
    p, rng = plane(), np.random.default_rng(row)
    found = survey_anchors(Measured(tuple("ABCDEF"), links(p, SD, rng, faults={row: 0.6})), heights())
    assert (found.verdict, found.geometry, found.isolated) == ("inconsistent", "unique", True)
    assert [s.row for s in found.suspects] == [row] and found.suspects[0].kind == "link"
    assert found.suspects[0].error == pytest.approx(0.6, abs=0.15)
    assert np.abs(found.p_a - p).max() < 0.12


def test_with_one_range_to_spare_any_may_be_wrong(links, hall):
    pairs = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (0, 4), (1, 4), (2, 4), (3, 4)]
    rng = np.random.default_rng(1)
    measured = Measured(tuple("ABCDE"), links(hall[:5], SD, rng, pairs=pairs, faults={3: 1.0}))
    found = survey_anchors(measured)
    assert found.verdict == "inconsistent" and not found.isolated


def test_two_faults_that_one_range_left_out_does_not_mend(links):
    p, rng = plane(), np.random.default_rng(3)
    wrong = {2: 1.2, 11: -0.9}
    found = survey_anchors(Measured(tuple("ABCDEF"), links(p, SD, rng, faults=wrong)), heights())
    assert {s.row for s in found.suspects} == set(wrong)
    assert np.abs(found.p_a - p).max() < 0.15


@pytest.mark.parametrize("loss", ["student", "huber"])
def test_late_ranges_to_a_tag_are_left_out(loss, hall, tag):
    rng = np.random.default_rng(6)
    ranges = tag(hall, 0.05, rng, seconds=13.0, every=0.3, apart=0.04)
    late = rng.random(len(ranges.t)) < 0.06
    measured = TagRanges(ranges.t, ranges.anchor, ranges.distance + late * rng.uniform(0.6, 2.5, late.size), ranges.sd)
    known = Known(np.where(np.arange(6)[:, None] < 5, hall, np.nan))
    options = Options(loss=loss, knot_s=0.25, acceleration_sd=2.0)
    found = survey_anchors(Measured(tuple("ABCDEF"), tag=measured), known, options=options)
    named = {s.row for s in found.suspects}
    assert found.verdict == "inconsistent" and found.geometry == "unique"
    assert len(named & set(np.flatnonzero(late))) > 0.9 * late.sum()
    assert len(named - set(np.flatnonzero(late))) < 0.02 * late.size
    assert (np.abs(found.p_a - hall)[5] < 4 * found.sd[5]).all()
    assert "tag at" in found.suspects[0].ends


def test_residuals_are_counted_in_sds_of_their_own(hall, tag, tag_path):
    rng = np.random.default_rng(12)
    known = Known(np.where(np.arange(6)[:, None] < 5, hall, np.nan))
    task = build(Measured(tuple("ABCDEF"), tag=tag(hall, 0.02, rng, every=0.1)), known, Frame(), Options())
    network = task.network
    start = np.vstack([hall, tag_path(np.unique(np.arange(0.0, 12.0, 0.1)))])
    p = descend(start, network).p
    raw = residuals(p, network)[0] * np.sqrt(network.info)
    assert np.std(standardised(p, network, network)) == pytest.approx(1.0, abs=0.06)
    assert np.std(raw) < 0.8  # three of six ranges place the tag
    # one left out is judged with the doubt of the place as well
    out = np.arange(len(raw)) % 6 == 0
    rest = replace(network, info=np.where(out, 0.0, network.info))
    q = descend(start, rest).p
    assert np.std(standardised(q, network, rest)[out]) == pytest.approx(1.0, abs=0.2)
    assert np.std((residuals(q, network)[0] * np.sqrt(network.info))[out]) > 1.2
