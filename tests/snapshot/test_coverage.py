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
