"""Whether a layout is bound in every direction, and whether its ellipsoid tells the truth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robustnav.records import Array
from robustnav.snapshot.honest import quantile
from robustnav.survey.network import End, Network, Tie, anchor_information, cost, descend, normal, plain, residuals
from robustnav.survey.record import Options

SINGULAR = 1e-9  # share of the largest information below which a direction is not bound
PROBED = 6  # weakest directions whose ellipsoid is checked
PROBES = (1.0, -1.0, 0.5, -0.5)  # of the ellipsoid that holds all coordinates together
GIVEN_UP = 0.5  # an ellipsoid short by more than a factor of 1.4
FIRM = 1e4  # how much firmer than the layout itself a probe holds its place
FULL = 300  # unknowns up to which all directions are looked at
BETWEEN = np.linspace(0.0, 1.0, 9)[1:-1]


class Bound(NamedTuple):
    """How well a layout is bound.

    ``covariance`` (c, c) of the anchors' unknown coordinates, NaN where singular, drawn out where the cost is flatter
    than its ellipsoid; ``direction`` (c,) and ``sd`` [m] of the weakest; ``cause`` of a degenerate one, or empty.
    """

    covariance: Array
    direction: Array
    sd: float
    cause: str


def spare(end: End, network: Network) -> int:
    """Return the degrees of freedom that test the residuals of a layout.

    A direction so weak that ranges bend before its sd is reached takes up no residual: anchors in a row cannot step
    aside to let the sum of two ranges meet a third.  It counts as no unknown.
    """
    if np.count_nonzero(network.free) > FULL:
        return network.dof
    values = np.linalg.eigvalsh(plain(normal(end.p, network)[0]))
    used = network.info > 0
    typical = float(np.median(network.info[used]) ** -0.5)
    straight = float(np.median(network.distance[used])) * typical
    weak = int(np.count_nonzero(values * straight < 1.0))
    return network.dof + weak


def bound(end: End, network: Network, options: Options) -> Bound:
    """Return how well the anchors of a layout are bound."""
    info = anchor_information(end.p, network)
    if not info.size:
        return Bound(info, np.zeros(0), 0.0, "")
    values, vectors = np.linalg.eigh(info)
    typical = float(np.median(network.info[network.info > 0]) ** -0.5)
    if not values[0] > SINGULAR * values[-1]:
        return Bound(np.full_like(info, np.nan), vectors[:, 0], float("inf"), "no range bounds it")
    covariance = (vectors / values) @ vectors.T
    sd, cause = float(values[0] ** -0.5), ""
    if sd > options.max_dilution * typical:
        cause = f"its sd is {sd / typical:.0f} times that of a range"
    for k in range(min(PROBED, len(values))):
        share = _share(end, network, (vectors[:, k], float(values[k] ** -0.5)), options.confidence)
        if share < GIVEN_UP:
            cause = cause or "ranges change too little with it for a first-order sd"
            return Bound(covariance, vectors[:, k], float(values[k] ** -0.5), cause)
        covariance = covariance + (1.0 / share - 1.0) / values[k] * np.outer(vectors[:, k], vectors[:, k])
    return Bound(covariance, vectors[:, 0], sd, cause)


def _share(end: End, network: Network, axis: tuple[Array, float], confidence: float) -> float:
    """Return how much of the rise promised along an axis (direction, sd) the cost shows, 0 to 1.

    At points along both halves the cost is minimised across the axis.
    """
    direction, sd = axis
    reach = sd * float(np.sqrt(quantile(confidence, direction.size)))
    if _straight(end.p, network, reach):
        return 1.0
    start = end.p[network.free]
    whole = np.zeros(start.size)
    whole[: direction.size] = direction
    share = 1.0
    for probe in PROBES:
        p = end.p.copy()
        p[network.free] += probe * reach * whole
        q = descend(p, network, Tie(whole, start, probe * reach, FIRM / sd**2), max_steps=12).p
        gone = float(whole @ (q[network.free] - start))
        share = min(share, (cost(q, network) - end.cost) / max((gone / sd) ** 2, 1e-12))
    return max(share, 0.0)


def _straight(p: Array, network: Network, reach: float) -> bool:
    """Return whether every range is linear within ``reach`` [m] to a tenth of its noise."""
    d = network.distance - residuals(p, network)[0]
    used = network.info > 0
    if not d[used].min(initial=np.inf) > 4.0 * reach:
        return False
    # both ends may move
    return bool(np.all(2.0 * reach**2 / d[used] * np.sqrt(network.info[used]) < 0.1))


def parted(a: Array, b: Array, network: Network, confidence: float) -> bool:
    """Return whether the cost between two layouts stands clear above both: two places, not one long region."""
    ends = max(cost(a, network), cost(b, network))
    highest = max(cost(a + share * (b - a), network) for share in BETWEEN)
    return highest > ends + quantile(confidence, 1)
