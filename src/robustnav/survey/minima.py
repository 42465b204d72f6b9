"""All layouts that fit: from several starts, and from the mirror images of each anchor in what it is ranged to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robustnav.records import Array, BoolArray
from robustnav.snapshot.honest import quantile
from robustnav.survey.build import Task
from robustnav.survey.network import End, Network, anchor_information, descend, far_ends
from robustnav.survey.starts import anchor_start, grow, to_frame

SAME = 0.01  # squared distance in units of the covariance below which two layouts are one
TRIES = 24  # more starts where the first ones do not fit
TRIES_WITH_TAG = 1
ALWAYS = 10  # starts in any case: they find layouts that no single reflection leads to
ALWAYS_WITH_TAG = 1  # many ranges leave little room for layouts that fit by chance
THICKNESS = 0.01  # of the layout's size: no descent leaves a line or plane it begins in exactly
SCALES = (0.1, 0.3, 1.0)  # of the layout's size
MOST = 12  # layouts kept
HOPELESS = 1000.0  # times the limit of the residual test: no more steps for what is still above
LONG = 200  # more steps for descents that crawl along a valley


def minima(task: Task, confidence: float, start: Array | None = None) -> list[End]:
    """Return layouts whose cost is within the one-dimensional quantile of the best one's, best first.

    The search begins at ``start`` (n, 3), or at many places, the same ones every time: equal ranges, equal layouts.
    """
    network, margin = task.network, quantile(confidence, 1)
    limit = quantile(confidence, network.dof)
    found: list[End] = []
    least = ALWAYS if network.free_anchors == np.count_nonzero(network.free) else ALWAYS_WITH_TAG
    for count, begin in enumerate(starts(task) if start is None else [start]):
        if count >= least and found[0].cost <= limit:
            break
        _keep(found, _laid(_down(begin, network, limit), task), task, margin)
    done: list[End] = []
    while len(done) < MOST:
        todo = next((end for end in found if not any(end is one for one in done)), None)
        if todo is None or not todo.settled:
            break
        done.append(todo)
        for image in _images(todo.p, network):
            _keep(found, _laid(descend(image, network), task), task, margin)
    return found[:MOST]


def _down(p: Array, network: Network, limit: float) -> End:
    end = descend(p, network)
    anchors = np.arange(len(p)) < network.anchors
    if end.cost > limit and not anchors.all():
        # a stamp placed on the wrong side by few anchors finds its place by all of them
        again = descend(grow(end.p, anchors, network), network)
        end = min(end, again, key=lambda one: one.cost)
    return end if end.settled or end.cost > HOPELESS * limit else descend(end.p, network, max_steps=LONG)


def starts(task: Task) -> Iterator[Array]:
    """Yield places (n, 3) to begin at: grown from known anchors, scaled from distances, then disturbed."""
    network, k = task.network, task.network.anchors
    located = np.zeros(len(network.known), bool)
    fixed = (network.known_info[:k] > 0).all(axis=1)
    if task.first is None and np.count_nonzero(fixed) >= (2 if task.level else 3):
        located[:k] = fixed
        yield grow(network.known, located, network)
    located[:k] = True
    base = np.zeros_like(network.known)
    rng = np.random.default_rng(0)
    tries = TRIES if network.free_anchors == np.count_nonzero(network.free) else TRIES_WITH_TAG
    # 3, then 2 and 1: from noise out of the plane or line in which anchors stand the descent may not find back
    flat = [(2, THICKNESS), (1, THICKNESS)] if tries == TRIES else []
    plan = [(3, 0.0), *flat, *((3, SCALES[n % len(SCALES)]) for n in range(tries))]
    for dims, spread in plan:
        base[:k] = anchor_start(task, dims)
        base[:k] += spread * np.ptp(base[:k], axis=0).max() * rng.standard_normal((k, 3))
        base[:k] = np.where(network.known_info[:k] > 0, network.known[:k], base[:k])
        yield grow(base, located, network)


def _laid(end: End, task: Task) -> End:
    """Return the layout with the frame's own signs: x of the second and y of the third anchor above 0."""
    if task.first is None or not np.isfinite(end.p).all():
        return end
    return end._replace(p=to_frame(end.p, task.first, task.level))


def _keep(found: list[End], end: End, task: Task, margin: float) -> None:
    """Add a layout to those found if it is new and fits, and drop those it beats."""
    network = task.network
    best = min([end.cost, *(one.cost for one in found)])
    if not end.cost <= best + margin or (not end.settled and found and found[0].settled):
        return
    twins = [end.p] if task.first is None or task.level else [end.p, mirrored(end.p)]
    info = anchor_information(end.p, network)
    free = network.free[: network.anchors]
    for k, other in enumerate(found):
        off = [(p - other.p)[: network.anchors][free] for p in twins]
        if min(float(o @ info @ o) for o in off) < SAME:
            if end.cost < other.cost:
                found[k] = end
            break
    else:
        found.append(end)
    found[:] = sorted((one for one in found if one.cost <= best + margin), key=lambda one: one.cost)


def mirrored(p: Array) -> Array:
    """Return the mirror image of nodes (n, 3) in the plane z = 0."""
    return np.asarray(p * np.array([1.0, 1.0, -1.0]), float)


def _images(p: Array, network: Network) -> Iterator[Array]:
    """Yield layouts with one anchor, or all that is not known, mirrored in the best plane of what it is ranged to."""
    k, used = network.anchors, network.info > 0
    far = far_ends(p, network)
    movable = network.free & ~(network.known_info > 0)
    for anchor in np.flatnonzero(movable[:k].any(axis=1)):
        near, other = used & (network.ends[:, 0] == anchor), used & (network.ends[:, 1] == anchor)
        partners = np.concatenate([far[near], p[network.ends[other, 0]]])
        row = np.zeros(len(p), bool)
        row[anchor] = True
        if len(partners):
            yield reflected(p, row, partners, movable)
    held = np.asarray(~movable[:k].any(axis=1))
    if held.any() and not held.all():
        yield reflected(p, np.asarray(movable.any(axis=1)), p[:k][held], movable)


def reflected(p: Array, rows: BoolArray, through: Array, movable: BoolArray) -> Array:
    """Return nodes with some rows mirrored in the best plane of points (c, 3); upright where heights are known."""
    upright = not movable[rows, 2].all()
    middle = through.mean(axis=0)
    off = (through - middle) * (np.array([1.0, 1.0, 0.0]) if upright else 1.0)
    normals = np.linalg.svd(off)[2]
    normal = normals[2]
    if upright:
        normal = next(v for v in normals[::-1] if abs(v[2]) < 0.5)
    out = p.copy()
    moved = p[rows] - 2.0 * ((p[rows] - middle) @ normal)[:, None] * normal
    out[rows] = np.where(movable[rows], moved, p[rows])
    return out
