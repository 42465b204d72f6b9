"""Verdicts on layouts: good ones, and every way of being bad."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.logs.uwb_survey import read_survey
from robustnav.records import Anchors
from robustnav.survey import Frame, Known, Links, Measured, Options, TagRanges, survey_anchors, write_anchors
from robustnav.survey.starts import to_frame

IDS = tuple("ABCDEF")
SD = 0.02


def level(z, count=6):
    return Known(np.column_stack([np.full((count, 2), np.nan), np.full(count, z)]))


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def test_exact_ranges_give_the_layout_back(hall, links):
    found = survey_anchors(Measured(IDS, links(hall, SD)), frame=Frame(side=("E", "-z")))
    assert found.verdict == "unique"
    np.testing.assert_allclose(found.p_a, hall, atol=1e-6)
    np.testing.assert_allclose(found.link_residuals, 0, atol=1e-6)
    assert found.dof == 15 - 12


def test_ranges_alone_cannot_tell_a_layout_from_its_mirror_image(hall, links):
    found = survey_anchors(Measured(IDS, links(hall, SD)))
    assert found.verdict == "ambiguous" and len(found.alternatives) == 1
    both = [found.p_a, found.alternatives[0].p_a]
    np.testing.assert_allclose(both[0], both[1] * [1, 1, -1], atol=1e-9)
    assert min(np.abs(p - hall).max() for p in both) < 1e-6
    assert "mirror image" in found.reason


def test_known_heights_make_it_plane(hall, links):
    flat = to_frame(hall * [1, 1, 0] + [0, 0, -2], (0, 1, 2), True)
    found = survey_anchors(Measured(IDS, links(flat, SD)), level(-2.0))
    assert found.verdict == "unique"
    np.testing.assert_allclose(found.p_a, flat, atol=1e-6)


def test_one_plane_without_heights_is_degenerate_across_it(hall, links, rng):
    found = survey_anchors(Measured(IDS, links(hall * [1, 1, 0], SD, rng)))
    assert found.verdict == "degenerate"
    assert abs(found.weak.direction[2]) > 0.8 and found.weak.anchor in "DEF"


def test_a_row_is_degenerate(links, rng):
    row = np.column_stack([np.arange(6) * 3.0, np.zeros((6, 2))])
    assert survey_anchors(Measured(IDS, links(row, SD, rng))).verdict == "degenerate"
    assert survey_anchors(Measured(IDS, links(row, SD, rng)), level(0.0)).verdict == "degenerate"


def test_an_anchor_with_too_few_ranges_is_named_with_its_direction(hall, links, rng):
    pairs = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (0, 4), (1, 4), (2, 4), (3, 4), (2, 5)]
    found = survey_anchors(Measured(IDS, links(hall * [1, 1, 0], SD, rng, pairs=pairs)), level(0.0))
    assert found.verdict == "degenerate" and found.weak.moving == ("F",) and found.weak.sd == np.inf
    away = found.p_a[5] - found.p_a[2]
    assert abs(found.weak.direction @ away) < 0.1 * np.linalg.norm(away)


def test_two_ranges_in_a_plane_leave_two_places_and_both_are_given(hall, links, rng):
    flat = to_frame(hall * [1, 1, 0], (0, 1, 2), True)
    pairs = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (0, 4), (1, 4), (2, 4), (3, 4), (2, 5), (4, 5)]
    found = survey_anchors(Measured(IDS, links(flat, SD, rng, pairs=pairs)), level(0.0))
    assert found.verdict == "ambiguous" and len(found.alternatives) == 1
    assert min(np.abs(p - flat).max() for p in (found.p_a, found.alternatives[0].p_a)) < 0.2
    assert np.abs(found.p_a - found.alternatives[0].p_a)[:5].max() < 0.05
    assert "F at" in found.reason


def test_parts_without_a_chain_of_ranges_are_named(hall, links):
    pairs = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5)]
    found = survey_anchors(Measured(IDS, links(hall, SD, pairs=pairs)))
    assert found.verdict == "degenerate" and np.isnan(found.p_a).all()
    assert "D, E, F" in found.reason
    with pytest.raises(InputError, match="anchors p_a"):
        found.anchors()


def test_known_anchors_in_a_plane_mirror_the_others_together_or_apart(hall, links, rng):
    known = hall.copy()
    known[3:] = np.nan
    found = survey_anchors(Measured(IDS, links(hall, SD, rng)), Known(known))
    assert found.verdict == "ambiguous"
    assert min(np.abs(p - hall).max() for p in (found.p_a, *(a.p_a for a in found.alternatives))) < 0.3
    known[3] = hall[3]
    assert survey_anchors(Measured(IDS, links(hall, SD, rng)), Known(known)).verdict == "unique"


def test_known_positions_may_have_an_sd_and_then_move(hall, links):
    rng = np.random.default_rng(2)
    off = hall + 0.1 * rng.standard_normal(hall.shape)
    loose = survey_anchors(Measured(IDS, links(hall, 0.001)), Known(off, np.full((6, 3), 0.1)))
    firm = survey_anchors(Measured(IDS, links(hall, 0.5)), Known(off, np.full((6, 3), 0.001)))
    shape = np.linalg.norm(loose.p_a[:, None] - loose.p_a, axis=2) - np.linalg.norm(hall[:, None] - hall, axis=2)
    assert np.abs(shape).max() < 0.005
    np.testing.assert_allclose(firm.p_a, off, atol=0.001)
    assert (loose.sd > 0).all() and loose.anchors().sd is not None


def test_an_anchor_too_near_the_plane_tells_no_side(hall, links, rng):
    flat = hall * [1, 1, 0.0]
    flat[4, 2] = -3.0
    found = survey_anchors(Measured(IDS, links(flat, SD, rng)), frame=Frame(side=("D", "+z")))
    assert found.verdict in ("ambiguous", "degenerate")
    assert found.verdict == "degenerate" or len(found.alternatives) == 1


def test_too_small_an_sd_is_a_contradiction_that_names_no_single_range(hall, tag):
    ranges = tag(hall, 0.1, np.random.default_rng(4), seconds=5.0)
    known = Known(np.where(np.arange(6)[:, None] < 5, hall, np.nan))
    boast = TagRanges(ranges.t, ranges.anchor, ranges.distance, ranges.sd / 3)
    found = survey_anchors(Measured(IDS, tag=boast), known)
    assert found.verdict == "inconsistent" and found.geometry == "unique"
    assert found.scale == pytest.approx(3.0, rel=0.2)
    assert np.abs(found.p_a - hall).max() < 4 * found.sd.max()
    honest = survey_anchors(Measured(IDS, tag=ranges), known)
    np.testing.assert_allclose(found.sd[5], honest.sd[5], rtol=0.5)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: survey_anchors(m, Known(np.full((5, 3), np.nan))), "6 anchors"),
        (lambda m: survey_anchors(m, Known(np.zeros((6, 3)))), "known exactly"),
        (lambda m: survey_anchors(m, Known(np.full((6, 3), np.nan), tag_z=-1.0)), "height of the tag"),
        (lambda m: survey_anchors(m, frame=Frame(("A", "B", "X"))), "three of A, B, C"),
        (lambda m: survey_anchors(m, frame=Frame(("A", "A", "B"))), "three of A, B, C"),
        (lambda m: survey_anchors(m, frame=Frame(side=("A", "+z"))), "another anchor"),
        (lambda m: survey_anchors(m, level(0.0), Frame(side=("E", "+z"))), "another anchor"),
        (lambda m: survey_anchors(m, frame=Frame(side=("E", "up"))), r"\+z or -z"),
        (lambda m: Measured(IDS), "no range"),
        (lambda m: Measured(("A", "A"), m.links), "twice"),
        (lambda m: Measured(("A", "B"), m.links), "0 to 1"),
        (lambda m: Links([0], [0], [1.0], [0.1]), "one anchor at both ends"),
        (lambda m: Links([0], [1], [np.nan], [0.1]), "row 0"),
        (lambda m: Links([0], [1], [1.0], [0.0]), "links sd"),
        (lambda m: Links([0, 1], [1], [1.0], [0.1]), "shape"),
        (lambda m: TagRanges([1.0, 0.0], [0, 0], [1.0, 1.0], [0.1, 0.1]), "backwards"),
        (lambda m: Known(np.zeros((6, 2))), r"\(k, 3\)"),
        (lambda m: Known(np.zeros((6, 3)), np.zeros((6, 3))), "above 0"),
        (lambda m: Options(loss="cauchy"), "student or huber"),
        (lambda m: Options(knot_s=0.0), "knot_s"),
        (lambda m: survey_anchors(Measured(IDS, tag=TagRanges([0.0], [0], [1.0], [0.1]))), "four ranges of one stamp"),
    ],
)
def test_bad_input_is_refused(change, words, hall, links):
    with pytest.raises(InputError, match=words):
        change(Measured(IDS, links(hall, SD)))


def test_the_file_is_read_back_bit_for_bit(tmp_path, hall):
    anchors = Anchors(("A", 'b "c"', "ü"), hall[:3] / 3, np.full((3, 3), 0.01))
    back, tags, lever = read_survey(write_anchors(anchors, tmp_path / "a.toml", ("made up",)))
    np.testing.assert_array_equal(back.p_a, anchors.p_a)
    np.testing.assert_allclose(back.sd, anchors.sd)
    assert (back.ids, tags, lever) == (anchors.ids, ("tag",), None)
    assert read_survey(write_anchors(Anchors(("A",), hall[:1]), tmp_path / "b.toml"))[0].sd is None
