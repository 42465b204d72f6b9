"""The posterior Cramer-Rao bound: the smallest error covariance any estimator can reach along a known path."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robustnav.design.matrices import matrix, symmetric
from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array, BoolArray


class PathRows(NamedTuple):
    """One sensor's Jacobians along the true path.

    Parameters
    ----------
    H : (steps, ..., m, n) Jacobian at every step; rows of unused steps are not read.
    variance : of each row of one sample, a number or (m,).
    used : (steps,) or (steps, ...) True where a sample exists; None for all.
    """

    H: Array
    variance: float | Array
    used: ArrayLike | None = None


def posterior_bound(F: Array, Q: Array, updates: Sequence[PathRows], P0: ArrayLike) -> Array:
    """Return the bound on the error covariance after every step, by a Riccati recursion on the true path.

    Step k propagates with ``F[k]``, ``Q[k]`` and then corrects with every sensor's row k; to correct at the start
    first, let ``F[0]`` be the identity and ``Q[0]`` zero.  Axes between steps and matrix are a batch of paths.

    Parameters
    ----------
    F : (steps, ..., n, n) transition Jacobians at the true state.
    Q : (steps, ..., n, n) process-noise covariance of each step; batch axes may be 1.
    updates : sensors; a plain tuple (H, variance) or (H, variance, used) will do.
    P0 : (n, n) or (..., n, n) covariance of the start error.

    Returns
    -------
    P : (steps, ..., n, n) posterior bound.

    Raises
    ------
    InputError : shapes do not fit, or a number that is needed is not finite.
    EstimatorError : an innovation covariance is not positive definite.

    References
    ----------
    Tichavsky, Muravchik, Nehorai, IEEE Trans. Signal Processing 46 (1998), section III (here in covariance form, which
    also allows a singular Q).
    """
    F, Q = np.asarray(F, float), np.asarray(Q, float)
    if F.ndim < 3 or F.shape[-1] != F.shape[-2]:
        raise InputError("path Jacobians F", got=f"shape {F.shape}", expected="shape (steps, ..., n, n)")
    sensors = [_checked(PathRows(*update), F.shape, i) for i, update in enumerate(updates)]
    matrix(F, F.shape, "path Jacobians F")
    if Q.ndim != F.ndim or len(Q) != len(F) or Q.shape[-2:] != F.shape[-2:]:
        raise InputError("path noise Q", got=f"shape {Q.shape}", expected=f"shape {F.shape}")
    matrix(Q, Q.shape, "path noise Q")
    P = np.array(np.broadcast_to(np.asarray(P0, float), F.shape[1:]))
    matrix(P, P.shape, "start covariance P0")
    out = np.empty_like(F)
    for k in range(len(F)):
        P = symmetric(F[k] @ P @ np.swapaxes(F[k], -1, -2) + Q[k])
        for H, variance, used in sensors:
            if used[k].any():
                P = np.where(used[k][..., None, None], _updated(P, H[k], variance, k), P)
        out[k] = P
    return out


def _updated(P: Array, H: Array, variance: Array, step: int) -> Array:
    """Return the covariance after one update, in Joseph form."""
    crossed = H @ P
    S = symmetric(crossed @ np.swapaxes(H, -1, -2) + np.diag(variance))
    try:
        np.linalg.cholesky(S)
    except np.linalg.LinAlgError as why:
        raise EstimatorError("innovation covariance is not positive definite", place=f"step {step}") from why
    K = np.swapaxes(np.linalg.solve(S, crossed), -1, -2)
    left = np.eye(P.shape[-1]) - K @ H
    return symmetric(left @ P @ np.swapaxes(left, -1, -2) + (K * variance) @ np.swapaxes(K, -1, -2))


def _checked(update: PathRows, shape: tuple[int, ...], index: int) -> tuple[Array, Array, BoolArray]:
    """Return H with unused rows zeroed, variance (m,) and used (steps, ...) of one sensor."""
    place = f"update {index}"
    H = np.asarray(update.H, float)
    if H.ndim != len(shape) or H.shape[:-2] != shape[:-2] or H.shape[-1] != shape[-1]:
        wanted = f"shape ({', '.join(map(str, shape[:-2]))}, m, {shape[-1]})"
        raise InputError("path Jacobians H", place=place, got=f"shape {H.shape}", expected=wanted)
    used = np.asarray(True if update.used is None else update.used, bool)
    if used.ndim and used.shape != shape[: used.ndim]:
        raise InputError("mask of used samples", place=place, got=f"shape {used.shape}", expected=f"shape {shape[:-2]}")
    used = np.broadcast_to(used.reshape(used.shape + (1,) * (len(shape) - 2 - used.ndim)), shape[:-2])
    H = np.where(used[..., None, None], H, 0.0)
    matrix(H, H.shape, f"path Jacobians H of {place}")
    variance = np.broadcast_to(np.asarray(update.variance, float), H.shape[-2:-1])
    if not np.all((variance > 0) & np.isfinite(variance)):
        raise InputError("variance", place=place, got=str(update.variance), expected="finite numbers above zero")
    return H, variance, used
