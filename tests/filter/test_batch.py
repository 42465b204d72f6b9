"""Batch least squares: the smoother where all is linear, a minimum of its cost where it is not."""

from itertools import pairwise

import numpy as np
import pytest

from robustnav.engine import CompiledModel
from robustnav.errors import EstimatorError, InputError
from robustnav.filter import ekf, smoother
from robustnav.filter.batch import Effort, Problem, Readings, solve
from robustnav.filter.weighting import Gate, Huber, StudentT
from robustnav.model import NumericModel
from robustnav.models import uwb

ALL, ONE = Gate(), Effort(1)
ANCHORS = np.array([[0, 0, -3], [10, 0, -1], [10, 8, -3], [0, 8, -0.5], [5, 4, -4]], float)


def smoothed(model, problem):
    """Beliefs of the filter and the smoother over the same problem, each reading in full."""
    rows = []
    for k, dt in enumerate(problem.dt):
        belief = ekf.predict(model, *rows[-1], problem.u[k], dt) if k else (problem.x, problem.P)
        for j, one in enumerate(problem.readings):
            for z in one.z[one.row == k]:
                belief = ekf.update(model, j, belief, z)[:2]
        rows.append(belief)
    return smoother.smooth(model, problem.dt, problem.u, rows)


def springs(count=40, rule=ALL):
    rng = np.random.default_rng(4)
    dt = np.r_[np.nan, rng.uniform(0.02, 0.3, count - 1)]
    row = np.array([0, *range(3, count - 2, 2), 7, 7])  # three at one instant, none at the end
    readings = Readings(row, rng.normal(size=(len(row), 2)), rule)
    return Problem(dt, rng.normal(size=(count, 1)), np.ones(3), np.diag([1.0, 2.0, 0.5]), (readings,))


@pytest.mark.parametrize("density", [0.4, 0.0])
def test_one_pass_is_the_smoother_on_a_linear_model(spring, density):
    model = NumericModel(spring.model.with_numbers(density={"w": density}))
    problem = springs()
    guess = np.random.default_rng(0).normal(size=(40, 3))  # whatever it starts from
    found = solve(model, problem, guess, ONE)
    beliefs = smoothed(model, problem)
    np.testing.assert_allclose(found.x, [x for x, _ in beliefs], atol=1e-9)
    np.testing.assert_allclose(found.P, [P for _, P in beliefs], atol=1e-9)
    assert found.passes == 1 and found.step > 1
    again = solve(model, problem, found.x, Effort())
    assert again.passes == 1 and again.step < 1e-6


def flight(rule, off=0.15):
    """Ranges in turn from five anchors, some of them long, and a few heights."""
    rng = np.random.default_rng(8)
    t = np.cumsum(rng.uniform(0.05, 0.1, 60))
    p = np.c_[5 + 3 * np.cos(t), 4 + 2 * np.sin(1.3 * t), -1.5 + 0.3 * np.sin(t)]
    anchor = ANCHORS[rng.integers(0, 5, 60)]
    d = np.linalg.norm(p - anchor, axis=1) + 0.1 * rng.normal(size=60)
    d[rng.random(60) < off] += 1.5
    row = np.arange(0, 60, 10)
    readings = (
        Readings(np.arange(60), np.c_[d, anchor], rule),
        Readings(np.zeros(0, int), np.zeros((0, 7)), ALL),
        Readings(np.zeros(0, int), np.zeros((0, 3)), ALL),
        Readings(row, -p[row, 2:] + 0.1 * rng.normal(size=(len(row), 1)), ALL),
    )
    x = np.r_[p[0], 0, 0, 0] + 0.3
    problem = Problem(np.diff(t, prepend=np.nan), np.zeros((60, 0)), x, 0.5 * np.eye(6), readings)
    return problem, p, np.c_[p + 0.3 * rng.normal(size=(60, 3)), np.zeros((60, 3))]


def rho(rule, square):
    """Twice the cost of a scalar residual: rho' = weight."""
    if isinstance(rule, Huber):
        return square if square <= rule.limit**2 else 2 * rule.limit * np.sqrt(square) - rule.limit**2
    if isinstance(rule, StudentT):
        far = 1 + (rule.limit + 1) * np.log((rule.limit + square) / (rule.limit + 1))
        return square if square <= 1 else far
    return square


def cost(model, problem, x):
    """Half the sum of squares that the path is to minimise, from its definition."""
    e = model.difference(x[0], problem.x)
    total = e @ np.linalg.solve(problem.P, e)
    for k in range(1, len(x)):
        e = model.difference(x[k], model.propagate(x[k - 1], problem.u[k], problem.dt[k]))
        total += e @ np.linalg.solve(model.transition(x[k - 1], problem.u[k], problem.dt[k])[1], e)
    for j, readings in enumerate(problem.readings):
        for k, z in zip(readings.row, readings.z, strict=True):
            r = model.residual(j, x[k], z)
            total += rho(readings.rule, float(r @ r) / model.model.variances[j])
    return total / 2


