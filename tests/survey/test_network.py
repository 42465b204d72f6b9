"""The numbers: derivatives, the elimination of the track, starts that are right when ranges are."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.survey import Known, Measured, Options
from robustnav.survey import network as network_module
from robustnav.survey.build import build
from robustnav.survey.inner import inner_covariance
from robustnav.survey.judge import bound
from robustnav.survey.minima import reflected
from robustnav.survey.network import Tie, anchor_information, cost, descend, jacobian, normal, plain, residuals
from robustnav.survey.record import Frame
from robustnav.survey.starts import anchor_distances, anchor_start, grow, scaled, to_frame


@pytest.fixture
def task(hall, tag, links):
    rng = np.random.default_rng(3)
    known = Known(np.where(np.arange(6)[:, None] < 4, hall, np.nan), np.full((6, 3), 0.1))
    measured = Measured(
        tuple("ABCDEF"), links(hall, 0.05, rng, pairs=[(0, 4), (4, 5)]), tag(hall, 0.05, rng, seconds=3.0, apart=0.03)
    )
    return build(measured, known, Frame(), Options(knot_s=0.5, acceleration_sd=0.7))


def spread(task, seed=0):
    rng = np.random.default_rng(seed)
    return np.where(task.network.free, rng.uniform(-5, 5, task.network.known.shape), task.network.known)


def test_gradient_and_jacobian_are_those_of_finite_differences(task):
    network, p = task.network, spread(task)
    J, right, info = jacobian(p, network)
    down = normal(p, network)[1]
    h, rows = 1e-6, np.argwhere(network.free)
    for column in range(0, len(rows), 5):
        shift = np.zeros_like(p)
        shift[tuple(rows[column])] = h
        change = (jacobian(p - shift, network)[1] - jacobian(p + shift, network)[1]) / (2 * h)
        np.testing.assert_allclose(J[:, column], change, atol=1e-6)
        slope = (cost(p + shift, network) - cost(p - shift, network)) / (2 * h)
        np.testing.assert_allclose(down[column], -slope / 2, rtol=1e-4, atol=1e-3)
    assert len(right) == len(info) == len(network.ends) + 3 * len(network.bends)


def test_sparse_and_dense_are_one(task, monkeypatch):
    p = spread(task)
    A, down = normal(p, task.network)
    S = anchor_information(p, task.network)
    end = descend(p, task.network)
    monkeypatch.setattr(network_module, "DENSE", 0)
    sparse, same = normal(p, task.network)
    assert not isinstance(sparse, np.ndarray)
    np.testing.assert_allclose(plain(sparse), A, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(same, down)
    np.testing.assert_allclose(anchor_information(p, task.network), S, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(descend(p, task.network).cost, end.cost, rtol=1e-9)


def test_the_anchors_information_is_that_of_the_whole_with_the_track_left_free(task):
    end = descend(grow(spread(task), np.arange(len(task.network.known)) < 6, task.network), task.network)
    c = task.network.free_anchors
    whole = np.linalg.inv(normal(end.p, task.network)[0])[:c, :c]
    np.testing.assert_allclose(np.linalg.inv(anchor_information(end.p, task.network)), whole, rtol=1e-5, atol=1e-9)


def test_a_tie_holds_its_length_and_the_rest_is_least(task):
    network = task.network
    end = descend(grow(spread(task), np.arange(len(network.known)) < 6, network), network)
    direction = np.zeros(np.count_nonzero(network.free))
    direction[12] = 1.0
    start = end.p[network.free]
    tied = descend(end.p, network, Tie(direction, start, 0.02, 1e8))
    moved = direction @ (tied.p[network.free] - start)
    assert moved == pytest.approx(0.02, rel=1e-3)
    gradient = normal(tied.p, network)[1]
    assert np.abs(np.delete(gradient, 12)).max() < 1e-3 * abs(gradient[12])


def test_a_range_left_out_counts_for_nothing(task):
    p = spread(task)
    info = task.network.info.copy()
    info[3] = 0.0
    without = replace(task.network, info=info)
    assert cost(p, task.network) - cost(p, without) == pytest.approx(
        task.network.info[3] * residuals(p, task.network)[0][3] ** 2
    )
    assert without.dof == task.network.dof - 1


def test_scaling_gives_exact_distances_back(hall):
    d = np.linalg.norm(hall[:, None] - hall, axis=2)
    p = scaled(d, 3)
    np.testing.assert_allclose(np.linalg.norm(p[:, None] - p, axis=2), d, atol=1e-9)
    laid = to_frame(p, (0, 1, 2), False)
    image = laid * [1, 1, -1]
    assert min(np.abs(laid - hall).max(), np.abs(image - hall).max()) < 1e-9


@pytest.mark.parametrize("level", [False, True])
def test_laying_the_frame_turns_and_shifts_only(hall, level):
    rng = np.random.default_rng(5)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]]) if level else turn
    moved = hall @ turn.T + [3, -2, 0 if level else 5]
    np.testing.assert_allclose(to_frame(moved, (0, 1, 2), level), hall, atol=1e-9)


def test_bounds_of_a_tag_hold_the_truth(hall, tag):
    measured = Measured(tuple("ABCDEF"), tag=tag(hall, 1e-6, np.random.default_rng(0)))
    network = build(measured, None, Frame(), Options()).network
    d = np.linalg.norm(hall[:, None] - hall, axis=2)
    estimate = anchor_distances(network)
    assert (np.abs(estimate - d) < 0.5 * d.max()).all() and np.abs(np.diag(estimate)).max() == 0
    start = anchor_start(build(measured, None, Frame(), Options()))
    assert start[0] == pytest.approx([0, 0, 0], abs=1e-9)
    assert start[1, 1:] == pytest.approx([0, 0], abs=1e-9) and start[1, 0] > 0 and start[2, 1] > 0


def test_inner_covariance_does_not_know_which_anchors_lay_the_frame(hall, links):
    def of(first):
        laid = to_frame(hall, first, False)
        task = build(
            Measured(tuple("ABCDEF"), links(laid, 0.05)), None, Frame(tuple("ABCDEF"[k] for k in first)), Options()
        )
        k = 6
        free = np.flatnonzero(task.network.free[:k])
        covariance = np.zeros((18, 18))
        covariance[np.ix_(free, free)] = np.linalg.inv(anchor_information(laid, task.network))
        inner = inner_covariance(laid, covariance, False)
        return np.trace(inner.reshape(6, 3, 6, 3), axis1=1, axis2=3)

    np.testing.assert_allclose(of((0, 1, 2)), of((3, 5, 1)), rtol=1e-6, atol=1e-9)


def test_a_tag_that_two_places_fit_stays_on_the_side_where_it_was(hall, tag, tag_path):
    flat = hall * [1, 1, 0]
    stamps = np.arange(0.0, 6.0, 0.25)
    ranges = tag(flat, 1e-4, np.random.default_rng(0), seconds=6.0)
    known = Known(flat, np.full((6, 3), 0.01))
    network = build(Measured(tuple("ABCDEF"), tag=ranges), known, Frame(), Options()).network
    located = np.arange(len(network.known)) < 6
    p = grow(np.vstack([flat, np.zeros((len(stamps), 3))]), located, network)
    side = np.sign(p[6:, 2])
    assert (side == side[0]).all()
    np.testing.assert_allclose(p[6:] * [1, 1, -side[0]], tag_path(stamps), atol=0.01)


@pytest.mark.parametrize("upright", [False, True])
def test_a_mirror_image_keeps_the_distances_to_what_it_is_mirrored_in(upright):
    rng = np.random.default_rng(1)
    p = rng.uniform(-5, 5, (4, 3))
    line = p[0] + np.outer([0.0, 1.0, 2.5], [1.0, 2.0, 0.0])
    through = line + np.outer([0.0, 3.0, -1.0], [0.0, 0.0, 1.0]) if upright else p[:3]
    movable = np.tile([True, True, not upright], (4, 1))
    rows = np.arange(4) == 3
    image = reflected(p, rows, through, movable)
    np.testing.assert_array_equal(image[:3], p[:3])
    assert np.linalg.norm(image[3] - p[3]) > 0.1
    before, after = (np.linalg.norm(through - q[3], axis=1) for q in (p, image))
    np.testing.assert_allclose(after, before, rtol=1e-9)
    assert not upright or image[3, 2] == p[3, 2]


def test_an_ellipsoid_that_ranges_do_not_follow_is_given_up(hall, links):
    flat = hall[:4] * [1, 1, 0]
    known = Known(np.where(np.arange(4)[:, None] < 3, flat, np.nan))

    def cause(height):
        at = flat.copy()
        at[3, 2] = -height
        task = build(Measured(tuple("ABCD"), links(at, 0.02)), known, Frame(), Options())
        return bound(descend(at, task.network), task.network, Options(max_dilution=1e9)).cause

    assert "change too little" in cause(0.34)  # the mirror image lies on the ellipsoid
    assert cause(2.5) == ""
