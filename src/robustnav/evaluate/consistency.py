"""Does a filter's error have the size its covariance claims?  NEES, NIS and their chi-square bands.

Squared errors of one run are correlated in time, so a chi-square band for their time average is too narrow.  The
bands here are for averages over independent runs at one time step; the share of steps inside should be near the
confidence.  Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 5.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array, Innovations


@dataclass(frozen=True)
class Consistency:
    """A consistency test of squared normalised errors.

    Parameters
    ----------
    mean : over runs and steps; its expectation is ``dof``.
    low, high : two-sided band for the average over all ``runs`` at one step.
    inside : share of the steps whose average over runs lies in its band; expected near ``confidence``.
    dof, runs, steps : degrees of freedom, independent runs, time steps judged.
    missing : values that are NaN.
    confidence : probability of the band.
    """

    mean: float
    low: float
    high: float
    inside: float
    dof: int
    runs: int
    steps: int
    missing: int
    confidence: float


def nees(errors: Array, covariance: Array) -> Array:
    """Return normalised estimation errors squared, ``e' P^-1 e``.

    Parameters
    ----------
    errors : (..., n) estimate minus truth, as an error state.
    covariance : (..., n, n) claimed covariance, same units squared.

    Returns
    -------
    (...) values, NaN where an error or a covariance holds NaN.

    Raises
    ------
    InputError : shapes do not fit.
    EstimatorError : a covariance is not positive definite.
    """
    if errors.ndim < 1 or covariance.shape != (*errors.shape, errors.shape[-1]):
        raise InputError(
            "nees", got=f"errors {errors.shape}, covariance {covariance.shape}", expected="(..., n) and (..., n, n)"
        )
    known = np.isfinite(errors).all(axis=-1) & np.isfinite(covariance).all(axis=(-2, -1))
    try:
        root = np.linalg.cholesky(covariance[known])
    except np.linalg.LinAlgError as why:
        lowest = np.linalg.eigvalsh(covariance[known]).min()
        raise EstimatorError(
            "covariance in nees", got=f"an eigenvalue of {lowest:.3g}", expected="positive definite"
        ) from why
    white = np.linalg.solve(root, errors[known][..., None])[..., 0]
    out = np.full(errors.shape[:-1], np.nan)
    out[known] = np.sum(white * white, axis=-1)
    return out


def chi_square_band(dof: int, runs: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the two-sided band of the mean of ``runs`` independent chi-square values of ``dof`` each.

    Raises
    ------
    InputError : ``dof`` or ``runs`` below one, or ``confidence`` outside (0, 1).
    """
    if dof < 1 or runs < 1 or not 0 < confidence < 1:
        raise InputError(
            "chi-square band",
            got=f"dof {dof}, runs {runs}, confidence {confidence}",
            expected="dof and runs of at least 1, confidence between 0 and 1",
        )
    from scipy.special import gammaincinv

    tail = 0.5 * (1 - confidence)
    low, high = 2 * gammaincinv(0.5 * dof * runs, [tail, 1 - tail]) / runs
    return float(low), float(high)


def consistency(values: Array, dof: int, *, confidence: float = 0.95) -> Consistency:
    """Test NEES of independent runs; a NaN makes its step count as outside and the mean NaN.

    Parameters
    ----------
    values : (runs, steps) squared normalised errors, all runs at the same times.
    dof : degrees of freedom of each value.
    confidence : probability of the band.

    Raises
    ------
    InputError : ``values`` is not (runs, steps) or is empty, or as ``chi_square_band``.
    """
    if values.ndim != 2 or not values.size:
        raise InputError("consistency", got=f"shape {values.shape}", expected="(runs, steps), not empty")
    low, high = chi_square_band(dof, len(values), confidence)
    average = values.mean(axis=0)
    return Consistency(
        mean=float(values.mean()),
        low=low,
        high=high,
        inside=float(np.mean((average >= low) & (average <= high))),
        dof=dof,
        runs=len(values),
        steps=values.shape[1],
        missing=int(np.isnan(values).sum()),
        confidence=confidence,
    )


def nis(runs: Sequence[Innovations], *, confidence: float = 0.95) -> Consistency:
    """Test one sensor's NIS over independent runs that share their measurement times.

    Refused readings count: leaving them out would cut the tail off and flatter the filter.  A step at which some
    run has no complete reading is not judged; its missing readings are counted.

    Parameters
    ----------
    runs : the sensor's innovations, one per run, of equal length.
    confidence : probability of the band.

    Raises
    ------
    InputError : no runs, different lengths, or no step with a NIS (constant-gain filters have none).
    """
    shapes = {one.z.shape for one in runs}
    if len(shapes) != 1:
        raise InputError("nis", got=f"innovations of shapes {sorted(shapes)}", expected="runs of one common shape")
    complete = np.array([np.isfinite(one.z).all(axis=1) & np.isfinite(one.nis) for one in runs])
    judged = complete.all(axis=0)
    if not judged.any():
        raise InputError(
            "nis", got="no step with a NIS in every run", expected="innovations of a filter with a covariance"
        )
    test = consistency(np.array([one.nis[judged] for one in runs]), runs[0].z.shape[1], confidence=confidence)
    return Consistency(**{**vars(test), "missing": int((~complete).sum())})
