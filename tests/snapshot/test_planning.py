"""Dilution of precision before measuring."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.snapshot import Grid, Sensing, best_extra_anchor, dop_at, gdop_map

DIFFERENCES, KNOWN = Sensing("differences"), Sensing(height_known=True)


@pytest.mark.parametrize("k", [3, 4, 7])
def test_ring_of_anchors_has_two_over_root_k(k):
    angle = 2 * np.pi * np.arange(k) / k
    ring = 5.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    for sensing in (Sensing(), DIFFERENCES):  # from the centre all offsets cancel
        dop = dop_at(ring, [[0.0, 0.0]], sensing)
        assert dop.gdop[0] == pytest.approx(2 / np.sqrt(k))
        assert dop.hdop[0] == pytest.approx(dop.gdop[0])
        assert np.isnan(dop.vdop[0])


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_dop_is_the_spread_of_linear_least_squares(seed):
    rng = np.random.default_rng(seed)
    anchors, p = rng.uniform(-5, 5, (7, 3)), rng.uniform(-3, 3, 3)
    h = 1e-6
    rows = [
        np.linalg.norm(anchors - p - h * v, axis=1) - np.linalg.norm(anchors - p + h * v, axis=1) for v in np.eye(3)
    ]
    G = np.array(rows).T / (2 * h)
    contrast = np.column_stack([-np.ones(6), np.eye(6)])
    cases = {
        Sensing(): np.linalg.inv(G.T @ G),
        KNOWN: np.linalg.inv(G[:, :2].T @ G[:, :2]),
        DIFFERENCES: np.linalg.inv(G.T @ contrast.T @ np.linalg.solve(contrast @ contrast.T, contrast @ G)),
    }
    for sensing, P in cases.items():
        dop = dop_at(anchors, p[None], sensing)
        assert dop.gdop[0] == pytest.approx(np.sqrt(np.trace(P)), rel=1e-5)
        assert dop.hdop[0] == pytest.approx(np.sqrt(P[0, 0] + P[1, 1]), rel=1e-5)
        if sensing.height_known:
            assert np.isnan(dop.vdop[0])
        else:
            assert dop.vdop[0] == pytest.approx(np.sqrt(P[2, 2]), rel=1e-5)


def test_map_is_the_dop_at_its_points(box):
    grid = Grid(np.linspace(-5, 15, 5), np.linspace(-4, 12, 3), 1.5)
    dop = gdop_map(box, grid)
    assert dop.gdop.shape == (3, 5)
    for i, y in enumerate(grid.y):
        for j, x in enumerate(grid.x):
            assert dop.gdop[i, j] == pytest.approx(dop_at(box, [[x, y, 1.5]]).gdop[0])
    worst = gdop_map(box, grid, one_out=True).gdop
    assert np.all(worst > dop.gdop)


def test_plane_of_the_anchors_is_blind_in_height(ceiling):
    grid = Grid([2.0, 6.0], [3.0], 3.0)
    assert np.all(np.isinf(gdop_map(ceiling, grid).gdop))
    assert np.all(gdop_map(ceiling, grid, KNOWN).gdop < 2)
    assert np.all(gdop_map(ceiling, grid._replace(z=1.0)).gdop < 20)
    assert np.all(np.isinf(gdop_map(ceiling, grid._replace(z=1.0), one_out=True, sensing=DIFFERENCES).gdop))


@pytest.mark.parametrize("goal", ["mean", "worst"])
@pytest.mark.parametrize("sensing", [Sensing(), DIFFERENCES])
def test_best_extra_anchor_is_best(goal, sensing, box):
    rng = np.random.default_rng(1)
    anchors, region, places = box[[0, 3, 5, 6, 7]], rng.uniform(0, 8, (30, 3)), rng.uniform(-2, 12, (12, 3))
    extra = best_extra_anchor(anchors, region, places, sensing, goal)
    measure = np.mean if goal == "mean" else np.max
    scores = [measure(dop_at(np.vstack([anchors, c]), region, sensing).gdop) for c in places]
    assert extra.scores == pytest.approx(scores)
    assert extra.row == np.argmin(scores)
    assert extra.position == pytest.approx(places[extra.row])
    assert extra.scores.max() < extra.before  # an anchor more never harms


def test_extra_anchor_first_opens_blind_points(ceiling):
    region = [[3.0, 4.0, 3.0], [5.0, 5.0, 1.0]]
    extra = best_extra_anchor(ceiling, region, [[5.0, 4.0, 3.0], [5.0, 0.0, 0.0]])
    assert extra.blind.tolist() == [1, 0]
    assert extra.row == 1
    assert best_extra_anchor(ceiling, region, [[5.0, 4.0, 3.0]], goal="worst").scores[0] == np.inf
    assert best_extra_anchor(ceiling, region[:1], [[5.0, 4.0, 3.0]]).scores[0] == np.inf


BAD = {
    "positions": lambda a: dop_at(a, [1.0, 2.0, 3.0]),
    "row 1": lambda a: dop_at(a, [[1.0, 2.0, 3.0], [np.nan, 1.0, 1.0]]),
    "grid height": lambda a: gdop_map(a, Grid([1.0], [1.0])),
    "grid, got|grid": lambda a: gdop_map(a, Grid([[1.0]], [1.0], 1.0)),
    "at least 2": lambda a: gdop_map(a[:1], Grid([1.0], [1.0], 1.0), one_out=True),
    "candidates": lambda a: best_extra_anchor(a, a, np.ones((0, 3))),
    "goal": lambda a: best_extra_anchor(a, a, a, goal="best"),
    "sensing": lambda a: dop_at(a, a, Sensing("angles")),
    "known height": lambda a: dop_at(a[:, :2], a[:, :2], KNOWN),
}


@pytest.mark.parametrize("named", BAD)
def test_bad_input_is_named(named, box):
    with pytest.raises(InputError, match=named):
        BAD[named](box)
