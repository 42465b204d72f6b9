"""Solutions: invariances, covariance, missing readings, bad input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from robustnav.errors import InputError
from robustnav.snapshot import Height, Options, dop_at, solve_differences, solve_ranges

SEEDS = st.integers(0, 2**32 - 1)
KINDS = pytest.mark.parametrize("kind", ["ranges", "differences"])


def solve(kind, anchors, r, sd, **more):
    if kind == "differences":
        return solve_differences(anchors, r[1:] - r[0], sd, **more)
    return solve_ranges(anchors, r, sd, **more)


def drawn(seed, d=None):
    rng = np.random.default_rng(seed)
    d = d or int(rng.integers(2, 4))
    anchors = rng.uniform(-5, 5, (int(rng.integers(d + 2, 9)), d))
    tag = rng.uniform(-4, 4, d)
    r = np.linalg.norm(anchors - tag, axis=1) + 0.05 * rng.normal(size=len(anchors))
    return rng, anchors, tag, r


@KINDS
@settings(max_examples=40)
@given(seed=SEEDS)
def test_frame_and_order_do_not_matter(kind, seed):
    rng, anchors, _, r = drawn(seed)
    d = anchors.shape[1]
    one = solve(kind, anchors, r, 0.05)
    turn = np.linalg.qr(rng.normal(size=(d, d)))[0]
    shift = 1e4 * rng.normal(size=d)
    order = rng.permutation(len(r))  # for differences another reference as well
    two = solve(kind, (anchors @ turn.T + shift)[order], r[order], 0.05)
    if one.verdict == "degenerate" or one.dop.gdop > 15:
        return  # near a threshold, rounding may decide
    assert two.verdict == one.verdict
    assert two.cost == pytest.approx(one.cost, rel=1e-4, abs=1e-5)
    if one.verdict == "unique":
        sd = np.sqrt(np.trace(one.covariance))
        assert (two.position - shift) @ turn == pytest.approx(one.position, abs=1e-3 * sd)
        assert turn.T @ two.covariance @ turn == pytest.approx(one.covariance, abs=1e-3 * sd**2)
        assert two.unseen_shift == pytest.approx(one.unseen_shift, rel=1e-3)


@KINDS
def test_scale_of_the_unit_does_not_matter(kind, box):
    rng = np.random.default_rng(8)
    r = np.linalg.norm(box - [3, 4, 1.2], axis=1) + 0.1 * rng.normal(size=8)
    m, mm = solve(kind, box, r, 0.1), solve(kind, 1e3 * box, 1e3 * r, 100.0)
    assert mm.position == pytest.approx(1e3 * m.position, rel=1e-6)
    assert mm.verdict == m.verdict == "unique"


@KINDS
@pytest.mark.parametrize("height_sd", [None, 0.05])
def test_errors_are_as_large_as_the_covariance_says(kind, height_sd, scene, box):
    rng = np.random.default_rng(9)
    tag, n = np.array([3.0, 4.0, 1.2]), 150
    runs = [scene(box, tag, 0.02, kind, height_sd).measure(rng) for _ in range(n)]
    good = [s for s in runs if s.verdict == "unique"]
    assert len(good) >= n - 3  # one in a thousand fails the residual test
    nees = sum((s.position - tag) @ np.linalg.solve(s.covariance, s.position - tag) for s in good)
    low, high = chi2.ppf([0.001, 0.999], 3 * len(good))
    assert low < nees < high
    low, high = chi2.ppf([0.001, 0.999], good[0].dof * len(good))
    assert low < sum(s.cost for s in good) < high


def test_covariance_is_the_dilution_of_precision_times_the_noise(box):
    tag = np.array([3.0, 4.0, 1.2])
    r = np.linalg.norm(box - tag, axis=1)
    s = solve_ranges(box, r, 0.01)
    assert s.position == pytest.approx(tag, abs=1e-6)
    assert np.sqrt(np.trace(s.covariance)) == pytest.approx(0.01 * s.dop.gdop, rel=1e-6)
    assert s.dop.gdop == pytest.approx(dop_at(box, tag[None]).gdop[0], rel=1e-6)
    assert s.sd[2] == pytest.approx(0.01 * s.dop.vdop, rel=1e-6)
    assert np.hypot(*s.sd[:2]) == pytest.approx(0.01 * s.dop.hdop, rel=1e-6)
    assert s.weak.sd**2 == pytest.approx(np.linalg.eigvalsh(s.covariance)[-1])


def test_known_height_to_no_use_is_no_height(box):
    r = np.linalg.norm(box - [3, 4, 1.2], axis=1) + 0.02 * np.random.default_rng(2).normal(size=8)
    free, vague = solve_ranges(box, r, 0.02), solve_ranges(box, r, 0.02, Height(0.0, 1e4))
    assert vague.position == pytest.approx(free.position, abs=1e-5)
    assert vague.covariance == pytest.approx(free.covariance, rel=1e-5, abs=1e-9)
    assert np.isnan(vague.dop.vdop)


@KINDS
def test_missing_readings_are_readings_never_taken(kind, box):
    rng = np.random.default_rng(3)
    r = np.linalg.norm(box - [3, 4, 1.2], axis=1) + 0.05 * rng.normal(size=8)
    holes = r.copy()
    holes[[2, 6]] = np.nan
    keep = ~np.isnan(holes)
    with_holes, without = solve(kind, box, holes, 0.05), solve(kind, box[keep], r[keep], 0.05)
    assert with_holes.position == pytest.approx(without.position)
    assert with_holes.used.tolist() == keep.tolist()
    missing = np.isnan(with_holes.residuals)
    assert np.flatnonzero(missing).tolist() == ([2, 6] if kind == "ranges" else [1, 5])
    assert with_holes.residuals[~missing] == pytest.approx(without.residuals)


@KINDS
def test_nothing_heard_is_too_few(kind, box):
    s = solve(kind, box, np.full(8, np.nan), 0.05)
    assert s.verdict == "too few"
    assert not s.used.any()


def test_larger_sd_counts_less(box):
    rng = np.random.default_rng(4)
    r = np.linalg.norm(box - [3, 4, 1.2], axis=1) + 0.02 * rng.normal(size=8)
    r[0] += 0.5
    sd = np.full(8, 0.02)
    sd[0] = 100.0
    s, rest = solve_ranges(box, r, sd), solve_ranges(box[1:], r[1:], 0.02)
    assert s.position == pytest.approx(rest.position, abs=1e-5)
    correlated = np.diag(sd**2)
    assert solve_ranges(box, r, correlated).position == pytest.approx(s.position, abs=1e-7)


def test_reason_says_when_nothing_tests_the_fix():
    anchors = np.array([[0.0, 0.0], [10.0, 0.0], [3.0, 9.0]])
    s = solve_ranges(anchors, np.linalg.norm(anchors - [4.0, 3.0], axis=1), 0.05)
    assert (s.verdict, s.dof) == ("unique", 1)
    d = solve_differences(anchors, np.diff(np.linalg.norm(anchors - [4.0, 3.0], axis=1)).cumsum(), 0.02)
    assert d.dof == 0
    assert d.unseen_shift == np.inf
    assert "would not show" in d.reason


ROOM = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 3.0]])
BAD = {
    "anchors of the wrong shape": (lambda: solve_ranges([1.0, 2.0], [1.0, 1.0], 0.1), "anchors"),
    "anchors in 4D": (lambda: solve_ranges(np.ones((3, 4)), np.ones(3), 0.1), "anchors"),
    "no anchors": (lambda: solve_ranges(np.ones((0, 3)), [], 0.1), "anchors"),
    "anchor not finite": (lambda: solve_ranges([[0.0, np.nan], [1, 1]], [1, 1], 0.1), "row 0"),
    "too many ranges": (lambda: solve_ranges(ROOM, np.ones(5), 0.1), "ranges"),
    "range infinite": (lambda: solve_ranges(ROOM, [1, np.inf, 1, 1], 0.1), "row 1"),
    "no noise": (lambda: solve_ranges(ROOM, np.ones(4), 0.0), "noise"),
    "noise missing where used": (lambda: solve_ranges(ROOM, np.ones(4), [0.1, np.nan, 1, 1]), "row 1"),
    "noise of another shape": (lambda: solve_ranges(ROOM, np.ones(4), [0.1, 0.1]), "noise"),
    "covariance not positive": (lambda: solve_ranges(ROOM, np.ones(4), np.ones((4, 4))), "covariance"),
    "covariance not symmetric": (lambda: solve_ranges(ROOM, np.ones(4), np.triu(np.ones((4, 4)))), "covariance"),
    "a difference too many": (lambda: solve_differences(ROOM, np.ones(4), 0.1), "range differences"),
    "covariance of differences": (lambda: solve_differences(ROOM, np.ones(3), np.eye(4)), "noise"),
    "height in 2D": (lambda: solve_ranges(ROOM[:, :2], np.ones(4), 0.1, Height(1.0, 0.1)), "height"),
    "height without sd": (lambda: solve_ranges(ROOM, np.ones(4), 0.1, Height(1.0, 0.0)), "height"),
    "height missing": (lambda: solve_ranges(ROOM, np.ones(4), 0.1, Height(np.nan, 0.1)), "height"),
    "confidence of one": (lambda: Options(confidence=1.0), "confidence"),
    "no GDOP allowed": (lambda: Options(max_gdop=0.0), "max_gdop"),
    "unknown repair": (lambda: Options(repair="hope"), "repair"),
    "negative faults": (lambda: Options(max_faults=-1), "max_faults"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_named(name):
    call, named = BAD[name]
    with pytest.raises(InputError, match=named):
        call()


@settings(max_examples=60)
@given(
    d=st.integers(2, 3),
    kind=st.sampled_from(["ranges", "differences"]),
    data=st.data(),
)
def test_any_readings_get_a_verdict_and_no_warning(d, kind, data):
    number = st.floats(-1e3, 1e3, allow_subnormal=False)
    k = data.draw(st.integers(1, 6))
    anchors = np.array(data.draw(st.lists(st.lists(number, min_size=d, max_size=d), min_size=k, max_size=k)))
    r = np.array(data.draw(st.lists(number | st.just(np.nan), min_size=k, max_size=k)))
    s = solve(kind, anchors, r, data.draw(st.floats(1e-3, 10.0)))
    assert s.verdict in {"unique", "ambiguous", "degenerate", "inconsistent", "too few"}
    assert s.reason.endswith(".")
    if s.verdict == "unique":
        assert np.linalg.eigvalsh(s.covariance)[0] > 0
        assert s.cost <= 30
