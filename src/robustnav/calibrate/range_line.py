"""The published range line r = a d + b + eps: its estimates, the calibrated distance and the variances of both."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from robustnav.calibrate.pairs import Pairs
from robustnav.calibrate.robust import HUBER, LinearFit, Loss, fit_linear
from robustnav.errors import InputError
from robustnav.records import Array

CERTAIN = 0.95  # a slope whose interval at this level holds zero is no slope
SURVEY_DIGITS = 6  # distances that agree to a micrometre are one
MIN_DISTANCES = 3  # two define a line that nothing contradicts


@dataclass(frozen=True)
class Fitted:
    """How a correction was fitted.

    Parameters
    ----------
    covariance : (p, p) of the coefficients: slope and offset [m] of a line, the biases at the knots [m] of a curve.
    dof, variance_dof : degrees of freedom behind ``covariance`` and the variance of a reading.
    samples, files, outliers : readings, files (0: not told), and residuals beyond five standard deviations.
    distance_min, distance_max : of the readings [m].
    loss : under which.
    """

    covariance: tuple[tuple[float, ...], ...]
    dof: int
    variance_dof: float
    samples: int
    files: int
    outliers: int
    distance_min: float
    distance_max: float
    loss: Loss

    @classmethod
    def of(cls, fit: LinearFit, pairs: Pairs, loss: Loss) -> Fitted:
        """Return the record of a fit to ``pairs``."""
        return cls(
            covariance=tuple(tuple(row) for row in ((fit.covariance + fit.covariance.T) / 2).tolist()),
            dof=fit.dof,
            variance_dof=fit.variance_dof,
            samples=len(pairs),
            files=0 if pairs.file is None else len(np.unique(pairs.file)),
            outliers=fit.outliers,
            distance_min=float(pairs.distance_true.min()),
            distance_max=float(pairs.distance_true.max()),
            loss=loss,
        )


@dataclass(frozen=True)
class RangeLine:
    """The line r = slope d + offset + eps of one link, or of all.

    Parameters
    ----------
    slope : a, 1.
    offset : b, m.
    range_variance : sigma^2 of a measured range, m^2.
    fitted : how, or None for a line that somebody else stated.

    Raises
    ------
    InputError : a slope or variance that is not positive, or a number that is not finite.
    """

    slope: float
    offset: float
    range_variance: float
    fitted: Fitted | None = None

    def __post_init__(self) -> None:
        numbers = (self.slope, self.offset, self.range_variance)
        if not np.isfinite(numbers).all() or self.slope <= 0 or self.range_variance < 0:
            expected = "finite numbers, slope > 0, variance >= 0"
            raise InputError("range line", got=f"slope, offset, variance {numbers}", expected=expected)

    def distance(self, measured: ArrayLike) -> Array:
        """Return calibrated distances (r - b) / a [m] of measured ranges [m], any shape."""
        out: Array = (np.asarray(measured, float) - self.offset) / self.slope
        return out

    @property
    def variance(self) -> float:
        """The published variance sigma^2 / a^2 [m^2] of a calibrated distance: the line taken as known."""
        return self.range_variance / self.slope**2

    def distance_variance(self, measured: ArrayLike) -> Array:
        """Return variances [m^2] of calibrated distances, with the part of the line's own uncertainty.

        Var d = (sigma^2 + [d 1] V [d 1]') / a^2; for least squares with independent readings this is
        sigma^2 / a^2 (1 + 1/n + (d - mean)^2 / sum (d_k - mean)^2).
        """
        d = self.distance(measured)
        line: Array = np.zeros_like(d)
        if self.fitted is not None:
            (aa, ab), (_, bb) = self.fitted.covariance
            line = (aa * d + 2 * ab) * d + bb
        out: Array = (self.range_variance + line) / self.slope**2
        return out

    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Return the confidence intervals of ``slope``, ``offset`` [m] and ``range_variance`` [m^2].

        That of the variance holds for independent normal errors; under a robust loss for their bulk.

        Raises
        ------
        InputError : a level outside (0, 1), or a line that was not fitted.
        """
        from scipy.special import chdtri

        if self.fitted is None or not 0 < level < 1:
            raise InputError("intervals", got=f"level {level}", expected="a fitted line and a level between 0 and 1")
        tail = (1 - level) / 2
        half = student(level, self.fitted.dof) * np.sqrt(np.diag(self.fitted.covariance))
        ends = self.range_variance * self.fitted.variance_dof / chdtri(self.fitted.variance_dof, (tail, 1 - tail))
        return {
            "slope": (float(self.slope - half[0]), float(self.slope + half[0])),
            "offset": (float(self.offset - half[1]), float(self.offset + half[1])),
            "range_variance": (float(ends[0]), float(ends[1])),
        }


def student(level: float, dof: int) -> float:
    """Return the half width, in standard deviations, of a two-sided interval at ``level``."""
    from scipy.special import stdtrit

    return float(stdtrit(dof, (1 + level) / 2))


def fit_line(pairs: Pairs, loss: Loss = HUBER) -> RangeLine:
    """Fit the range line; ``LEAST_SQUARES`` gives the published estimates.

    a = sum (d_k - dm)(r_k - rm) / sum (d_k - dm)^2, b = rm - a dm, sigma^2 = sum (r_k - a d_k - b)^2 / (n - 2).

    Raises
    ------
    InputError : fewer than three different distances, files or readings, or distances too close together for the
        spread of the readings: zero lies in the 95 % interval of the slope.
    EstimatorError : a robust loss that does not converge.
    """
    different = len(np.unique(np.round(pairs.distance_true, SURVEY_DIGITS)))
    if different < MIN_DISTANCES:
        do = "measure at more distances, best over all that will be flown"
        raise InputError("range line", got=f"{different} distances", expected=f"{MIN_DISTANCES} or more", do=do)
    mean = pairs.distance_true.mean()
    X = np.column_stack([pairs.distance_true - mean, np.ones(len(pairs))])
    fit = fit_linear(X, pairs.measured, loss, pairs.file)
    if fit.beta[0] <= student(CERTAIN, fit.dof) * np.sqrt(fit.covariance[0, 0]):
        got = f"slope {fit.beta[0]:.3g}, sd {np.sqrt(fit.covariance[0, 0]):.3g}"
        raise InputError(
            "range line", got=got, expected="ranges that grow with the distance", do="spread the distances"
        )
    about_zero = np.array([[1.0, 0.0], [-mean, 1.0]])  # from the line about the mean distance
    slope, offset = about_zero @ fit.beta
    fit = replace(fit, covariance=about_zero @ fit.covariance @ about_zero.T)
    return RangeLine(float(slope), float(offset), fit.variance, Fitted.of(fit, pairs, loss))
