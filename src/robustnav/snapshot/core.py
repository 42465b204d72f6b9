"""The numbers: residual cost, its derivatives and damped Gauss-Newton, on plain arrays, many starts at once.

A problem is k anchors, k ranges and a k-by-k information matrix W of the range errors.  Range differences are ranges
with an unknown common offset: the same arrays with a W that sends the vector of ones to zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robustnav.records import Array, BoolArray

MAX_STEPS = 16
SETTLED = 1e-10  # squared distance to the minimum in units of the estimate's own covariance
SINGULAR = 1e-12  # share of the largest eigenvalue below which information is rounding


class Problem(NamedTuple):
    """Arrays of one instant.

    ``anchors`` (k, d) m; ``ranges`` (k,) m; ``W`` (k, k) information of their errors, 1/m^2; ``prior`` (d,) and
    ``prior_info`` (d,): known coordinates [m] and their information [1/m^2], zero where unknown;
    ``differences``: whether W leaves a common offset free; ``scale``: a length of the layout [m].
    """

    anchors: Array
    ranges: Array
    W: Array
    prior: Array
    prior_info: Array
    differences: bool
    scale: float

    @property
    def dof(self) -> int:
        """Readings and known coordinates minus unknowns."""
        return len(self.ranges) - int(self.differences) + int(np.count_nonzero(self.prior_info)) - self.prior.size


class Minima(NamedTuple):
    """End points of a descent: ``p`` (s, d), ``cost`` (s,), ``settled`` (s,) and the number of steps taken (s,)."""

    p: Array
    cost: Array
    settled: BoolArray
    steps: Array


def scale_of(anchors: Array, ranges: Array) -> float:
    """Return a length of the layout [m]: the farthest anchor from their mean, or the largest range if larger."""
    off = anchors - anchors.sum(axis=0) / max(len(anchors), 1)
    reach = np.sqrt((off * off).sum(axis=1).max(initial=0.0))
    return max(float(reach), float(np.abs(ranges).max(initial=0.0)), 1e-9)


def distances(p: Array, anchors: Array) -> tuple[Array, Array]:
    """Return distances (s, k) and unit vectors from anchor to tag (s, k, d); the zero vector on an anchor itself."""
    away = p[:, None, :] - anchors
    d = np.sqrt(np.einsum("skd,skd->sk", away, away))
    away /= np.maximum(d, 1e-300)[..., None]
    return d, away


def residuals(d: Array, problem: Problem) -> Array:
    """Return measured minus predicted (s, k) at distances (s, k); of differences against the first anchor."""
    e = problem.ranges - d
    # W ignores a common offset only to rounding, which far away is larger than the residuals
    return e - e[:, :1] if problem.differences else e


def cost(p: Array, problem: Problem) -> Array:
    """Return the weighted sum of squared residuals (s,) at positions (s, d)."""
    e = residuals(distances(p, problem.anchors)[0], problem)
    off = p - problem.prior
    return _dot(e @ problem.W, e) + _dot(off, off * problem.prior_info)


def expand(p: Array, problem: Problem) -> tuple[Array, Array, Array]:
    """Return cost (s,), half its gradient (s, d) and its Gauss-Newton information (s, d, d)."""
    d, u = distances(p, problem.anchors)
    e = residuals(d, problem)
    off = p - problem.prior
    pull = off * problem.prior_info
    We = e @ problem.W
    half_gradient = pull - np.einsum("sk,skd->sd", We, u)
    info = u.swapaxes(1, 2) @ (problem.W @ u)
    np.einsum("sii->si", info)[...] += problem.prior_info
    return _dot(We, e) + _dot(off, pull), half_gradient, info


def descend(p: Array, problem: Problem, basis: Array | None = None, max_steps: int = MAX_STEPS) -> Minima:
    """Go downhill from positions (s, d) by Gauss-Newton with Levenberg damping.

    Parameters
    ----------
    p : (s, d) starts [m].
    problem : what to fit.
    basis : (s, d, f) directions in which each start may move; None for all.
    max_steps : evaluations after which a start counts as not settled.

    Returns
    -------
    minima : end points; a start is settled once the next step would be below 1e-5 of the estimate's own sd.

    References
    ----------
    Marquardt, SIAM J. Appl. Math. 11 (1963); Nocedal and Wright, Numerical Optimization (2006), section 10.3.
    """
    p, cap = p.copy(), 2.0 * problem.scale
    damping, steps = np.full(len(p), 1e-3), np.zeros(len(p), int)
    settled = np.zeros(len(p), bool)
    value, gradient, info = expand(p, problem)
    for _ in range(max_steps):
        step, decrement = _step(gradient, info, damping, basis)
        off = p - problem.anchors[0]
        length, limit = np.sqrt(_dot(step, step)), np.maximum(cap, np.sqrt(_dot(off, off)))
        trial = p + step * (limit / np.maximum(limit, length))[:, None]
        new_value, new_gradient, new_info = expand(trial, problem)
        better = (new_value <= value) & ~settled
        steps += ~settled
        # no step however small goes down any more: rounding ends the descent as well
        settled |= (decrement < SETTLED) & (damping <= 1e-2) | (damping > 1e12)
        p[better], value[better], gradient[better] = trial[better], new_value[better], new_gradient[better]
        info[better] = new_info[better]
        damping *= np.where(better, 0.1, 10.0)
        np.maximum(damping, 1e-9, out=damping)
        if settled.all():
            break
    return Minima(p, value, settled, steps)


def _dot(a: Array, b: Array) -> Array:
    """Return the scalar products of rows."""
    out: Array = np.einsum("sk,sk->s", a, b)
    return out


def _step(gradient: Array, info: Array, damping: Array, basis: Array | None) -> tuple[Array, Array]:
    """Return damped steps (s, d) and the squared length of each in units of the covariance it stands on (s,)."""
    if basis is not None:
        gradient = (gradient[:, None, :] @ basis)[:, 0]
        info = basis.swapaxes(1, 2) @ info @ basis
    damped = info.copy()
    diagonal = np.einsum("sii->si", damped)  # a view
    diagonal *= 1.0 + damping[:, None]
    diagonal += SINGULAR * np.einsum("sii->s", info)[:, None] + 1e-300
    step = np.asarray(-np.linalg.solve(damped, gradient[..., None])[..., 0], float)
    decrement = -_dot(gradient, step)
    if basis is not None:
        step = (basis @ step[..., None])[..., 0]
    return step, decrement


def covariance_of(info: Array) -> tuple[Array, Array, Array]:
    """Return the inverse (d, d) of information (d, d), NaN if singular, its eigenvalues (ascending) and vectors."""
    values, vectors = np.linalg.eigh(info)
    # one direction 1e5 times weaker than another: first-order numbers mean nothing there
    if not values[0] > 1e-10 * values[-1]:
        return np.full_like(info, np.nan), values, vectors
    return (vectors / values) @ vectors.T, values, vectors


def without(problem: Problem, anchor: int) -> Problem:
    """Return the problem with one anchor's error left entirely free, which removes the anchor.

    For range differences this works for the reference like for any other anchor.
    """
    keep = np.arange(len(problem.ranges)) != anchor
    column, own = problem.W[keep, anchor], problem.W[anchor, anchor]
    W = problem.W[np.ix_(keep, keep)] - np.outer(column, column) / own
    anchors, ranges = problem.anchors[keep], problem.ranges[keep]
    return problem._replace(anchors=anchors, ranges=ranges, W=0.5 * (W + W.T), scale=scale_of(anchors, ranges))


def inflated(problem: Problem, extra_variance: Array) -> Problem:
    """Return the problem with independent error variance (k,) [m^2] added to the anchors."""
    root = np.sqrt(extra_variance)
    inner = np.eye(root.size) + root[:, None] * problem.W * root
    W = problem.W - (problem.W * root) @ np.linalg.solve(inner, root[:, None] * problem.W)
    return problem._replace(W=0.5 * (W + W.T))
