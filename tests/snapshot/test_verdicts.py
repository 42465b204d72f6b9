"""A table of layouts and what must be said of each, whatever the noise draws."""

import numpy as np
import pytest

from robustnav.snapshot import solve_ranges

LINE = np.column_stack([3.0 * np.arange(5), np.zeros(5), np.full(5, 2.0)])
CEILING = np.array([[0.0, 0.0, 3.0], [10.0, 0.0, 3.0], [10.0, 8.0, 3.0], [0.0, 8.0, 3.0]])
BOX = np.array([[x, y, z] for x in (0.0, 10.0) for y in (0.0, 8.0) for z in (0.0, 3.0)])
ROUGH = np.array([[0.01, 0.02, -0.02], [0.02, -0.01, 0.01], [-0.02, 0.0, 0.02], [0.01, 0.01, -0.01]])
SIX = np.vstack([CEILING, [[0.0, 4.0, 3.0], [10.0, 4.0, 3.0]]])
THICK = np.vstack([CEILING, CEILING * [1.0, 1.0, 1.1]])
SQUARE = CEILING[:, :2]
ROW = np.column_stack([3.0 * np.arange(4), np.zeros(4)])
TAG, UNDER = [3.0, 4.0, 1.2], [3.0, 4.0, -1.0]

# name: anchors, tag, sd, verdicts for ranges, for differences, for ranges with the height known to 0.05 m
TABLE = {
    "room": (BOX, TAG, 0.1, "unique", "unique", "unique"),
    "room, four anchors": (BOX[[0, 3, 5, 6]], TAG, 0.05, "unique", "any", "unique"),
    "coplanar": (CEILING, TAG, 0.05, "ambiguous", "degenerate", "unique"),
    "coplanar, differences resolve height": (SIX, UNDER, 0.01, "ambiguous", "ambiguous", "unique"),
    "coplanar, tag in the plane": (CEILING, [3, 4, 3.0], 0.1, "degenerate", "degenerate", "unique"),
    "coplanar, tag near the plane": (CEILING, [3, 4, 2.8], 0.1, "degenerate", "degenerate", "unique"),
    "nearly coplanar": (CEILING + ROUGH, TAG, 0.05, "ambiguous", "degenerate", "unique"),
    "coplanar but for 0.3 m, mirror lost in noise": (THICK, UNDER, 0.4, "not unique", "degenerate", "unique"),
    "coplanar but for 0.3 m, mirror resolved": (THICK, UNDER, 0.01, "unique", "not sure", "unique"),
    "three anchors": (CEILING[:3], UNDER, 0.02, "ambiguous", "too few", "unique"),
    "two anchors": (CEILING[:2], TAG, 0.1, "too few", "too few", "ambiguous"),
    "one anchor": (CEILING[:1], TAG, 0.1, "too few", "too few", "too few"),
    "collinear": (LINE, TAG, 0.1, "degenerate", "degenerate", "ambiguous"),
    "nearly collinear": (LINE + 0.02 * BOX[:5, [1, 2, 0]] % 0.05, TAG, 0.1, "degenerate", "degenerate", "not unique"),
    "coincident": (np.tile(LINE[:1], (6, 1)), TAG, 0.1, "degenerate", "degenerate", "degenerate"),
    "two places, twice each": (np.vstack([CEILING[:2]] * 2), TAG, 0.1, "degenerate", "degenerate", "ambiguous"),
    "far away": (BOX, [900.0, 120.0, 1.2], 0.1, "degenerate", "degenerate", "degenerate"),
    "on an anchor": (BOX, BOX[0], 0.1, "not wrong", "not wrong", "not wrong"),
    "flat square": (SQUARE, [3.0, 4.0], 0.1, "unique", "unique", None),
    "flat, behind an anchor": (SQUARE, [-9.0, -7.2], 0.1, "unique", "not sure", None),
    "flat, in a row": (ROW, [3.0, 4.0], 0.1, "ambiguous", "ambiguous", None),
    "flat, in a row, tag on it": (ROW, [4.0, 0.0], 0.1, "degenerate", "degenerate", None),
    "flat, two anchors": (ROW[:2], [3.0, 4.0], 0.1, "ambiguous", "too few", None),
    "flat, far away": (SQUARE, [600.0, 4.0], 0.1, "degenerate", "degenerate", None),
    "flat, coincident": (np.tile(SQUARE[:1], (5, 1)), [3.0, 4.0], 0.1, "degenerate", "degenerate", None),
}
ALLOWED = {
    "any": {"unique", "ambiguous", "degenerate"},
    "not unique": {"ambiguous", "degenerate"},
    "not sure": {"unique", "degenerate"},
    "not wrong": {"unique", "degenerate"},
}
MODES = {"ranges": (3, "ranges", None), "differences": (4, "differences", None), "height": (5, "ranges", 0.05)}
DRAWS = 5
CASES = [(name, mode) for name, row in TABLE.items() for mode, (column, _, _) in MODES.items() if row[column]]


