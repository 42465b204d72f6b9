"""Monte Carlo over random layouts, most of them bad: what is called unique contains the truth."""

import numpy as np
import pytest
from scipy.stats import chi2

N = 5000


def layout(rng, scene):
    """Draw anchors (spread, flat, in a row, in two heaps) and a tag (among, far, on an anchor, in their plane)."""
    d = int(rng.choice([2, 3], p=[0.7, 0.3]))
    kind = str(rng.choice(["ranges", "differences"], p=[0.65, 0.35]))
    height_sd = 0.1 if d == 3 and rng.random() < 0.25 else None
    k = int(rng.integers(d + (kind == "differences") - (height_sd is not None), 10))
    thickness = 10 ** rng.uniform(-4, 0)
    anchors = rng.uniform(-5, 5, (k, d))
    shape = rng.choice(["spread", "flat", "row", "heaps"], p=[0.4, 0.4, 0.1, 0.1])
    if shape == "flat":
        anchors[:, -1] *= thickness
    if shape == "row":
        anchors[:, 1:] *= thickness
    if shape == "heaps":
        anchors[k // 2 :] = anchors[: k - k // 2] + 0.1 * thickness * rng.normal(size=(k - k // 2, d))
    tag = rng.uniform(-6, 6, d)
    place = rng.choice(["among", "far", "on", "plane"], p=[0.5, 0.25, 0.1, 0.15])
    if place == "far":
        tag *= 10 ** rng.uniform(0, 1.7)
    if place == "on":
        tag = anchors[rng.integers(k)] + 10 ** rng.uniform(-3, -0.3) * rng.normal(size=d)
    if place == "plane":
        tag[-1] *= 10 ** rng.uniform(-3, -0.5)
    if rng.random() < 0.5:
        turn = np.linalg.qr(rng.normal(size=(d, d)))[0]
        anchors, tag = anchors @ turn.T, turn @ tag
    return scene(anchors, tag, 10 ** rng.uniform(-2.3, -0.3), kind, height_sd)


def inside(position, covariance, tag):
    e = tag - position
    return e @ np.linalg.solve(covariance, e) < chi2.ppf(0.999, e.size)


@pytest.fixture(scope="module")
def runs(scene):
    rng = np.random.default_rng(2024)
    scenes = [layout(rng, scene) for _ in range(N)]
    return [(one.tag, one.measure(rng)) for one in scenes]


def of(runs, verdict):
    return [(tag, s) for tag, s in runs if s.verdict == verdict]


def test_unique_means_unique(runs):
    unique = of(runs, "unique")
    covered = sum(inside(s.position, s.covariance, tag) for tag, s in unique)
    assert len(unique) > 0.3 * N
    assert covered >= 0.995 * len(unique)


def test_errors_of_unique_fixes_are_not_understated(runs):
    """The sum of squared errors in units of the covariance, with the covariance drawn out where it had to be."""
    unique = of(runs, "unique")
    nees = sum(min((s.position - t) @ np.linalg.solve(s.covariance, s.position - t), 30.0) for t, s in unique)
    expected = sum(t.size for t, _ in unique)
    assert 0.75 * expected < nees < expected + 4 * np.sqrt(2 * expected)


def test_one_of_the_ambiguous_positions_is_right(runs):
    ambiguous = of(runs, "ambiguous")
    places = [[(s.position, s.covariance), *(c[:2] for c in s.alternatives)] for _, s in ambiguous]
    covered = sum(any(inside(*place, t) for place in ps) for (t, _), ps in zip(ambiguous, places, strict=True))
    assert len(ambiguous) > 0.1 * N
    assert covered >= 0.995 * len(ambiguous)


def test_clean_readings_are_rarely_called_inconsistent(runs):
    assert len(of(runs, "inconsistent")) < 0.004 * N
    assert not of(runs, "too few")


def test_degenerate_fixes_state_a_direction_and_mostly_cover_it(runs):
    degenerate = of(runs, "degenerate")
    off = [abs(s.weak.direction @ (s.position - tag)) / s.weak.sd for tag, s in degenerate]
    assert np.mean(np.array(off) < 3.3) > 0.9


def test_a_small_rig_knows_when_the_bearing_is_lost(scene):
    """Seen from close together the region of good fit is a cap, or all of a sphere: no ellipsoid holds it."""
    rng = np.random.default_rng(11)
    verdicts = []
    for _ in range(400):
        d = int(rng.integers(2, 4))
        anchors = 10 ** rng.uniform(-1, 0) * rng.uniform(-1, 1, (int(rng.integers(d + 1, 7)), d))
        line = rng.normal(size=d)
        tag = 10 ** rng.uniform(-0.3, 0.9) * line / np.linalg.norm(line)
        s = scene(anchors, tag, 10 ** rng.uniform(-2, -0.5)).measure(rng)
        verdicts.append(s.verdict)
        if s.verdict == "unique":
            e = s.position - tag
            assert e @ np.linalg.solve(s.covariance, e) < 35.0, s.reason
        elif s.verdict == "degenerate" and np.isfinite(s.covariance).all():
            assert s.weak.direction @ s.covariance @ s.weak.direction >= 0.999 * s.weak.sd**2
    assert verdicts.count("unique") > 50


def test_near_and_far_are_not_mistaken_for_one_another(scene):
    """Differences of a tag far off can also be met close by, to within the noise."""
    rng = np.random.default_rng(12)
    verdicts = []
    for _ in range(400):
        heap = rng.uniform(-5, 5, (3, 3))
        anchors = np.vstack([heap, heap + 0.01 * rng.normal(size=(3, 3)), rng.uniform(-5, 5, (1, 3))])
        line = rng.normal(size=3)
        tag = 10 ** rng.uniform(1, 2.5) * line / np.linalg.norm(line)
        s = scene(anchors, tag, 10 ** rng.uniform(-1, 0), "differences").measure(rng)
        verdicts.append(s.verdict)
        if s.verdict == "unique":
            e = s.position - tag
            assert e @ np.linalg.solve(s.covariance, e) < 35.0, s.reason
    assert verdicts.count("degenerate") > 200


def test_ellipsoid_is_drawn_out_where_the_readings_bend(scene):
    rig = np.array([[2.21, 0.19, 1.79], [-0.36, -0.46, 1.97], [0.71, -0.87, 0.61], [-0.05, 0.87, 0.5]])
    rng, drawn_out = np.random.default_rng(13), 0
    for _ in range(20):
        s = scene(rig, np.array([0.0, -4.27, 1.0]), 0.08).measure(rng)
        first_order = 0.08 * s.dop.gdop
        assert np.sqrt(np.trace(s.covariance)) >= 0.999 * first_order
        drawn_out += s.verdict == "unique" and np.sqrt(np.trace(s.covariance)) > 1.1 * first_order
    assert drawn_out > 3
