"""Position from ranges or range differences at one instant, with a verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from robustnav.records import Array
from robustnav.snapshot import words
from robustnav.snapshot.core import covariance_of, distances, expand
from robustnav.snapshot.faults import consensus, reweighted, unseen_shift
from robustnav.snapshot.honest import Survey, quantile, survey
from robustnav.snapshot.judge import Judgement, judge
from robustnav.snapshot.readings import Readings, of_differences, of_ranges
from robustnav.snapshot.record import Candidate, Dop, Height, Options, Snapshot, Weak


def solve_ranges(
    anchors: ArrayLike,
    ranges: ArrayLike,
    noise: ArrayLike,
    height: Height | None = None,
    options: Options | None = None,
) -> Snapshot:
    """Find the position of a tag from its distances to anchors, and say whether to believe it.

    Parameters
    ----------
    anchors : (k, 2) or (k, 3) surveyed positions [m], any Cartesian frame; a known height is its third axis.
    ranges : (k,) calibrated distances [m]; NaN where missing.
    noise : sd of a range [m], (k,) sds, or their (k, k) covariance [m^2].
    height : known third coordinate of the tag, or None.
    options : levels of the tests; None for the defaults.

    Returns
    -------
    snapshot : position, covariance, verdict and the reason for it.

    Raises
    ------
    InputError : shapes, infinite numbers, a noise that is not positive, a height in 2D.
    """
    return _solve(of_ranges(anchors, ranges, noise, height), options or Options())


def solve_differences(
    anchors: ArrayLike,
    differences: ArrayLike,
    noise: ArrayLike,
    height: Height | None = None,
    options: Options | None = None,
) -> Snapshot:
    """Find the position of a tag from differences of its distances to anchors, and say whether to believe it.

    Parameters
    ----------
    anchors : (k, 2) or (k, 3) surveyed positions [m]; row 0 is the reference.
    differences : (k - 1,) distance to anchors 1, 2, ... minus distance to anchor 0 [m]; NaN where missing.
    noise : sd of one arrival [m] or (k,) sds, from which the correlation by the common reference follows; or the full
        (k - 1, k - 1) covariance of the differences [m^2].
    height, options : as for ``solve_ranges``.

    Returns
    -------
    snapshot : position, covariance, verdict and the reason for it.

    Raises
    ------
    InputError : shapes, infinite numbers, a noise that is not positive, a height in 2D.
    """
    return _solve(of_differences(anchors, differences, noise, height), options or Options())


def _solve(given: Readings, options: Options) -> Snapshot:
    problem = given.problem
    if problem.dof < 0:
        return _too_few(given)
    seen = survey(problem, options.confidence)
    if seen.candidates[0].cost > quantile(options.confidence, problem.dof):
        return _inconsistent(given, seen, options)
    out = _snapshot(given, judge(problem, seen, options), np.ones(len(problem.ranges)))
    shift = unseen_shift(out.position, problem, seen.infos[0], quantile(options.confidence, problem.dof))
    return replace(out, cost=seen.candidates[0].cost, unseen_shift=shift, iterations=seen.steps)


def _inconsistent(given: Readings, seen: Survey, options: Options) -> Snapshot:
    """Return the solution of the anchors that agree, or of all reweighted, and name those that do not fit."""
    problem, full_cost = given.problem, seen.candidates[0].cost
    found = consensus(problem, full_cost, options)
    weights, rest = np.ones(len(problem.ranges)), problem
    if found is not None:
        rest, seen = found.problem, found.survey
        weights[list(found.left_out)] = 0.0
    if options.repair != "exclude":
        p, rest, weights, steps = reweighted(problem, seen.candidates[0].position, options.repair)
        info = expand(p[None], rest)[2][0]
        seen = Survey((Candidate(p, covariance_of(info)[0], full_cost),), (info,), True, steps)
    judged = judge(rest, seen, options)
    rows = np.flatnonzero(given.used)
    suspects = tuple(s._replace(anchor=int(rows[s.anchor])) for s in found.suspects) if found else ()
    isolated = found is not None and not found.rivals
    limit = quantile(options.confidence, problem.dof)
    reason = words.inconsistent(full_cost, limit, problem.dof, suspects, isolated)
    if found is not None:
        reason = f"{reason} Without: {judged.verdict}."
        judged = judged._replace(others=judged.others + found.rivals)
    out = _snapshot(given, judged._replace(verdict="inconsistent", reason=reason), weights)
    return replace(out, cost=full_cost, suspects=suspects, isolated=isolated, iterations=seen.steps)


def _snapshot(given: Readings, judged: Judgement, weights: Array) -> Snapshot:
    """Return the record of a judgement; ``weights`` are those of the anchors in use."""
    all_weights = np.zeros(len(given.anchors))
    all_weights[given.used] = weights
    d = distances(judged.best.position[None], given.anchors)[0][0]
    return Snapshot(
        verdict=judged.verdict,
        reason=judged.reason,
        position=judged.best.position,
        covariance=judged.best.covariance,
        alternatives=judged.others,
        residuals=given.measured - (d[1:] - d[0] if given.problem.differences else d),
        used=all_weights > 0,
        weights=all_weights,
        cost=judged.best.cost,
        dof=given.problem.dof,
        dop=judged.dop,
        weak=judged.weak,
        plane=judged.plane,
    )


def _too_few(given: Readings) -> Snapshot:
    size = given.problem.prior.size
    nothing = np.full(size, np.nan)
    return Snapshot(
        verdict="too few",
        reason=words.too_few(given.problem.dof + size, size),
        position=nothing,
        covariance=np.full((size, size), np.nan),
        alternatives=(),
        residuals=np.full_like(given.measured, np.nan),
        used=np.zeros(len(given.anchors), bool),
        weights=np.zeros(len(given.anchors)),
        cost=float("nan"),
        dof=given.problem.dof,
        dop=Dop(*np.full(3, np.nan)),
        weak=Weak(nothing, float("nan")),
    )