@pytest.mark.parametrize(("name", "mode"), CASES)
def test_layout_gets_its_verdict(scene, name, mode):
    anchors, tag, sd = TABLE[name][:3]
    column, kind, height_sd = MODES[mode]
    wanted = TABLE[name][column]
    rng = np.random.default_rng(7)
    for _ in range(DRAWS):
        s = scene(anchors, np.array(tag, float), sd, kind, height_sd).measure(rng)
        assert s.verdict in ALLOWED.get(wanted, {wanted}), s.reason
        assert (s.verdict == "too few") == np.isnan(s.position).any()
        if s.verdict == "degenerate":
            assert np.linalg.norm(s.weak.direction) == pytest.approx(1.0)
            assert "Not observable along" in s.reason
            v = s.weak.direction
            assert np.isnan(s.covariance).any() or v @ s.covariance @ v >= 0.999 * s.weak.sd**2
        if s.verdict == "unique":
            assert s.poor == ("(poor)" in s.reason)
            assert np.linalg.norm(s.position - tag) < 5 * np.sqrt(np.trace(s.covariance))


def test_mirror_images_are_both_given_and_their_plane_is_named(scene, ceiling):
    s = scene(ceiling, np.array([3.0, 4.0, 1.0]), 0.02).measure(np.random.default_rng(1))
    (other,) = s.alternatives
    below, above = sorted([s.position, other.position], key=lambda p: p[2])
    assert below == pytest.approx([3, 4, 1], abs=0.2)
    assert above == pytest.approx(below * [1, 1, -1] + [0, 0, 6], abs=1e-3)
    assert abs(s.plane.normal[2]) == pytest.approx(1.0, abs=1e-6)
    assert s.plane.point[2] == pytest.approx(3.0, abs=1e-6)
    assert s.plane.distance < 1e-6
    assert "mirror images" in s.reason


@pytest.mark.parametrize("kind", ["ranges", "differences"])
def test_far_tag_is_open_across_or_along_the_line_of_sight(scene, kind):
    s = scene(SQUARE, np.array([400.0, 4.0]), 0.1, kind).measure(np.random.default_rng(2))
    along = abs(s.weak.direction[0])  # ranges leave the bearing open, differences the distance
    assert along < 0.1 if kind == "ranges" else along > 0.9
    assert s.weak.sd > 1.0


def test_direction_left_open_by_a_row_of_anchors_is_around_it(scene):
    s = scene(LINE, np.array(TAG), 0.02).measure(np.random.default_rng(3))
    radial = s.position - [s.position[0], 0.0, 2.0]
    assert s.weak.direction @ radial == pytest.approx(0.0, abs=0.05 * np.linalg.norm(radial))
    assert abs(s.weak.direction[0]) < 0.05
    assert 0.1 * np.linalg.norm(radial) < s.weak.sd < np.linalg.norm(radial)


def test_open_height_has_the_sd_that_the_plane_allows(scene, ceiling):
    """In the plane of the anchors a height h changes ranges by h^2 / 2 r only."""
    sd = 0.05
    s = scene(ceiling, np.array([5.0, 4.0, 3.0]), sd).measure(np.random.default_rng(4))
    r = np.hypot(5.0, 4.0)
    bound = np.sqrt(2 * r * 3.3 * sd)  # where four ranges together are 6.6 sd off
    assert abs(s.weak.direction[2]) > 0.99
    assert 0.3 * bound < s.weak.sd * np.sqrt(10.83) < 3 * bound
    assert abs(s.position[2] - 3.0) < 5 * s.weak.sd


def test_a_rival_in_the_far_field_leaves_no_ellipsoid_and_no_warning():
    rig = np.array([(2.5775, -0.87, -1.97), (2.5775, 0.87, -1.97), (2.5775, 0.87, -0.5), (0.69, -0.87, -0.5)])
    fix = solve_ranges(rig, [8.192490333, 9.017993333, 8.861648333, np.nan], 0.15)
    assert fix.verdict == "degenerate"
