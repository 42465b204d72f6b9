"""Which ranges do not fit: one left out after the other where ranges are few, reweighting where they are many."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from robustnav.records import Array, IntArray
from robustnav.snapshot.honest import quantile
from robustnav.survey.build import Task
from robustnav.survey.minima import minima, starts
from robustnav.survey.network import RIDGE, End, Network, damped, descend, jacobian, normal, plain, residuals, solver
from robustnav.survey.record import Options

FEW = 60  # ranges up to which each is left out in turn
HUBER, STUDENT = 1.345, 4.0  # 95 % and about 93 % efficient on clean ranges
MAD_TO_SD = 1.482602218505602
ROUNDS = 30
INNER_STEPS = 3  # of the descent before weights are taken anew
LEAST_CHECKED = 0.05  # share of a range's variance that others must check before its residual says anything
OUTSIDE = 4.0  # sds beyond which a range is left out: of clean ones one in 16 000


class Repair(NamedTuple):
    """Ranges ``left_out`` (rows), the ``task`` without them and its layouts, those of rival choices, the ratio
    ``scale`` of what residuals remain to their sds, and whether every single range was ``tried`` in turn.
    """

    left_out: IntArray
    task: Task
    ends: list[End]
    rivals: list[tuple[int, End]]
    scale: float
    tried: bool


def repair(task: Task, ends: list[End], options: Options) -> Repair:
    """Return a layout of the ranges that agree."""
    network = task.network
    if np.count_nonzero(network.info) <= FEW:
        found = _one_by_one(task, ends, options)
        if found is not None:
            return found
    # least squares may have gone astray for the wrong ranges, so the first starts count beside its layouts
    begins = [*(end.p for end in ends[:2]), *islice(starts(task), 2)]
    best = min((_reweighted(p, network, options.loss) for p in begins), key=lambda one: one[1])
    p, rest = best[0], network
    for _ in range(ROUNDS):
        e = standardised(p, network, rest)
        out = np.abs(e) > OUTSIDE * _spread(e[rest.info > 0])
        same = bool((out == (rest.info < network.info)).all())
        rest = replace(network, info=np.where(out, 0.0, network.info))
        p = descend(p, rest).p
        if same:
            break
    left_out = np.flatnonzero(rest.info < network.info)
    fresh = minima(task._replace(network=rest), options.confidence, p)
    excess = fresh[0].cost / max(rest.dof, 1)
    fits = fresh[0].cost <= quantile(options.confidence, rest.dof)
    return Repair(left_out, task._replace(network=rest), fresh, [], 1.0 if fits else float(np.sqrt(excess)), False)


def _one_by_one(task: Task, ends: list[End], options: Options) -> Repair | None:
    """Return the single range without which the others agree, with all others that would explain as much, or None."""
    network, margin = task.network, quantile(options.confidence, 1)
    if network.dof < 2:  # nothing would test the rest
        return None
    limit = quantile(options.confidence, network.dof - 1)
    fits: list[tuple[float, int, Task, list[End]]] = []
    for row in np.flatnonzero(network.info):
        info = network.info.copy()
        info[row] = 0.0
        rest = replace(network, info=info)
        # a wrong range may have drawn all starts aside, so the quick look is only a filter
        if min(descend(end.p, rest).cost for end in ends) > 4.0 * limit:
            continue
        other = task._replace(network=rest)
        found = minima(other, options.confidence)
        if found[0].cost <= limit:
            fits.append((found[0].cost, int(row), other, found))
    if not fits:
        return None
    fits.sort(key=lambda fit: fit[0])
    rivals = [(fit[1], fit[3][0]) for fit in fits[1:] if fit[0] <= fits[0][0] + margin]
    return Repair(np.array([fits[0][1]]), fits[0][2], fits[0][3], rivals, 1.0, True)


def standardised(p: Array, network: Network, fitted: Network) -> Array:
    """Return residuals (m,) in units of their own sds at a layout fitted to some of the ranges.

    A range in the fit draws it to itself: its residual has the share r of the variance that the others check, one left
    out has the whole and that of the fit (Baarda, Netherlands Geodetic Commission (1968)).
    """
    J = jacobian(p, fitted)[0][: len(network.ends)]
    A = normal(p, fitted)[0]
    solve = solver(damped(A, 0.0, RIDGE * float(A.diagonal().mean()) + 1e-300))
    J = plain(J)
    pulled = network.info * np.einsum("mu,um->m", J, solve(J.T))
    share = np.where(fitted.info > 0, np.maximum(1.0 - pulled, LEAST_CHECKED), 1.0 + pulled)
    return np.asarray(residuals(p, network)[0] * np.sqrt(network.info / share), float)


def _spread(e: Array) -> float:
    """Return the scale of residuals in sds, 1 at least: an sd given too small must not make half the ranges wrong."""
    return max(1.0, MAD_TO_SD * float(np.median(np.abs(e))))


def _reweighted(p: Array, network: Network, loss: str) -> tuple[Array, float]:
    """Return a layout after iterated reweighting, and its robust cost.

    References
    ----------
    Holland and Welsch, Communications in Statistics A6 (1977); Huber, and Student-t with four degrees of freedom.
    """
    cost, scale = np.inf, 1.0
    for _ in range(ROUNDS):
        e = residuals(p, network)[0] * np.sqrt(network.info)
        scale = _spread(e)
        u = np.abs(e) / scale
        w = HUBER / np.maximum(u, HUBER) if loss == "huber" else (STUDENT + 1.0) / (STUDENT + u * u)
        p = descend(p, replace(network, info=network.info * w / scale**2), max_steps=INNER_STEPS).p
        new = _robust_cost(residuals(p, network)[0] * np.sqrt(network.info) / scale, loss)
        if abs(new - cost) < 1e-5 * max(new, 1.0):
            break
        cost = new
    return p, cost + len(network.info) * float(np.log(scale))


def _robust_cost(u: Array, loss: str) -> float:
    if loss == "huber":
        a = np.abs(u)
        return float(np.where(a <= HUBER, 0.5 * a * a, HUBER * (a - 0.5 * HUBER)).sum())
    return float((0.5 * (STUDENT + 1.0) * np.log1p(u * u / STUDENT)).sum())
