"""The numbers below the verdict: derivatives, descent, leaving out, reweighting."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from robustnav.snapshot.core import cost, descend, distances, expand, inflated, without
from robustnav.snapshot.readings import of_differences, of_ranges
from robustnav.snapshot.record import Height
from robustnav.snapshot.starts import starts

SEEDS = st.integers(0, 2**32 - 1)
KINDS = pytest.mark.parametrize("kind", ["ranges", "differences"])


def random_problem(rng, kind, d=3, k=7, height=None, sd=0.1):
    anchors = rng.uniform(-5, 5, (k, d))
    tag = rng.uniform(-4, 4, d)
    r = np.linalg.norm(anchors - tag, axis=1) + sd * rng.normal(size=k)
    spread = sd * rng.uniform(0.7, 1.5, k)
    if kind == "ranges":
        return of_ranges(anchors, r, spread, height).problem, tag
    return of_differences(anchors, r[1:] - r[0], spread, height).problem, tag


@KINDS
@given(seed=SEEDS)
def test_gradient_and_information_are_those_of_the_cost(kind, seed):
    rng = np.random.default_rng(seed)
    d = int(rng.integers(2, 4))
    problem, tag = random_problem(rng, kind, d, height=Height(1.0, 0.2) if d == 3 else None)
    p, h = tag + rng.normal(size=d), 1e-6
    steps = h * np.eye(d)
    value, gradient, info = expand(p[None], problem)
    assert value == pytest.approx(cost(p[None], problem))
    numeric = (cost(p + steps, problem) - cost(p - steps, problem)) / (2 * h)
    assert 2 * gradient[0] == pytest.approx(numeric, rel=1e-5, abs=1e-4 * np.abs(numeric).max())
    rows = (distances(p + steps, problem.anchors)[0] - distances(p - steps, problem.anchors)[0]).T / (2 * h)
    by_hand = rows.T @ problem.W @ rows + np.diag(problem.prior_info)
    assert info[0] == pytest.approx(by_hand, rel=1e-6, abs=1e-6 * np.abs(by_hand).max())


@KINDS
@pytest.mark.parametrize("seed", range(20))
def test_descent_ends_where_least_squares_from_the_truth_ends(kind, seed):
    rng = np.random.default_rng(seed)
    problem, tag = random_problem(rng, kind, k=8)
    L = np.linalg.cholesky(problem.W + 1e-9 * np.eye(8))

    def relative(p):
        e = problem.ranges - np.linalg.norm(problem.anchors - p, axis=1)
        return L.T @ (e - e[0] if problem.differences else e)

    oracle = least_squares(relative, tag, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    ends = descend(starts(problem), problem)
    best = np.argmin(ends.cost)
    assert ends.settled[best]
    assert ends.p[best] == pytest.approx(oracle.x, abs=1e-5)
    assert ends.cost[best] <= 2 * oracle.cost * (1 + 1e-6)


@given(seed=SEEDS)
def test_descent_never_climbs_and_stays_in_its_basis(seed):
    rng = np.random.default_rng(seed)
    problem, tag = random_problem(rng, "ranges")
    p = tag + 3 * rng.normal(size=(5, 3))
    normal = rng.normal(size=(5, 3))
    basis = np.linalg.svd(normal[:, None, :])[2][:, 1:].swapaxes(1, 2)
    for b in (None, basis):
        ends = descend(p, problem, b)
        assert np.all(ends.cost <= cost(p, problem))
        assert ends.cost == pytest.approx(cost(ends.p, problem), rel=1e-9)
    assert np.einsum("sd,sd->s", ends.p - p, normal) == pytest.approx(np.zeros(5), abs=1e-8)


def test_closed_form_is_exact_without_noise():
    rng = np.random.default_rng(3)
    for kind in ("ranges", "differences"):
        for d in (2, 3):
            problem, tag = random_problem(rng, kind, d, k=6, sd=1e-12)
            assert np.linalg.norm(starts(problem) - tag, axis=1).min() < 1e-6
            if d == 3:
                known = problem._replace(prior=np.array([0, 0, tag[2]]), prior_info=np.array([0, 0, 1e6]))
                assert np.linalg.norm(starts(known) - tag, axis=1).min() < 1e-6


def test_leaving_an_anchor_out_is_not_having_measured_it():
    rng = np.random.default_rng(4)
    problem, _ = random_problem(rng, "ranges")
    left = without(problem, 2).W
    assert left == pytest.approx(np.delete(np.delete(problem.W, 2, 0), 2, 1))

    anchors, arrivals, sd = rng.uniform(-5, 5, (7, 3)), rng.uniform(2, 9, 7), rng.uniform(0.1, 0.2, 7)
    whole = of_differences(anchors, arrivals[1:] - arrivals[0], sd, None).problem
    for gone in (0, 3):  # the reference leaves like any other
        keep = np.delete(np.arange(7), gone)
        left = of_differences(anchors[keep], arrivals[keep][1:] - arrivals[keep][0], sd[keep], None).problem
        p = rng.normal(size=(4, 3))
        assert cost(p, without(whole, gone)) == pytest.approx(cost(p, left), rel=1e-8)


def test_differences_cost_what_ranges_with_a_free_offset_cost():
    rng = np.random.default_rng(5)
    anchors, arrivals, sd = rng.uniform(-5, 5, (6, 3)), rng.uniform(2, 9, 6), rng.uniform(0.1, 0.2, 6)
    problem = of_differences(anchors, arrivals[1:] - arrivals[0], sd, None).problem
    p = rng.normal(size=3)
    e = arrivals - np.linalg.norm(anchors - p, axis=1)
    offset = (e / sd**2).sum() / (1 / sd**2).sum()
    assert cost(p[None], problem)[0] == pytest.approx((((e - offset) / sd) ** 2).sum())
    # and the full covariance of the differences says the same
    R = np.diag(sd[1:] ** 2) + sd[0] ** 2
    full = of_differences(anchors, arrivals[1:] - arrivals[0], R, None).problem.W
    assert full == pytest.approx(problem.W, abs=1e-9 * np.abs(problem.W).max())


def test_cost_of_differences_stays_true_far_away():
    problem, _ = random_problem(np.random.default_rng(7), "differences", sd=0.005)
    far = 1e7 * np.eye(3)
    e = problem.ranges[:, None] + problem.anchors  # along each axis distances fall with the anchor's coordinate
    e -= e[0]
    wanted = np.einsum("ks,kl,ls->s", e, problem.W, e)
    assert cost(far, problem) == pytest.approx(wanted, rel=1e-4)


@KINDS
def test_added_variance_is_a_larger_sd(kind):
    rng = np.random.default_rng(6)
    anchors, arrivals, sd = rng.uniform(-5, 5, (6, 3)), rng.uniform(2, 9, 6), rng.uniform(0.1, 0.2, 6)
    extra = rng.uniform(0, 0.1, 6)

    def made(s):
        if kind == "ranges":
            return of_ranges(anchors, arrivals, s, None).problem
        return of_differences(anchors, arrivals[1:] - arrivals[0], s, None).problem

    wanted = made(np.sqrt(sd**2 + extra)).W
    got = inflated(made(sd), extra).W
    assert got == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())
