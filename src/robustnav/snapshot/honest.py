"""Is the minimum the only one, and does its ellipsoid tell the truth?"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from robustnav.records import Array
from robustnav.snapshot.core import Minima, Problem, cost, covariance_of, descend, distances, expand
from robustnav.snapshot.record import Candidate
from robustnav.snapshot.starts import starts

SAME = 0.01  # squared distance in units of the covariance below which two end points are one minimum
LONG = 40  # more steps for slow descents that decide a verdict
PROBES = (1.0, -1.0, 0.5, -0.5, 0.25, -0.25)  # the near ones see a region that closes on itself further out
LADDER = 2.0 ** (0.5 * np.arange(-12, 15))  # steps along a weak direction, in units of its presumed reach


class Survey(NamedTuple):
    """All end points that the readings do not tell from the best, settled ones first, then by cost.

    ``settled``: all of them are minima; ``steps``: taken to the first.
    """

    candidates: tuple[Candidate, ...]
    infos: tuple[Array, ...]
    settled: bool
    steps: int


@lru_cache(maxsize=256)
def quantile(confidence: float, dof: int) -> float:
    """Return the chi-square quantile with ``dof`` degrees of freedom (at least 1)."""
    from scipy.special import chdtri

    return float(chdtri(max(dof, 1), 1.0 - confidence))


def survey(problem: Problem, confidence: float) -> Survey:
    """Return the minima whose cost is within the one-dimensional quantile of the best one's.

    The wrong one of two minima is ahead by that much in at most Q(sqrt(quantile)) of all cases, whatever the layout
    (about 0.05 % at a confidence of 0.999).
    """
    ends = descend(starts(problem), problem)
    near = np.flatnonzero(ends.cost <= ends.cost.min() + quantile(confidence, 1))
    slow = near[~ends.settled[near]]
    if slow.size:
        # what still crawls along a valley must not pass for another minimum, or for readings that contradict each other
        more = descend(ends.p[slow], problem, max_steps=LONG)
        ends = Minima(*(np.concatenate([a, b]) for a, b in zip(ends, more, strict=True)))
        ends.cost[slow] = np.inf
        near = np.flatnonzero(ends.cost <= ends.cost.min() + quantile(confidence, 1))
    near = near[np.lexsort((ends.cost[near], ~ends.settled[near]))]
    infos = expand(ends.p[near], problem)[2]
    off = ends.p[near][:, None] - ends.p[near]
    apart = np.einsum("abi,aij,abj->ab", off, infos, off)
    same = np.maximum(apart, apart.T) < SAME
    first = [i for i in range(near.size) if not same[i, :i].any()]
    found = [Candidate(ends.p[near[i]], covariance_of(infos[i])[0], float(ends.cost[near[i]])) for i in first]
    settled = bool(ends.settled[near[first]].all())
    return Survey(tuple(found), tuple(infos[i] for i in first), settled, int(ends.steps[near[0]]))


def shares(p: Array, problem: Problem, info: Array, radius: float) -> Array:
    """Return for each principal direction (d,), weakest first, the share of the promised rise that the cost shows.

    At points along both halves of each axis of the ellipsoid of ``radius`` sd the cost is minimised across the axis.
    Below 1 the region of good fit is longer than the ellipsoid, or bent out of it; more than promised counts as 1.
    """
    P, values, vectors = covariance_of(info)
    size = len(values)
    if np.isnan(P).any():  # information without a direction promises nothing that could be shown
        return np.zeros(size)
    sd = 1.0 / np.sqrt(values)
    if _straight(p, problem, sd[0] * radius):
        return np.ones(size)
    axis = np.tile(np.arange(size), len(PROBES))
    length = radius * sd[axis] * np.repeat(PROBES, size)
    q = across(p, problem, vectors.T[axis], length)
    promised = np.einsum("sd,de,se->s", q - p, info, q - p)
    risen = (cost(q, problem) - cost(p[None], problem)) / promised
    out: Array = np.clip(risen, 0.0, 1.0).reshape(len(PROBES), size).min(axis=0)
    return out


def _straight(p: Array, problem: Problem, reach: float) -> bool:
    """Return whether every range is linear within ``reach`` [m] of p to a tenth of its noise."""
    d = distances(p[None], problem.anchors)[0][0]
    if d.min() <= 2.0 * reach:
        return False
    return bool(np.all(0.5 * reach**2 / (d - reach) * np.sqrt(np.diag(problem.W)) < 0.1))


def across(p: Array, problem: Problem, direction: Array, length: Array) -> Array:
    """Return the points (s, d) of least cost in the planes at ``length`` (s,) along ``direction`` (s, d) from p."""
    basis = np.linalg.svd(direction[:, None, :])[2][:, 1:].swapaxes(1, 2)
    return descend(p + length[:, None] * direction, problem, basis, max_steps=8).p


def stretch(p: Array, problem: Problem, direction: Array, start: float, rise: float) -> float:
    """Return the sd along a direction [m]: how far the cost stays within ``rise`` of p's, over sqrt(rise)."""
    reach = start * np.concatenate([LADDER, -LADDER])
    q = across(p, problem, np.tile(direction, (reach.size, 1)), reach)
    inside = np.abs(reach[cost(q, problem) - cost(p[None], problem)[0] < rise])
    if inside.size and inside.max() >= start * LADDER[-1]:
        return float("inf")
    return float(inside.max() if inside.size else start * LADDER[0]) / float(np.sqrt(rise))


def parted(a: Array, b: Array, problem: Problem, rise: float) -> bool:
    """Return whether the cost between two minima stands by ``rise`` above both: two places, not one long region."""
    between = a + np.linspace(0.0, 1.0, 9)[1:-1, None] * (b - a)
    ends = cost(np.stack([a, b]), problem)
    return bool(cost(between, problem).max() - ends.max() > rise)
