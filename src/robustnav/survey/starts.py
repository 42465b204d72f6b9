"""Where to begin: distances between anchors as far as ranges tell or bound them, classical scaling, and growing.

Torgerson, Psychometrika 17 (1952): classical multidimensional scaling.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robustnav.records import Array, BoolArray, IntArray
from robustnav.snapshot.core import Problem, distances, scale_of
from robustnav.snapshot.honest import Survey, quantile, survey
from robustnav.survey.build import Task
from robustnav.survey.network import Network, far_ends

EXACT_SD = 1e-3  # m: how firmly an exact coordinate is held while one node is placed
NUDGE = 0.05  # of the layout's size: places nodes whose ranges leave a circle
CONFIDENCE = 0.999
FEW = 8  # ranges up to which one that is wrong cannot be told by looking at the others
TRIMS, TRIM = 4, 5.0  # rounds, and medians of the absolute residual beyond which a range of many is left out


def connected(task: Task) -> IntArray:
    """Return the number of the group (anchors,) to which ranges, or known positions, tie each anchor."""
    network = task.network
    group = np.arange(len(network.known))
    used = network.info > 0
    ties = list(network.ends[used]) + list(network.bends)
    if task.first is None:
        ties.append(np.flatnonzero((network.known_info[: network.anchors, :2] > 0).any(axis=1)))
    changed = True
    while changed:
        before = group.copy()
        for tie in ties:
            group[tie] = group[tie].min()
        changed = bool((group != before).any())
    return group[: network.anchors]


def anchor_distances(network: Network) -> Array:
    """Return distances between anchors (k, k) [m]: ranged, known, or midway between their bounds.

    A tag hears two anchors at r and s: they are at least |r - s| and at most r + s apart.  Chains of ranges bound
    the others from above.
    """
    k = network.anchors
    low, high = np.zeros((k, k)), np.full((k, k), np.inf)
    np.fill_diagonal(high, 0.0)
    used = network.info > 0
    for knot, rows in _rows_by_knot(network, used):
        if knot < k:
            continue
        anchor, r = network.ends[rows, 0], network.distance[rows]
        high[np.ix_(anchor, anchor)] = np.minimum(high[np.ix_(anchor, anchor)], r[:, None] + r)
        low[np.ix_(anchor, anchor)] = np.maximum(low[np.ix_(anchor, anchor)], np.abs(r[:, None] - r))
    between = used & (network.ends[:, 1] < k)
    _set_means(low, high, network.ends[between, :2], network.distance[between])
    fixed = np.flatnonzero((network.known_info[:k] > 0).all(axis=1))
    apart = network.known[fixed, None] - network.known[fixed]
    low[np.ix_(fixed, fixed)] = high[np.ix_(fixed, fixed)] = np.linalg.norm(apart, axis=2)
    np.fill_diagonal(low, 0.0)
    np.fill_diagonal(high, 0.0)
    for via in range(k):
        np.minimum(high, high[:, via, None] + high[via], out=high)
    for via in range(k):
        np.maximum(low, low[:, via, None] - high[via], out=low)  # nothing less is known where high is infinite
    # what no stamp and no chain of ranges bounds: a smooth track alone ties it to the rest
    high[np.isinf(high)] = 2.0 * float(network.distance[used].max())
    return np.asarray(0.5 * (np.minimum(low, high) + high), float)


def _rows_by_knot(network: Network, used: BoolArray) -> Iterable[tuple[int, IntArray]]:
    """Yield each node at the far end with the rows of its ranges; a range between two knots counts for the nearer."""
    node = np.where(network.share < 0.5, network.ends[:, 1], network.ends[:, 2])
    rows = np.flatnonzero(used)
    rows = rows[np.argsort(node[rows], kind="stable")]
    cuts = np.flatnonzero(np.diff(node[rows])) + 1
    for part in np.split(rows, cuts):
        if part.size:
            yield int(node[part[0]]), part


def _set_means(low: Array, high: Array, pairs: IntArray, distance: Array) -> None:
    """Write the mean range of each pair of anchors into both bounds."""
    if not len(pairs):
        return
    both, number = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    mean = np.bincount(number.ravel(), distance) / np.bincount(number.ravel())
    for (i, j), d in zip(both, mean, strict=True):
        low[i, j] = low[j, i] = high[i, j] = high[j, i] = d


def scaled(distance: Array, dims: int) -> Array:
    """Return points (k, 3) whose distances come near ``distance`` (k, k), in ``dims`` dimensions."""
    k = len(distance)
    centre = np.eye(k) - 1.0 / k
    values, vectors = np.linalg.eigh(-0.5 * centre @ distance**2 @ centre)
    out = np.zeros((k, 3))
    top = min(dims, k)
    out[:, :top] = (vectors * np.sqrt(np.maximum(values, 0.0)))[:, ::-1][:, :top]
    return out


def anchor_start(task: Task, dims: int = 3) -> Array:
    """Return a first layout (k, 3) in the frame as laid, from distances alone, flattened to ``dims`` dimensions."""
    network = task.network
    k, distance = network.anchors, anchor_distances(network)
    if (network.known_info[:k, 2] > 0).all():
        z = network.known[:k, 2]
        flat = scaled(np.sqrt(np.maximum(distance**2 - (z[:, None] - z) ** 2, 0.0)), min(dims, 2))
        flat[:, 2] = z
    else:
        flat = scaled(distance, dims)
    return to_frame(flat, task.first, task.level) if task.first else _onto_known(flat, network, task.level)


def to_frame(p: Array, first: tuple[int, int, int], level: bool) -> Array:
    """Return nodes (n, 3) turned and shifted so that three of them lay the frame, the third at y > 0."""
    origin, axis, plane = (p[row] for row in first)
    flat = np.array([1.0, 1.0, 0.0]) if level else np.ones(3)
    x = _unit((axis - origin) * flat, np.array([1.0, 0.0, 0.0]))
    beside = (plane - origin) * flat
    y = beside - (beside @ x) * x
    if level:
        y = _unit(y, np.array([-x[1], x[0], 0.0]))
        return np.asarray((p - origin * flat) @ np.stack([x, y, [0.0, 0.0, 1.0]], axis=1), float)
    y = _unit(y, np.linalg.svd(x[None])[2][1])
    return np.asarray((p - origin) @ np.stack([x, y, np.cross(x, y)], axis=1), float)


def _unit(v: Array, otherwise: Array) -> Array:
    size = float(np.linalg.norm(v))
    return v / size if size > 1e-9 else otherwise


def _onto_known(p: Array, network: Network, level: bool) -> Array:
    """Return the layout laid on the known positions: rotation or reflection, whichever fits better."""
    k = network.anchors
    rows = (network.known_info[:k, :2] > 0).all(axis=1) & ((network.known_info[:k, 2] > 0) | level)
    source, target = p[rows], network.known[:k][rows]
    middle, aim = source.mean(axis=0), target.mean(axis=0)
    off, off_aim = source - middle, target - aim
    if level:
        off, off_aim = off * [1, 1, 0], off_aim * [1, 1, 0]
    left, _, right = np.linalg.svd(off.T @ off_aim)
    turn = left @ right
    if level:  # heights stay
        turn[2], turn[:, 2] = 0.0, 0.0
        turn[2, 2] = 1.0
        middle, aim = middle * [1, 1, 0], aim * [1, 1, 0]
    return np.asarray((p - middle) @ turn + aim, float)


def grow(p: Array, located: BoolArray, network: Network) -> Array:
    """Return all nodes (n, 3): those ``located`` (n,) as in ``p``, the others placed one after the other by ranges.

    A node with no place yet, with two, or with ranges that contradict each other waits until every other is placed:
    what comes then may decide.
    """
    p, located = np.where(located[:, None], p, np.nan), located.copy()
    p[network.free == 0] = network.known[network.free == 0]
    tries = {int(node): _partners(int(node), network) for node in np.flatnonzero(~located)}
    waiting: dict[int, int] = {}
    while tries:
        counts = {node: int(located[others].all(axis=1).sum()) for node, (_, others) in tries.items()}
        ready = [node for node in tries if counts[node] > waiting.get(node, -1)]
        # knots first: an anchor placed by few stamps would draw the others aside
        node = max(ready or tries, key=lambda one: (one >= network.anchors, counts[one], -one))
        rows, others = tries[node]
        places, agree = _places(node, p, network, rows[located[others].all(axis=1)])
        if ready and (len(places) != 1 or not agree):
            waiting[node] = counts[node]
            continue
        before = p[node - 1] if node > network.anchors and located[node - 1] else None
        p[node] = _chosen(places, before) if places else _lost(node, p, network, before)
        located[node] = True
        del tries[node]
    return p


def _partners(node: int, network: Network) -> tuple[IntArray, IntArray]:
    """Return the ranges that place a node and the nodes (c, 2) at their other ends."""
    used = network.info > 0
    near, far = network.ends[:, 0] == node, network.ends[:, 1:] == node
    nearer = np.where(network.share < 0.5, far[:, 0], far[:, 1])
    rows = np.flatnonzero(used & (near | nearer))
    others = np.where(near[rows, None], network.ends[rows, 1:], network.ends[rows, :1])
    return rows, others


def _places(node: int, p: Array, network: Network, rows: IntArray) -> tuple[list[Array], bool]:
    """Return the places of one node that its ranges to located ones allow, none if these are too few.

    And whether they agree: of many ranges most, of few all.
    """
    info = np.minimum(network.known_info[node], EXACT_SD**-2)
    if len(rows) < max(int(np.count_nonzero(info == 0)), 1):
        return [], False
    near = network.ends[rows, 0] == node
    others = np.where(near[:, None], far_ends(p, network)[rows], p[network.ends[rows, 0]])
    problem = _problem(others, network.distance[rows], network.info[rows], (network.known[node], info))
    seen = survey(problem, CONFIDENCE)
    agree = seen.candidates[0].cost <= quantile(CONFIDENCE, problem.dof)
    if not agree and len(rows) > FEW:
        seen, agree = _trimmed(problem, seen), True
    return [one.position for one in seen.candidates], agree


def _problem(others: Array, distance: Array, info: Array, known: tuple[Array, Array]) -> Problem:
    return Problem(others, distance, np.diag(info), *known, False, scale_of(others, distance))


def _trimmed(problem: Problem, seen: Survey) -> Survey:
    """Return the places that most of many ranges allow: those far off the median residual are left out."""
    for _ in range(TRIMS):
        e = problem.ranges - distances(seen.candidates[0].position[None], problem.anchors)[0][0]
        e = np.abs(e - np.median(e))
        keep = e <= TRIM * max(float(np.median(e)), 1e-9)
        if keep.sum() <= FEW:
            break
        info = np.diag(problem.W)[keep]
        rest = _problem(problem.anchors[keep], problem.ranges[keep], info, (problem.prior, problem.prior_info))
        seen = survey(rest, CONFIDENCE)
    return seen


def _chosen(places: list[Array], before: Array | None) -> Array:
    """Return the best place, or the one nearest to that of the knot before."""
    return places[0] if before is None else min(places, key=lambda q: float(np.sum((q - before) ** 2)))


def _lost(node: int, p: Array, network: Network, before: Array | None) -> Array:
    """Return a place for a node with too few ranges: that of the knot before, or off the middle of the others."""
    size = max(float(np.abs(network.distance).max()), 1e-9)
    middle = np.nan_to_num(np.nanmean(p[: network.anchors], axis=0)) if np.isfinite(p).any() else np.zeros(3)
    lost = middle + np.array([1.0, 1.3, 0.7]) * NUDGE * size if before is None else before
    return np.where(network.known_info[node] > 0, network.known[node], lost)
