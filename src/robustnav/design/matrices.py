"""Checks and small operations every design shares: shapes, covariances, unit-free differences."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robustnav.errors import InputError
from robustnav.records import Array

ComplexArray = NDArray[np.complex128]


def matrix(value: ArrayLike, shape: tuple[int, ...], thing: str) -> Array:
    """Return ``value`` as floats of ``shape`` (-1 allows any size), or raise ``InputError`` naming ``thing``."""
    out = np.asarray(value, float)
    if out.ndim != len(shape) or any(want not in (-1, got) for got, want in zip(out.shape, shape, strict=True)):
        wanted = ", ".join("any" if size < 0 else str(size) for size in shape)
        raise InputError(thing, got=f"shape {out.shape}", expected=f"shape ({wanted})")
    bad = np.argwhere(~np.isfinite(out))
    if bad.size:
        place = tuple(int(i) for i in bad[0])
        raise InputError(thing, place=f"entry {place}", got=str(out[place]), expected="finite numbers")
    return out


def covariance(value: ArrayLike, n: int, thing: str) -> Array:
    """Return ``value`` as a symmetric positive semidefinite (n, n) matrix, or raise ``InputError``."""
    out = matrix(value, (n, n), thing)
    spread = np.sqrt(np.maximum(np.diag(out), 0.0))
    unit = np.where(spread > 0, spread, 1.0)
    correlation = out / np.outer(unit, unit)
    if np.abs(correlation - correlation.T).max(initial=0.0) > 1e-9:
        raise InputError(thing, got="an asymmetric matrix", expected="a symmetric one")
    lowest = float(np.linalg.eigvalsh(symmetric(correlation)).min(initial=0.0))
    if lowest < -1e-9:
        raise InputError(thing, got=f"an eigenvalue {lowest:.3g} after scaling", expected="none below zero")
    return symmetric(out)


def symmetric(P: Array) -> Array:
    """Return the symmetric part of P (..., n, n)."""
    return (P + np.swapaxes(P, -1, -2)) / 2


def right_divide(M: Array, R: Array) -> Array:
    """Return M R^-1 for M (k, m) and R (m, m)."""
    return np.asarray(np.linalg.solve(R.T, M.T).T, float)


def modes(F: Array) -> ComplexArray:
    """Return the eigenvalues (n,) of F, complex even where all are real."""
    return np.linalg.eigvals(F).astype(np.complex128)


def covariance_difference(P: Array, reference: Array) -> float:
    """Return the largest entry of ``P - reference`` (n, n), each divided by the reference's two standard deviations.

    States in different units then weigh alike.
    """
    sd = np.sqrt(np.diag(reference))
    scale = np.outer(sd, sd)
    scale[scale == 0] = 1.0
    return float(np.max(np.abs(P - reference) / scale))


def direction(vector: ComplexArray) -> str:
    """Describe a direction in state space by its larger entries, for error messages."""
    v = np.real_if_close(vector, tol=1e6)
    v = v / v[np.argmax(np.abs(v))]
    parts = [f"{value:+.3g} x[{i}]" for i, value in enumerate(v) if abs(value) > 1e-3]
    return " ".join(parts)
