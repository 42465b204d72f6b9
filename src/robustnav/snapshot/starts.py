"""Closed-form starts: linearised least squares in the well-spread directions, both signs in the others.

Squaring the ranges makes them linear in the position.  The anchors' principal directions are kept first all, then
without the weakest, then without the two weakest; what the kept ones leave of the ranges is a distance h across the
others, a pair of mirror images or a circle.
"""

from __future__ import annotations

import numpy as np

from robustnav.records import Array, BoolArray
from robustnav.snapshot.core import Problem

CIRCLE = 8  # starts around a line
FARTHEST = 30.0  # in units of the layout's scale


def starts(problem: Problem) -> Array:
    """Return start positions (s, d) [m] for the descent.

    References
    ----------
    Ranges: Beck, Stoica, Li, IEEE Trans. Signal Processing 56 (2008), section II, in the unconstrained form.
    Differences: Chan and Ho, IEEE Trans. Signal Processing 42 (1994), section III; roots as Bancroft, IEEE Trans.
    Aerospace and Electronic Systems 21 (1985).
    """
    known = problem.prior_info > 0
    free = problem.anchors[:, ~known]
    centre = free.mean(axis=0)
    axes = np.linalg.svd(free - centre)[2].T  # columns, strongest first
    found = _from_differences(problem, known, axes) if problem.differences else _from_ranges(problem, known, axes)
    out = np.tile(np.where(known, problem.prior, 0.0), (len(found) + 1, 1))
    out[:, ~known] = np.vstack([*found, centre + 1e-2 * problem.scale * axes.sum(axis=1)])
    # a start in the far field, where the closed form blows up, is drawn in along its direction
    off = out[:, ~known] - centre
    length = np.maximum(np.linalg.norm(off, axis=1, keepdims=True), 1e-300)
    out[:, ~known] = centre + off * np.minimum(1.0, FARTHEST * problem.scale / length)
    return out


def _from_ranges(problem: Problem, known: BoolArray, axes: Array) -> list[Array]:
    """Return starts in the free coordinates from ranges."""
    rise = (problem.prior - problem.anchors)[:, known]
    squared = problem.ranges**2 - (rise * rise).sum(axis=1)
    info = np.diag(problem.W)
    weight = info / (np.maximum(squared, 0.0) + 1.0 / info)
    weight /= weight.sum()
    centre = weight @ problem.anchors[:, ~known]
    B = problem.anchors[:, ~known] - centre
    half = 0.5 * ((B * B).sum(axis=1) - squared)
    root = np.sqrt(weight)
    found = []
    for kept in range(axes.shape[1], max(axes.shape[1] - 3, 0), -1):
        V = axes[:, :kept]
        y = V @ np.linalg.lstsq(root[:, None] * (B @ V), root * (half - weight @ half), rcond=None)[0]
        off = y - B
        left = weight @ (squared - (off * off).sum(axis=1))
        found += _across(centre + y, left, axes[:, kept:], _noise(problem))
    return found


def _from_differences(problem: Problem, known: BoolArray, axes: Array) -> list[Array]:
    """Return starts in the free coordinates from range differences to the first anchor."""
    E_all = problem.anchors[1:] - problem.anchors[0]
    E, y_known = E_all[:, ~known], (problem.prior - problem.anchors[0])[known]
    delta = problem.ranges[1:] - problem.ranges[0]
    right = 0.5 * ((E_all * E_all).sum(axis=1) - delta**2) - E_all[:, known] @ y_known
    noise = _noise(problem)
    fixed, origin = float(y_known @ y_known), problem.anchors[0, ~known]
    found = []
    for kept in range(axes.shape[1], max(axes.shape[1] - 3, 0), -1):
        V = axes[:, :kept]
        weak = axes[:, kept:]
        sol = np.linalg.lstsq(np.column_stack([E @ V, delta]), right, rcond=None)[0]
        y, rho = V @ sol[:-1], sol[-1]
        found += _across(origin + y, rho**2 - y @ y - fixed, weak, noise)
        # from far away the differences only tell the direction
        wave = V @ np.linalg.lstsq(E @ V, -delta, rcond=None)[0]
        far = _across(wave, 1.0 - wave @ wave, weak, 0.01)
        found += [origin + FARTHEST * problem.scale * w / max(float(np.linalg.norm(w)), 1e-300) for w in far]
    g, w = np.linalg.lstsq(E, np.column_stack([right, -delta]), rcond=None)[0].T
    roots = _quadratic(w @ w - 1.0, g @ w, g @ g + fixed)
    found += [origin + g + w * rho for rho in roots if rho > 0.0]
    return found


def _noise(problem: Problem) -> float:
    """Return the size of the noise in a squared distance across a plane or line [m^2]."""
    return float(problem.scale / np.sqrt(np.max(np.diag(problem.W))))


def _across(base: Array, left: float, weak: Array, noise: float) -> list[Array]:
    """Return points at the squared distance ``left`` from ``base`` across the weak directions (d, 0 to 2 columns)."""
    if weak.shape[1] == 0:
        return [base]
    # its own noise keeps the two sides apart when the tag is in the plane
    h = np.sqrt(max(left, 0.25 * noise))
    if weak.shape[1] == 1:
        return [base + h * weak[:, 0], base - h * weak[:, 0]]
    angle = np.arange(CIRCLE) * (2.0 * np.pi / CIRCLE)
    return list(base + h * (np.cos(angle)[:, None] * weak[:, 0] + np.sin(angle)[:, None] * weak[:, 1]))


def _quadratic(a: float, b: float, c: float) -> list[float]:
    """Return the real roots of ``a x^2 + 2 b x + c``; the vertex when noise made them complex."""
    q = -(b + np.copysign(np.sqrt(max(b * b - a * c, 0.0)), b))
    return [float(n / m) for n, m in ((q, a), (c, q)) if m != 0.0]
