"""The numbers: nodes, ranges between them, what is known of them, and damped Gauss-Newton over all at once.

Nodes are the anchors, then the knots of the tag's track.  The far end of a range lies on the straight line between two
nodes, or on one (the same twice): so a range to a moving tag needs no node of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from robustnav.records import Array, BoolArray, IntArray

MAX_STEPS = 60
SETTLED = 1e-10  # squared distance to the minimum in units of the estimate's own covariance
DENSE = 40000  # entries of a Jacobian up to which plain matrices are faster
RIDGE = 1e-10  # of the mean information: keeps a tag that too few ranges place from stopping the anchors


@dataclass(frozen=True)
class Network:
    """Arrays of one survey.

    Parameters
    ----------
    anchors : number of nodes that are anchors.
    ends : (m, 3) near end of each range, and the two nodes between which its far end lies.
    share : (m,) how far along from the first of these to the second, 0 to 1.
    distance, info : (m,) m, and 1 / variance [1/m^2], 0 for a range left out.
    known, known_info : (n, 3) coordinates [m] and their information: 0 unknown, infinite exact.
    bends : (s, 3) knots of a smooth track, one after the other; ``bend_weights`` (s, 3) that make their acceleration.
    bend_info : (s,) its information [s^4/m^2].
    """

    anchors: int
    ends: IntArray
    share: Array
    distance: Array
    info: Array
    known: Array
    known_info: Array
    bends: IntArray
    bend_weights: Array
    bend_info: Array

    @cached_property
    def free(self) -> BoolArray:
        """Coordinates (n, 3) that are searched for."""
        return np.isfinite(self.known_info)

    @cached_property
    def free_anchors(self) -> int:
        """Number of coordinates of anchors among them; they come first."""
        return int(np.count_nonzero(self.free[: self.anchors]))

    @cached_property
    def dof(self) -> int:
        """Ranges in use, known coordinates and bends minus unknowns."""
        held = np.count_nonzero(self.known_info[self.free])
        given = np.count_nonzero(self.info) + held + 3 * np.count_nonzero(self.bend_info)
        return int(given) - int(np.count_nonzero(self.free))

    @cached_property
    def _column(self) -> IntArray:
        """Number of each coordinate (n, 3) among the unknowns, -1 where it is exact."""
        out = np.full(self.free.shape, -1)
        out[self.free] = np.arange(np.count_nonzero(self.free))
        return out

    @cached_property
    def _pattern(self) -> tuple[IntArray, IntArray, BoolArray]:
        """Row and column of every entry of the Jacobian of ranges and bends, and which of them are searched for."""
        m, s = len(self.ends), len(self.bends)
        columns = np.concatenate([self._column[self.ends].ravel(), self._column[self.bends].ravel()])
        rows = np.concatenate([np.repeat(np.arange(m), 9), m + _bend_rows(s).ravel()])
        return rows[columns >= 0], columns[columns >= 0], columns >= 0


class End(NamedTuple):
    """Where a descent ended: ``p`` (n, 3), ``cost``, and whether it ``settled``."""

    p: Array
    cost: float
    settled: bool


class Tie(NamedTuple):
    """A wish to stand ``length`` away from ``start`` along ``direction``, all (u,) over unknowns, with ``info``."""

    direction: Array
    start: Array
    length: float
    info: float


def _bend_rows(count: int) -> IntArray:
    """Return for each entry (s, 3 knots, 3 axes) the row of its residual: one for each axis."""
    return 3 * np.arange(count)[:, None, None] + np.broadcast_to(np.arange(3), (count, 3, 3))


def far_ends(p: Array, network: Network) -> Array:
    """Return the far ends (m, 3) of all ranges."""
    s = network.share[:, None]
    return np.asarray((1.0 - s) * p[network.ends[:, 1]] + s * p[network.ends[:, 2]], float)


def residuals(p: Array, network: Network) -> tuple[Array, Array]:
    """Return measured minus predicted (m,) and unit vectors (m, 3) from far to near end."""
    away = p[network.ends[:, 0]] - far_ends(p, network)
    d = np.sqrt(np.einsum("mi,mi->m", away, away))
    return network.distance - d, away / np.maximum(d, 1e-300)[:, None]


def cost(p: Array, network: Network) -> float:
    """Return the weighted sum of squared residuals."""
    e = residuals(p, network)[0]
    off = (p - network.known)[network.free]
    bend = _bend(p, network)
    total = e @ (network.info * e) + off @ (off * network.known_info[network.free])
    return float(total + (network.bend_info[:, None] * bend * bend).sum())


def _bend(p: Array, network: Network) -> Array:
    return np.asarray(np.einsum("sk,ski->si", network.bend_weights, p[network.bends]), float)


def jacobian(p: Array, network: Network) -> tuple[Any, Array, Array]:
    """Return the Jacobian of all predictions (r, u), dense or sparse, and residuals and information (r,)."""
    e, u = residuals(p, network)
    s = network.share[:, None]
    entries = np.stack([u, (s - 1.0) * u, -s * u], axis=1).ravel()
    bends = np.broadcast_to(network.bend_weights[:, :, None], (len(network.bends), 3, 3)).ravel()
    rows, columns, keep = network._pattern
    values = np.concatenate([entries, bends])[keep]
    size = (len(e) + 3 * len(network.bends), int(np.count_nonzero(network.free)))
    right = np.concatenate([e, -_bend(p, network).ravel()])
    info = np.concatenate([network.info, np.repeat(network.bend_info, 3)])
    if size[0] * size[1] <= DENSE:
        J: Any = np.bincount(rows * size[1] + columns, values, size[0] * size[1]).reshape(size)
    else:
        from scipy.sparse import csr_array

        J = csr_array((values, (rows, columns)), shape=size)
    return J, right, info


def normal(p: Array, network: Network) -> tuple[Any, Array]:
    """Return the information of all unknowns (u, u), dense or sparse, and half the downhill gradient (u,)."""
    J, right, info = jacobian(p, network)
    held = network.known_info[network.free]
    off = (p - network.known)[network.free]
    down = J.T @ (info * right) - held * np.where(held > 0, off, 0.0)
    if isinstance(J, np.ndarray):
        A: Any = (J * info[:, None]).T @ J
        A[np.diag_indices(len(A))] += held
        return A, down
    from scipy.sparse import diags_array

    return J.T @ diags_array(info) @ J + diags_array(held), down


def solver(A: Any) -> Callable[[Array], Array]:
    """Return a function that solves A x = b for b (u,) or (u, c)."""
    if isinstance(A, np.ndarray):
        return lambda b: np.asarray(np.linalg.solve(A, b), float)
    from scipy.sparse.linalg import splu

    solve: Callable[[Array], Array] = splu(A.tocsc()).solve
    return solve


def plain(A: Any) -> Array:
    """Return a matrix, dense or sparse, as an array."""
    return np.asarray(A if isinstance(A, np.ndarray) else A.toarray(), float)


def damped(A: Any, damping: float, floor: float) -> Any:
    """Return A with its diagonal raised by a share ``damping`` of itself and by ``floor``."""
    more = damping * A.diagonal() + floor
    if isinstance(A, np.ndarray):
        return A + np.diag(more)
    from scipy.sparse import diags_array

    return A + diags_array(more)


def descend(p: Array, network: Network, tie: Tie | None = None, max_steps: int = MAX_STEPS) -> End:
    """Go downhill from ``p`` (n, 3) by Gauss-Newton with Levenberg damping.

    References
    ----------
    Marquardt, SIAM J. Appl. Math. 11 (1963); Nocedal and Wright, Numerical Optimization (2006), section 10.3.
    """
    p = np.where(network.free, p, network.known)
    cap = 2.0 * float(network.distance.max())
    value, damping, settled = _tied(p, network, tie), 1e-3, False
    A, down = normal(p, network)
    for _ in range(max_steps):
        solve = solver(damped(A, damping, RIDGE * float(A.diagonal().mean()) + 1e-300))
        step, pull = _step(solve, down, tie, p[network.free])
        decrement = float(pull @ step)
        step *= min(1.0, cap / max(float(np.abs(step).max(initial=0.0)), 1e-300))
        trial = p.copy()
        trial[network.free] += step
        new = _tied(trial, network, tie)
        small = decrement < SETTLED and damping <= 1e-2
        if new <= value:
            p, value, damping = trial, new, max(0.1 * damping, 1e-9)
            if not small:
                A, down = normal(p, network)
        else:
            damping *= 10.0
        if small or damping > 1e12:
            settled = True
            break
    return End(p, value, settled)


def _step(solve: Callable[[Array], Array], down: Array, tie: Tie | None, free: Array) -> tuple[Array, Array]:
    """Return the step (u,) and the downhill pull (u,) it answers, of the network and a tie together."""
    if tie is None:
        return solve(down), down
    gap = tie.length - float(tie.direction @ (free - tie.start))
    pull = down + tie.info * gap * tie.direction
    # the tie adds one rank to the matrix, which would fill a sparse one (Sherman and Morrison)
    across, step = solve(tie.direction), solve(pull)
    share = tie.info * float(tie.direction @ step) / (1.0 + tie.info * float(tie.direction @ across))
    return step - share * across, pull


def _tied(p: Array, network: Network, tie: Tie | None) -> float:
    value = cost(p, network)
    if tie is not None:
        value += tie.info * float(tie.direction @ (p[network.free] - tie.start) - tie.length) ** 2
    return value


def anchor_information(p: Array, network: Network) -> Array:
    """Return the information (c, c) of the anchors' unknown coordinates, the tag's track left free."""
    A = normal(p, network)[0]
    c = network.free_anchors
    if A.shape[0] == c:
        return plain(A)
    A = A if isinstance(A, np.ndarray) else A.tocsc()
    corner, side, rest = plain(A[:c, :c]), plain(A[c:, :c]), A[c:, c:]
    floor = RIDGE * float(rest.diagonal().mean()) + 1e-300
    out = corner - side.T @ solver(damped(rest, 0.0, floor))(side)
    return np.asarray(0.5 * (out + out.T), float)
