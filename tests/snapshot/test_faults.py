"""Readings that contradict each other: who is named, what is given, what cannot be seen."""

import numpy as np
import pytest

from robustnav.snapshot import Options, solve_differences, solve_ranges

TAG = np.array([3.0, 4.0, 1.2])
KINDS = pytest.mark.parametrize("kind", ["ranges", "differences"])


def solve(kind, anchors, r, sd, options=None):
    if kind == "differences":
        return solve_differences(anchors, r[1:] - r[0], sd, options=options)
    return solve_ranges(anchors, r, sd, options=options)


def measured(anchors, seed, sd=0.05, tag=TAG):
    return np.linalg.norm(anchors - tag, axis=1) + sd * np.random.default_rng(seed).normal(size=len(anchors))


@KINDS
@pytest.mark.parametrize("anchor", range(8))
def test_wrong_anchor_is_named_and_left_out(kind, anchor, box):
    """Also the reference of range differences, whose error is in all of them."""
    r = measured(box, anchor)
    r[anchor] += 1.5
    s = solve(kind, box, r, 0.05)
    assert s.verdict == "inconsistent"
    assert s.isolated
    assert [q.anchor for q in s.suspects] == [anchor]
    assert s.suspects[0].error == pytest.approx(1.5, abs=0.6)
    assert s.suspects[0].sds > 5
    assert np.flatnonzero(~s.used).tolist() == [anchor]
    assert f"anchor {anchor}" in s.reason
    rest = np.delete(np.arange(8), anchor)
    assert s.position == pytest.approx(solve(kind, box[rest], r[rest], 0.05).position, abs=1e-5)


def test_suspects_are_rows_of_the_input(box):
    r = measured(box, 1)
    r[6] -= 2.0
    r[[0, 3]] = np.nan
    s = solve_ranges(box, r, 0.05)
    assert [q.anchor for q in s.suspects] == [6]
    assert np.flatnonzero(s.weights == 0).tolist() == [0, 3, 6]


@KINDS
def test_two_wrong_anchors_are_named(kind, box):
    r = measured(box, 2, sd=0.02)
    r[1] += 1.0
    r[4] += 2.0
    s = solve(kind, box, r, 0.02)
    assert {q.anchor for q in s.suspects} == {1, 4}
    assert s.position == pytest.approx(TAG, abs=0.3)
    one = solve(kind, box, r, 0.02, Options(max_faults=1))
    assert one.verdict == "inconsistent"
    assert not one.isolated


@pytest.mark.parametrize("repair", ["student", "huber"])
@KINDS
def test_reweighting_resists_and_shows_its_weights(kind, repair, box):
    r = measured(box, 3)
    r[5] += 3.0
    plain = solve(kind, box, r, 0.05, Options(max_faults=0))
    s = solve(kind, box, r, 0.05, Options(repair=repair))
    assert s.verdict == "inconsistent"
    assert np.argmin(s.weights) == 5
    assert s.weights[5] < 0.2
    assert np.all((s.weights > 0) & (s.weights <= 1))
    assert np.linalg.norm(s.position - TAG) < 0.4 * np.linalg.norm(plain.position - TAG)


def test_reweighted_position_solves_the_weighted_equations(box):
    """Student-t: sum of w e u = 0 with w = min(1, 5 / (4 + e^2 / sd^2))."""
    r = measured(box, 4)
    r[5] += 3.0
    s = solve_ranges(box, r, 0.05, options=Options(repair="student"))
    away = s.position - box
    d = np.linalg.norm(away, axis=1)
    e = r - d
    w = np.minimum(1.0, 5.0 / (4.0 + (e / 0.05) ** 2))
    assert s.weights == pytest.approx(w, abs=1e-4)
    assert (w * e) @ (away / d[:, None]) == pytest.approx(np.zeros(3), abs=1e-4)


def test_one_reading_to_spare_cannot_tell_who_is_wrong():
    anchors = np.array([[0.0, 0.0], [10.0, 0.0], [3.0, 9.0]])
    r = np.linalg.norm(anchors - [4.0, 3.0], axis=1)
    r[1] += 3.0
    s = solve_ranges(anchors, r, 0.05)
    assert s.verdict == "inconsistent"
    assert s.suspects == ()
    assert not s.isolated
    assert s.used.all()


def test_rival_explanations_are_all_given():
    """With two readings to spare in a square, two wrong ranges look like other single faults."""
    anchors = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0]])
    rng, shared = np.random.default_rng(5), 0
    for _ in range(60):
        r = measured(anchors, int(rng.integers(1e9)), 0.1, np.array([3.0, 4.0]))
        r[int(rng.integers(4))] += 0.9
        s = solve_ranges(anchors, r, 0.1)
        if s.verdict == "inconsistent" and s.suspects and not s.isolated:
            shared += 1
            assert len(s.suspects) == 1 + len(s.alternatives)
            assert "several explanations" in s.reason
    assert shared > 5


def test_ranges_that_cannot_meet_are_inconsistent():
    s = solve_ranges([[0.0, 0.0], [10.0, 0.0]], [3.0, 4.0], 0.1)
    assert s.verdict == "inconsistent"
    far = solve_differences([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0]], [14.0, 0.0, 3.0], 0.1)
    assert far.verdict == "inconsistent"


@KINDS
def test_what_passes_unseen_moves_the_fix_no_further_than_said(kind, box):
    """Noise-free fault of growing size: while the verdict stays unique, the shift stays below ``unseen_shift``."""
    r = np.linalg.norm(box - TAG, axis=1)
    bound = solve(kind, box, r, 0.02).unseen_shift
    largest = 0.0
    for anchor in (0, 1, 6, 7):
        for size in np.linspace(0.0, 0.3, 11):
            s = solve(kind, box, r + size * (np.arange(8) == anchor), 0.02)
            if s.verdict == "unique":
                largest = max(largest, float(np.linalg.norm(s.position - TAG)))
    assert 0.7 * bound < largest <= 1.05 * bound


def test_one_gross_fault_among_random_layouts():
    """A fix called unique is within what the ellipsoid and the unseen shift allow; a name is the right one."""
    rng = np.random.default_rng(6)
    named = wrong = 0
    for _ in range(120):
        anchors = rng.uniform(-5, 5, (int(rng.integers(5, 9)), 2)) if rng.random() < 0.6 else rng.uniform(-5, 5, (7, 3))
        tag = rng.uniform(-4, 4, anchors.shape[1])
        r = measured(anchors, int(rng.integers(1e9)), 0.05, tag)
        bad = int(rng.integers(len(r)))
        r[bad] += rng.choice([-1, 1]) * 10 ** rng.uniform(-1, 0.7)
        s = solve_ranges(anchors, r, 0.05)
        if s.verdict == "unique":
            reach = np.sqrt(16.3 * np.linalg.eigvalsh(s.covariance)[-1])
            assert np.linalg.norm(s.position - tag) < 1.5 * s.unseen_shift + reach
        if s.isolated:
            named += 1
            wrong += [q.anchor for q in s.suspects] != [bad]
    assert named > 45
    assert wrong <= 0.03 * named
