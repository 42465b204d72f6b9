"""Which anchor does not fit: leave-out tests, reweighting, and what a test cannot see."""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from robustnav.records import Array
from robustnav.snapshot.core import Problem, covariance_of, descend, distances, inflated, without
from robustnav.snapshot.honest import Survey, quantile, survey
from robustnav.snapshot.record import Candidate, Options, Repair, Suspect

HUBER, STUDENT = 1.345, 4.0  # tuning constants in the usual places: 95 % and about 93 % efficient on clean readings
ROUNDS = 30


class Consensus(NamedTuple):
    """Anchors left out together, what remains and its minima, and the positions of choices that explain as much."""

    left_out: tuple[int, ...]
    problem: Problem
    survey: Survey
    suspects: tuple[Suspect, ...]
    rivals: tuple[Candidate, ...]


def consensus(problem: Problem, full_cost: float, options: Options) -> Consensus | None:
    """Return the smallest set of anchors whose removal makes the rest fit, or None.

    At least one degree of freedom must be left, or nothing tests the rest.  Rivals are sets of the same size whose cost
    is within the one-dimensional quantile of the best.
    """
    for size in range(1, min(options.max_faults, problem.dof - 1) + 1):
        fits: list[tuple[float, tuple[int, ...], Problem, Survey]] = []
        for chosen in combinations(range(len(problem.ranges)), size):
            rest = problem
            for anchor in sorted(chosen, reverse=True):
                rest = without(rest, anchor)
            seen = survey(rest, options.confidence)
            if seen.candidates[0].cost <= quantile(options.confidence, rest.dof):
                fits.append((seen.candidates[0].cost, chosen, rest, seen))
        if fits:
            fits.sort(key=lambda fit: fit[0])
            best, margin = fits[0], quantile(options.confidence, 1)
            rivals = [fit for fit in fits if fit[0] <= best[0] + margin]
            named = {a: _suspect(problem, a, fit[3], full_cost) for fit in reversed(rivals) for a in fit[1]}
            suspects = tuple(sorted(named.values(), key=lambda s: -s.sds))
            return Consensus(best[1], best[2], best[3], suspects, tuple(fit[3].candidates[0] for fit in rivals[1:]))
    return None


def _suspect(problem: Problem, anchor: int, rest: Survey, full_cost: float) -> Suspect:
    e = problem.ranges - distances(rest.candidates[0].position[None], problem.anchors)[0][0]
    error = float(problem.W[anchor] @ e / problem.W[anchor, anchor])
    return Suspect(anchor, error, float(np.sqrt(max(full_cost - rest.candidates[0].cost, 0.0))))


def reweighted(problem: Problem, from_p: Array, repair: Repair) -> tuple[Array, Problem, Array, int]:
    """Return position, problem and weights (k,) after iterated reweighting from a position (d,), and the steps taken.

    Each anchor's variance is raised to sd^2 / weight, which for correlated range differences does what the weight
    does for ranges.

    References
    ----------
    Holland and Welsch, Communications in Statistics A6 (1977); Student-t weight (nu + 1) / (nu + e^2), at most 1.
    """
    p, steps = from_p, 0
    variance = 1.0 / np.diag(problem.W)
    weights, fitted = np.ones(len(variance)), problem
    for _ in range(ROUNDS):
        # half the mean keeps a round from chasing its own weights in a circle
        weights = np.sqrt(weights * _weights(p, problem, fitted, repair))
        fitted = inflated(problem, variance * (1.0 / weights - 1.0))
        end = descend(p[None], fitted)
        steps += int(end.steps[0])
        moved, p = float(np.abs(end.p[0] - p).max()), end.p[0]
        if moved < 1e-6 * np.sqrt(variance.min()):
            break
    return p, fitted, weights, steps


def _weights(p: Array, problem: Problem, fitted: Problem, repair: Repair) -> Array:
    e = problem.ranges - distances(p[None], problem.anchors)[0][0]
    if problem.differences:
        info = fitted.W.diagonal()
        e = e - info @ e / info.sum()
    e = np.abs(e) * np.sqrt(np.diag(problem.W))
    raw = HUBER / np.maximum(e, HUBER) if repair == "huber" else (STUDENT + 1.0) / (STUDENT + e * e)
    out: Array = np.minimum(raw, 1.0)
    return out


def unseen_shift(p: Array, problem: Problem, info: Array, limit: float) -> float:
    """Return the largest shift [m] of p by one anchor's error that leaves the noise-free residual cost at ``limit``.

    References
    ----------
    Parkinson and Axelrad, Navigation 35 (1988); slope of position against test statistic.
    """
    P = covariance_of(info)[0]
    if problem.dof < 1 or not np.isfinite(P).all():
        return float("inf")
    U = distances(p[None], problem.anchors)[1][0]
    gain = P @ U.T @ problem.W
    left = np.diag(problem.W - problem.W @ U @ gain)
    blind = left < 1e-9 * np.diag(problem.W)
    slope = np.linalg.norm(gain, axis=0) / np.sqrt(np.where(blind, 1.0, left))
    return float("inf") if blind.any() else float(slope.max() * np.sqrt(limit))
