"""Linear regression under a loss: least squares, Huber, Student-t, by iteratively reweighted least squares.

P. J. Huber, Robust Statistics, Wiley 1981, chapter 7: asymptotic covariances, scale, computation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array, IntArray

KINDS = ("least_squares", "huber", "student_t")
MAD_TO_SD = 1.482602218505602  # standard deviation of a normal law over its median absolute deviation
MAD_EFFICIENCY = 0.3675  # degrees of freedom of a squared MAD scale, over those of a sum of squares
OUTLIER_SD = 5.0  # residuals beyond are counted: a normal law has one in two million
_EXACT = 1e-12  # residuals this small against the readings are rounding
_CONVERGED = 1e-8  # of the scale
_SCALE_STEPS = 50  # the scale moves no more after these: with it held the steps cannot cycle
_STEPS = 1000
_SINGULAR = 1e12  # condition of the normal equations, columns of unit length


@dataclass(frozen=True)
class Loss:
    """How a residual counts.

    ``least_squares``; ``huber``: linear beyond ``constant`` standard deviations; ``student_t``: log-likelihood with
    ``constant`` degrees of freedom, where gross errors lose all influence.  Constants that grow without end, and an
    infinite one, give least squares.

    Raises
    ------
    InputError : another kind, or a constant that is not positive.
    """

    kind: str
    constant: float = np.inf

    def __post_init__(self) -> None:
        if self.kind not in KINDS or not self.constant > 0:
            got = f"{self.kind!r} with {self.constant}"
            raise InputError("loss", got=got, expected=f"one of {', '.join(KINDS)} with a constant > 0")
        if self.kind == "least_squares" and np.isfinite(self.constant):
            raise InputError("loss", got=f"least squares with {self.constant}", expected="no constant")

    def weight(self, u: Array) -> Array:
        """Return the weights (n,) in (0, 1 + 1/constant] of residuals ``u`` (n,) in standard deviations."""
        if np.isinf(self.constant):
            return np.ones_like(u)
        if self.kind == "huber":
            clipped: Array = self.constant / np.maximum(np.abs(u), self.constant)
            return clipped
        out: Array = (self.constant + 1) / (self.constant + u * u)
        return out

    def slope(self, u: Array) -> Array:
        """Return the derivative (n,) of ``weight(u) u``."""
        if np.isinf(self.constant):
            return np.ones_like(u)
        if self.kind == "huber":
            return np.asarray(np.abs(u) <= self.constant, float)
        nu = self.constant
        out: Array = (nu + 1) * (nu - u * u) / (nu + u * u) ** 2
        return out


LEAST_SQUARES = Loss("least_squares")
HUBER = Loss("huber", 1.345)  # 95 % efficient for normal errors
STUDENT_T = Loss("student_t", 4.0)


@dataclass(frozen=True)
class LinearFit:
    """Coefficients of y = X beta + error.

    Parameters
    ----------
    beta : (p,) coefficients.
    covariance : (p, p) theirs.
    variance : of an error: sum of squares / (n - p), or the squared MAD scale under a robust loss.
    variance_dof : degrees of freedom of ``variance``.
    dof : degrees of freedom behind ``covariance``, for Student quantiles.
    outliers : residuals beyond five standard deviations.
    """

    beta: Array
    covariance: Array
    variance: float
    variance_dof: float
    dof: int
    outliers: int


def fit_linear(X: Array, y: Array, loss: Loss, groups: IntArray | None = None) -> LinearFit:
    """Fit y (n,) = X (n, p) beta under a loss.

    The scale of a robust loss is the MAD about the median, taken anew in every step; the start is least squares.  One
    gross error in five is borne, if they do not crowd at one end of the distances.  Without ``groups`` the covariance
    is that of independent errors; with ``groups`` (n,), whole numbers, errors of one group may be correlated in any way
    (sandwich over groups, corrected by G/(G-1) (n-1)/(n-p)).

    Raises
    ------
    InputError : not more rows than columns, columns that do not differ, or not more groups than columns.
    EstimatorError : no convergence.
    """
    n, p = X.shape
    if n <= p:
        raise InputError("fit", got=f"{n} readings", expected=f"more than {p}")
    number = None if groups is None else np.unique(groups, return_inverse=True)[1]
    count = 0 if number is None else int(number.max()) + 1
    if number is not None and count <= p:
        raise InputError("fit", got=f"{count} files", expected=f"more than {p}")
    size = np.linalg.norm(X, axis=0)
    if not (size > 0).all() or np.linalg.cond((X / size).T @ (X / size)) > _SINGULAR:
        raise InputError("fit", got="columns that do not differ", expected="readings at different distances")
    beta, sd = _solve(X, y, loss)
    e = y - X @ beta
    u = e / sd if sd > 0 else np.zeros(n)
    robust = bool(np.isfinite(loss.constant))
    covariance = _covariance(X, e * loss.weight(u), loss.slope(u), number)
    return LinearFit(
        beta=beta,
        covariance=covariance,
        variance=sd * sd,
        variance_dof=(n - p) * (MAD_EFFICIENCY if robust else 1.0),
        dof=n - p if groups is None else count - p,
        outliers=int(np.count_nonzero(np.abs(u) > OUTLIER_SD)),
    )


def _solve(X: Array, y: Array, loss: Loss) -> tuple[Array, float]:
    """Return coefficients (p,) and the standard deviation of an error."""
    n, p = X.shape
    beta = _weighted(X, y, np.ones(n))
    if np.isinf(loss.constant):
        e = y - X @ beta
        return beta, float(np.sqrt(e @ e / (n - p)))
    sd = _scale(y - X @ beta)
    for step in range(_STEPS):
        if sd <= _EXACT * np.abs(y).max():
            return beta, sd
        e = y - X @ beta
        new = _weighted(X, y, loss.weight(e / sd))
        moved = np.abs(X @ (new - beta)).max()
        beta = new
        if step < _SCALE_STEPS:
            sd = _scale(y - X @ beta)
        if moved <= _CONVERGED * sd:
            return beta, sd
    raise EstimatorError("robust fit", got=f"no convergence in {_STEPS} steps", do="look at the readings for two lines")


def _scale(e: Array) -> float:
    return MAD_TO_SD * float(np.median(np.abs(e - np.median(e))))


def _weighted(X: Array, y: Array, w: Array) -> Array:
    root = np.sqrt(w)
    scaled = X * root[:, None]  # a product with its own transpose is the fast one
    return np.asarray(np.linalg.solve(scaled.T @ scaled, scaled.T @ (root * y)), np.float64)


def _covariance(X: Array, psi: Array, slope: Array, groups: IntArray | None) -> Array:
    n, p = X.shape
    mean = float(slope.mean())
    if not mean > 0:
        raise EstimatorError(
            "robust fit", got="influence that falls everywhere", do="look at the readings for two lines"
        )
    correction = 1 + p / n * float(slope.var()) / mean**2
    inverse = np.asarray(np.linalg.inv(X.T @ X), np.float64)
    if groups is None:
        inner = inverse * (float(psi @ psi) / (n - p))
    else:
        sums: Array = np.stack([np.bincount(groups, X[:, k] * psi) for k in range(p)], axis=1)
        count = len(sums)
        inner = inverse @ (sums.T @ sums) @ inverse * (count / (count - 1) * (n - 1) / (n - p))
    out: Array = inner * (correction / mean) ** 2
    return out
