"""Monte Carlo over random layouts, many of them bad: the truth is among what is given, and sds are honest."""

from itertools import combinations

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav.survey import Frame, Known, Links, Measured, survey_anchors
from robustnav.survey.starts import to_frame

N = 30
OUTSIDE = 1  # of the layouts: weak ones bend in ways that no ellipsoid follows


def layout(rng):
    """Draw anchors (spread, flat, in a row), which pairs are ranged, and what is known."""
    k, sd = int(rng.integers(4, 8)), 10 ** rng.uniform(-2.3, -0.7)
    p = rng.uniform(-6, 6, (k, 3)) * [1, 1, 0.4]
    shape, thickness = rng.choice(["spread", "flat", "row"], p=[0.6, 0.25, 0.15]), 10 ** rng.uniform(-4, 0)
    if shape == "flat":
        p[:, 2] *= thickness
    if shape == "row":
        p[:, 1:] *= thickness
    pairs = [pair for pair in combinations(range(k), 2) if rng.random() < rng.choice([1.0, 0.8])]
    known, frame = None, None
    how = rng.choice(["free", "side", "level", "known"], p=[0.2, 0.2, 0.3, 0.3])
    p = p if how == "known" else to_frame(p, (0, 1, 2), how == "level")
    if how == "side":
        frame = Frame(side=("3", "+z" if p[3, 2] > 0 else "-z"))
    if how == "level":
        known = Known(np.column_stack([np.full((k, 2), np.nan), p[:, 2]]))
    if how == "known":
        known = Known(np.where(np.arange(k)[:, None] < 3, p, np.nan))
    a, b = np.array(pairs).T
    d = np.linalg.norm(p[a] - p[b], axis=1) + sd * rng.standard_normal(len(a))
    links = Links(a, b, d, np.full(len(a), sd))
    return p, survey_anchors(Measured(tuple(map(str, range(k))), links), known, frame)


def distance(p, covariance, truth):
    """Return the squared error in units of the covariance and its degrees of freedom."""
    free = np.diag(covariance) > 0
    e = (p - truth).ravel()[free]
    return float(e @ np.linalg.solve(covariance[np.ix_(free, free)], e)), int(free.sum())


@pytest.fixture(scope="module")
def runs():
    rng = np.random.default_rng(0)
    return [layout(rng) for _ in range(N)]


def test_the_truth_is_among_the_layouts_given(runs):
    given = [(p, s) for p, s in runs if s.verdict in ("unique", "ambiguous")]
    assert len(given) > 0.2 * N
    best = [min(distance(q, C, p) for q, C in [(s.p_a, s.covariance), *s.alternatives]) for p, s in given]
    outside = [value for value, size in best if value > chi2.ppf(0.999, size)]
    assert len(outside) <= OUTSIDE
    assert max(value / size for value, size in best) < 8


def test_clean_ranges_are_not_called_inconsistent(runs):
    assert sum(s.verdict == "inconsistent" for _, s in runs) == 0


def test_errors_lie_in_the_chi_square_band():
    rng = np.random.default_rng(7)
    p = to_frame(rng.uniform(-6, 6, (6, 3)) * [1, 1, 0], (0, 1, 2), True)
    a, b = np.array(list(combinations(range(6), 2))).T
    known = Known(np.column_stack([np.full((6, 2), np.nan), np.zeros(6)]))
    values = []
    for _ in range(15):
        d = np.linalg.norm(p[a] - p[b], axis=1) + 0.03 * rng.standard_normal(15)
        found = survey_anchors(Measured(tuple("ABCDEF"), Links(a, b, d, np.full(15, 0.03))), known)
        assert found.verdict == "unique"
        values.append(distance(found.p_a, found.covariance, p))
    total = sum(size for _, size in values)
    low, high = chi2.ppf([0.005, 0.995], total)
    assert low < sum(value for value, _ in values) < high
