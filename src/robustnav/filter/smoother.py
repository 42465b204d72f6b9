"""The Rauch-Tung-Striebel smoother on an error state: what the whole recording says of every instant of it.

Rauch, Tung, Striebel (1965); on the manifold, the correction is made in the tangent space of the filtered state.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robustnav.frames import Array
from robustnav.model.functions import ModelFunctions

Belief = tuple[Array, Array]


def smooth(model: ModelFunctions, dt: Array, u: Array, beliefs: Sequence[Belief]) -> list[Belief]:
    """Return the smoothed beliefs of rows that a filter went through.

    Parameters
    ----------
    model : the model's functions.
    dt : (n,) time from the row before [s]; zero: the same instant; NaN: a filter was started here.
    u : (n, nu) input held from the row before.
    beliefs : the filter's states (nx,) and covariances (ne, ne) of n rows, with every reading of their instant.
    """
    out = list(beliefs)
    for k in reversed(range(len(out) - 1)):
        if dt[k + 1] > 0:
            out[k] = step(model, out[k], out[k + 1], u[k + 1], float(dt[k + 1]))
        elif dt[k + 1] == 0:
            out[k] = out[k + 1]
    return out


def step(model: ModelFunctions, belief: Belief, ahead: Belief, u: Array, dt: float) -> Belief:
    """Return the smoothed belief (x, P) at the start of a step of ``dt`` > 0 seconds.

    Parameters
    ----------
    model : the model's functions.
    belief : the filter's state and covariance there.
    ahead : the smoothed ones at the step's end.
    u : (nu,) input of the step.
    dt : its length [s].
    """
    x, P = belief
    F, Q = model.transition(x, u, dt)
    G, P_smooth = back(F, Q, P, ahead[1])
    return model.inject(x, G @ model.difference(ahead[0], model.propagate(x, u, dt))), P_smooth


def back(F: Array, Q: Array, P: Array, P_ahead: Array) -> tuple[Array, Array]:
    """Return the gain G = P F' (F P F' + Q)^-1 and the smoothed covariance (ne, ne) of one step.

    The covariance is the sum (I - G F) P (I - G F)' + G (Q + P_ahead) G', equal to the usual difference
    P - G (P_pred - P_ahead) G' and a covariance whatever the rounding of G.
    """
    FP = F @ P
    G = solve_semidefinite(FP @ F.T + Q, FP).T
    left = np.eye(len(P)) - G @ F
    P_smooth = left @ P @ left.T + G @ (Q + P_ahead) @ G.T
    return G, (P_smooth + P_smooth.T) / 2


def solve_semidefinite(M: Array, B: Array) -> Array:
    """Return X with M X = B of a positive semidefinite M whose range holds the columns of B, by Cholesky.

    A direction of M without variance beyond rounding is known and takes no part: X does not move along it.
    """
    n = len(M)
    U, X = np.array(M, float), np.array(B, float)
    least = 8 * n * np.finfo(float).eps * np.diag(U)
    inverse = np.zeros(n)
    for i in range(n):
        if U[i, i] > least[i]:
            inverse[i] = 1 / np.sqrt(U[i, i])
        U[i, i:] *= inverse[i]
        U[i + 1 :, i + 1 :] -= np.outer(U[i, i + 1 :], U[i, i + 1 :])
        X[i] = (X[i] - U[:i, i] @ X[:i]) * inverse[i]
    for i in reversed(range(n)):
        X[i] = (X[i] - U[i, i + 1 :] @ X[i + 1 :]) * inverse[i]
    return X
