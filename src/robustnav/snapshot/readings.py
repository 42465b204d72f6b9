"""From what a caller holds to the arrays of a problem, checked."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.records import Array, BoolArray
from robustnav.snapshot.core import Problem, scale_of
from robustnav.snapshot.record import Height


class Readings(NamedTuple):
    """One instant as given: ``problem`` holds the rows ``used`` (k,) only; ``measured`` is m or k - 1 readings."""

    problem: Problem
    used: BoolArray
    anchors: Array
    measured: Array


def anchor_array(anchors: ArrayLike) -> Array:
    """Return anchors (k, 2) or (k, 3) as floats, or raise ``InputError`` naming the row."""
    out = np.asarray(anchors, float)
    if out.ndim != 2 or out.shape[1] not in (2, 3) or not len(out):
        raise InputError("anchors", got=f"shape {out.shape}", expected="shape (k, 2) or (k, 3)")
    bad = np.flatnonzero(~np.isfinite(out).all(axis=1))
    if bad.size:
        raise InputError("anchors", place=f"row {bad[0]}", got=str(out[bad[0]]), expected="finite coordinates in m")
    return out


def of_ranges(anchors: ArrayLike, ranges: ArrayLike, noise: ArrayLike, height: Height | None) -> Readings:
    """Return the problem of ranges (k,) [m] with ``noise`` an sd, (k,) sds [m] or a (k, k) covariance [m^2]."""
    a = anchor_array(anchors)
    r = _values(ranges, len(a), "ranges")
    used = ~np.isnan(r)
    R = _covariance(noise, used, "range noise")
    W = np.asarray(np.linalg.inv(R), float)
    return Readings(_problem(a[used], r[used], W, _checked(height, a), False), used, a, r)


def of_differences(anchors: ArrayLike, differences: ArrayLike, noise: ArrayLike, height: Height | None) -> Readings:
    """Return the problem of differences (k - 1,) [m]: distance to anchors 1, 2, ... minus distance to anchor 0.

    ``noise`` is the sd of one arrival, (k,) sds [m], or the (k - 1, k - 1) covariance of the differences [m^2].
    """
    a = anchor_array(anchors)
    dd = _values(differences, len(a) - 1, "range differences")
    heard = ~np.isnan(dd)
    used = np.concatenate([[True], heard])
    if np.ndim(noise) == 2:
        inverse = np.asarray(np.linalg.inv(_covariance(noise, heard, "noise of range differences")), float)
        contrast = np.column_stack([-np.ones(len(inverse)), np.eye(len(inverse))])
        W = contrast.T @ inverse @ contrast
    else:
        info = 1.0 / np.diag(_covariance(noise, used, "arrival noise"))
        W = np.diag(info) - np.outer(info, info) / info.sum()
    r = np.concatenate([[0.0], dd])[used]
    return Readings(_problem(a[used], r, W, _checked(height, a), True), used, a, dd)


def _problem(anchors: Array, ranges: Array, W: Array, height: Height | None, differences: bool) -> Problem:
    prior, prior_info = np.zeros(anchors.shape[1]), np.zeros(anchors.shape[1])
    if height is not None:
        prior[2], prior_info[2] = height.z, height.sd**-2
    return Problem(anchors, ranges, W, prior, prior_info, differences, scale_of(anchors, ranges))


def _values(values: ArrayLike, size: int, thing: str) -> Array:
    out = np.asarray(values, float)
    if out.shape != (size,):
        raise InputError(thing, got=f"shape {out.shape}", expected=f"shape ({size},)", do="give one number per anchor")
    bad = np.flatnonzero(np.isinf(out))
    if bad.size:
        expected = "finite numbers in m, NaN where a reading is missing"
        raise InputError(thing, place=f"row {bad[0]}", got=str(out[bad[0]]), expected=expected)
    return out


def _covariance(noise: ArrayLike, used: BoolArray, thing: str) -> Array:
    """Return the covariance (m, m) of the used rows."""
    given, size = np.asarray(noise, float), used.size
    if given.ndim == 2 and given.shape == (size, size):
        R = given[np.ix_(used, used)]
        good = np.isfinite(R).all() and np.allclose(R, R.T, rtol=1e-9, atol=0.0)
        if not good or (R.size and not np.linalg.eigvalsh(R)[0] > 1e-12 * np.trace(R)):
            raise InputError(thing, got="a matrix", expected="a symmetric positive definite covariance in m^2")
        return R
    if given.shape not in ((), (size,)):
        raise InputError(thing, got=f"shape {given.shape}", expected=f"a number, ({size},) or a covariance matrix")
    sd = np.broadcast_to(given, size)
    bad = np.flatnonzero(used & ~((sd > 0) & np.isfinite(sd)))
    if bad.size:
        raise InputError(thing, place=f"row {bad[0]}", got=str(sd[bad[0]]), expected="a finite sd above zero, in m")
    return np.diag(sd[used] ** 2)


def _checked(height: Height | None, anchors: Array) -> Height | None:
    if height is None:
        return None
    if anchors.shape[1] != 3:
        raise InputError("known height", got="2D anchors", expected="anchors (k, 3)", do="leave the height out in 2D")
    if not (np.isfinite(height.z) and np.isfinite(height.sd) and height.sd > 0):
        raise InputError("known height", got=str(tuple(height)), expected="a finite z and an sd above zero, in m")
    return height