def gradient(model, problem, x, P):
    """Slope of the cost along the errors of every seventh state, each in its own standard deviations."""
    out = np.zeros((len(P[::7]), P.shape[1]))
    for row, i in np.ndindex(out.shape):
        k = 7 * row
        ends = []
        for side in (1e-4, -1e-4):
            e, moved = np.zeros(P.shape[1]), x.copy()
            e[i] = side * np.sqrt(P[k, i, i])
            moved[k] = model.inject(x[k], e)
            ends.append(cost(model, problem, moved))
        out[row, i] = (ends[0] - ends[1]) / 2e-4
    return out


@pytest.fixture(scope="module")
def tag():
    return CompiledModel(uwb(range_sd=0.1, acceleration_density=1.0, time_offset=0.05))


@pytest.mark.parametrize("rule", [ALL, Huber(1.345), StudentT(3.0)], ids=["plain", "Huber", "Student-t"])
def test_it_ends_where_the_cost_is_least(tag, rule):
    problem, _, guess = flight(rule)
    found = solve(tag, problem, guess, Effort(200, 1e-8))
    assert found.step <= 1e-8
    start, end = (np.abs(gradient(tag, problem, x, found.P)).max() for x in (guess, found.x))
    assert end < 1e-5 < 10 < start
    assert all((w <= 1).all() and (w > 0).all() for w in found.weights)


def test_the_rule_says_what_is_off(tag):
    problem, p, guess = flight(StudentT(3.0))
    robust = solve(tag, problem, guess, Effort(40, 1e-3))
    plain = solve(tag, flight(ALL)[0], guess, Effort())
    errors = [np.sqrt(np.mean((one.x[:, :3] - p) ** 2)) for one in (robust, plain)]
    assert errors[0] < 0.5 * errors[1]
    long = np.linalg.norm(p - problem.readings[0].z[:, 1:], axis=1) < problem.readings[0].z[:, 0] - 1
    assert 5 < long.sum() < 15 and robust.weights[0][long].max() < 0.15 < np.median(robust.weights[0])
    np.testing.assert_array_equal(plain.weights[0], 1.0)
    expected = [StudentT(3.0).weight(r[0] ** 2 / 0.01, 1) for r in robust.residuals[0]]
    np.testing.assert_allclose(robust.weights[0], expected)


def attitudes(turning):
    rng = np.random.default_rng(6)
    u = 0.5 * rng.normal(size=(30, 3))
    x = [np.r_[0.9, 0.1, -0.3, 0.2, 0.01, -0.02, 0.0]]
    x[0][:4] /= np.linalg.norm(x[0][:4])
    for k in range(1, 30):
        x.append(turning.propagate(x[-1], u[k], 0.05))
    readings = []
    for j, every in ((0, 2), (1, 5)):
        row = np.arange(0, 30, every)
        sd = np.sqrt(turning.model.variances[j])
        z = np.array([turning.measure(j, x[k]) + sd * rng.normal(size=3) for k in row])
        readings.append(Readings(row, z, ALL))
    start = turning.inject(x[0], np.r_[0.1, -0.2, 0.3, 0.01, 0.01, 0.01])
    P = np.diag([0.2, 0.2, 0.2, 0.02, 0.02, 0.02]) ** 2
    return Problem(np.r_[np.nan, np.full(29, 0.05)], u, start, P, tuple(readings)), np.array(x)


def test_attitudes_stay_on_their_sphere_and_the_cost_falls(turning):
    problem, truth = attitudes(turning)
    beliefs = smoothed(turning, problem)
    guess = np.array([x for x, _ in beliefs])
    found = solve(turning, problem, guess, Effort(30, 1e-9))
    assert found.step <= 1e-9
    np.testing.assert_allclose(np.linalg.norm(found.x[:, :4], axis=1), 1, atol=1e-12)
    assert cost(turning, problem, found.x) < cost(turning, problem, guess)
    # F is of first order in the step, and so is the minimum: what slope is left is far below that of one deviation
    start, end = (np.abs(gradient(turning, problem, x, found.P)).max() for x in (guess, found.x))
    assert end < 0.1 < 0.5 < start
    errors = np.array([turning.difference(a, b) for a, b in zip(found.x, truth, strict=True)])
    nees = np.einsum("ki,kij,kj->k", errors, np.linalg.inv(found.P), errors)
    assert nees.mean() < 16.8  # 99 % of a chi-square with 6; one run only


def test_progress_is_told_and_passes_end(tag):
    problem, _, guess = flight(StudentT(3.0))
    told = []
    found = solve(tag, problem, guess, Effort(3, 1e-6, lambda *one: told.append(one)))
    assert [number for number, _ in told] == [1, 2, 3] and told[-1][1] == found.step > 1e-6
    assert all(a > b > 0 for (_, a), (_, b) in pairwise(told))


def test_what_cannot_be_fitted_is_refused(tag):
    problem, _, guess = flight(ALL)
    guess[5] = np.nan
    with pytest.raises(EstimatorError, match="pass 1"):
        solve(tag, problem, guess, Effort())
    for bad in ({"passes": 0}, {"tolerance": 0.0}, {"tolerance": np.nan}):
        with pytest.raises(InputError, match="batch"):
            Effort(**bad)
