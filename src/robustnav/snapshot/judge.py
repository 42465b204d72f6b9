"""The verdict on readings that fit: one place, two, or a direction left open."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robustnav.records import Array
from robustnav.snapshot import words
from robustnav.snapshot.core import Problem, covariance_of, distances
from robustnav.snapshot.geometry import Sensing, dop
from robustnav.snapshot.honest import Survey, parted, quantile, shares, stretch
from robustnav.snapshot.record import Candidate, Dop, Options, Plane, Verdict, Weak

RISE = 0.25  # share of the promised rise of the cost below which an ellipsoid is given up: it is off by a factor of 2


class Judgement(NamedTuple):
    """What can be said of the best minimum and of those it is not told from."""

    verdict: Verdict
    reason: str
    best: Candidate
    others: tuple[Candidate, ...]
    weak: Weak
    dop: Dop
    plane: Plane | None


def judge(problem: Problem, seen: Survey, options: Options) -> Judgement:
    """Return the verdict on minima whose residuals fit.

    Degenerate if anything is wrong with the best minimum or the ellipsoid of any; else ambiguous if there are several.
    """
    best, others = seen.candidates[0], seen.candidates[1:]
    _, values, vectors = covariance_of(seen.infos[0])
    sensing = Sensing("differences" if problem.differences else "ranges", bool(problem.prior_info.any()))
    quality = Dop(*(x[0] for x in dop(best.position[None], problem.anchors, sensing)))
    plane = mirror(best.position, others[0].position, problem) if len(others) == 1 else None
    axis, cause = 0, _open_cause(problem, seen, float(quality.gdop), options)
    if not cause:
        radius = float(np.sqrt(quantile(options.confidence, best.position.size)))
        pairs = list(zip(seen.candidates, seen.infos, strict=True))
        risen = [shares(c.position, problem, info, radius) for c, info in pairs]
        axis = int(np.argmin(np.min(risen, axis=0)))
        cause = "bent" if np.min(risen) < RISE else ""
    if cause:
        weak = _weak(best.position, problem, vectors[:, axis], values[axis], quantile(options.confidence, 1))
        best = best._replace(covariance=_widened(best.covariance, weak))
        # along an open direction the other end points are arbitrary
        others, plane = ((), None) if cause == "singular" else (others, plane)
        reason = words.degenerate(cause, weak, others)
        return Judgement("degenerate", reason, best, others, weak, quality, plane)
    best, *rest = (_stretched(c, info, share) for (c, info), share in zip(pairs, risen, strict=True))
    others = tuple(rest)
    weak = Weak(vectors[:, 0], float(np.sqrt(vectors[:, 0] @ best.covariance @ vectors[:, 0])))
    if others:
        return Judgement("ambiguous", words.ambiguous(best, others, plane), best, others, weak, quality, plane)
    return Judgement("unique", words.unique(best, quality, problem.dof), best, (), weak, quality, None)


def _open_cause(problem: Problem, seen: Survey, gdop: float, options: Options) -> str:
    """Return why no ellipsoid can be given, empty if one can."""
    best, others = seen.candidates[0], seen.candidates[1:]
    if np.isnan(best.covariance).any():
        return "singular"
    if not seen.settled:
        near = distances(best.position[None], problem.anchors)[0][0] < 3.0 / np.sqrt(np.diag(problem.W))
        return "on anchor" if near.any() else "unsettled"
    if not gdop <= options.max_gdop:
        return "gdop"
    rise = quantile(options.confidence, 1)
    return "" if all(parted(best.position, c.position, problem, rise) for c in others) else "merged"


def _stretched(candidate: Candidate, info: Array, share: Array) -> Candidate:
    """Return the candidate with its ellipsoid's axes drawn out to where the cost reaches what they promise."""
    _, values, vectors = covariance_of(info)
    return candidate._replace(covariance=(vectors / (values * share)) @ vectors.T)


def mirror(a: Array, b: Array, problem: Problem) -> Plane | None:
    """Return the plane half-way between two positions if the anchors lie in it, to a tenth of the layout."""
    normal = (b - a) / np.linalg.norm(b - a)
    point = 0.5 * (a + b)
    distance = float(np.sqrt(np.mean(((problem.anchors - point) @ normal) ** 2)))
    return Plane(point, normal, distance) if distance < 0.1 * problem.scale else None


def _weak(p: Array, problem: Problem, direction: Array, info: float, rise: float) -> Weak:
    """Return a weak direction with the larger of its first-order sd and the stretch that the cost really allows."""
    sd = 1.0 / np.sqrt(max(info, 1e-300))
    start = min(sd * np.sqrt(rise), problem.scale)
    reach = stretch(p, problem, direction, float(start), rise)
    # far beyond the layout the first order means nothing, and the stretch alone counts
    return Weak(direction, reach if sd > problem.scale else max(reach, float(sd)))


def _widened(P: Array, weak: Weak) -> Array:
    """Return the covariance with the variance along the weak direction raised to ``weak.sd``."""
    if not np.isfinite(weak.sd):
        return np.full_like(P, np.nan)
    v = weak.direction
    missing = max(weak.sd**2 - float(v @ P @ v), 0.0)
    out: Array = P + missing * np.outer(v, v)
    return out
