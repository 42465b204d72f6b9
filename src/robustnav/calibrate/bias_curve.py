"""The bias of a range as a curve over the range: hat functions between knots, their number chosen by held-out files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from robustnav.calibrate.held_out import HeldOut, held_out
from robustnav.calibrate.pairs import Pairs
from robustnav.calibrate.range_line import Fitted
from robustnav.calibrate.robust import HUBER, Loss, fit_linear
from robustnav.errors import InputError
from robustnav.records import Array

MIN_READINGS = 3  # on each side of a knot
CHOICES = range(2, 13)  # numbers of knots to try
FOLDS = 10


@dataclass(frozen=True)
class BiasCurve:
    """The bias c(r) of measured ranges r: straight between knots, level beyond the first and the last.

    A curve belongs to one pair of antennas and their mounting; it does not carry over to another.

    Parameters
    ----------
    knots : (k,) ranges [m], ascending, two at least.
    bias : (k,) there [m].
    range_variance : of r - c(r) about the true distance [m^2].
    fitted : how, or None for a curve that somebody else stated.

    Raises
    ------
    InputError : shapes differ, knots that do not ascend, or a number that is not finite.
    """

    knots: tuple[float, ...]
    bias: tuple[float, ...]
    range_variance: float
    fitted: Fitted | None = None

    def __post_init__(self) -> None:
        numbers = (*self.knots, *self.bias, self.range_variance)
        ascending = len(self.knots) >= 2 and bool((np.diff(self.knots) > 0).all())
        if len(self.bias) != len(self.knots) or not ascending or not np.isfinite(numbers).all() or numbers[-1] < 0:
            got = f"knots {self.knots}, bias {self.bias}, variance {self.range_variance}"
            raise InputError("bias curve", got=got[:200], expected="ascending knots, a bias at each, a variance >= 0")

    def distance(self, measured: ArrayLike) -> Array:
        """Return calibrated distances r - c(r) [m] of measured ranges [m], any shape."""
        r = np.asarray(measured, float)
        out: Array = r - np.interp(r, self.knots, self.bias)
        return out

    def distance_variance(self, measured: ArrayLike) -> Array:
        """Return variances [m^2] of calibrated distances, with the part of the curve's own uncertainty."""
        r = np.asarray(measured, float)
        if self.fitted is None:
            return np.full(r.shape, self.range_variance)
        h = hats(r.ravel(), self.knots)
        curve = np.einsum("ij,jk,ik->i", h, np.array(self.fitted.covariance), h)
        out: Array = self.range_variance + curve.reshape(r.shape)
        return out


@dataclass(frozen=True)
class KnotChoice:
    """Held-out errors by number of knots, and the curve fitted to all pairs with the number chosen."""

    curve: BiasCurve
    errors: dict[int, HeldOut]


def hats(r: Array, knots: Sequence[float]) -> Array:
    """Return the hat functions (n, k) of ranges ``r`` (n,): what each knot's bias counts there."""
    return np.stack([np.interp(r, knots, one) for one in np.eye(len(knots))], axis=1)


def fit_curve(pairs: Pairs, knots: Sequence[float], loss: Loss = HUBER) -> BiasCurve:
    """Fit the bias at given knots [m] to r - d.

    Raises
    ------
    InputError : knots that do not ascend, fewer than three readings near one of them, or too few files.
    EstimatorError : a robust loss that does not converge.
    """
    places = tuple(float(knot) for knot in knots)
    BiasCurve(places, (0.0,) * len(places), 0.0)  # the knots must make a curve
    h = hats(pairs.measured, places)
    bare = np.flatnonzero((h > 0).sum(axis=0) < MIN_READINGS)
    if bare.size:
        got = f"{int((h[:, bare[0]] > 0).sum())} readings near the knot at {places[bare[0]]:g} m"
        raise InputError("bias curve", got=got, expected=f"{MIN_READINGS} or more", do="leave the knot out")
    fit = fit_linear(h, pairs.measured - pairs.distance_true, loss, pairs.file)
    return BiasCurve(places, tuple(fit.beta.tolist()), fit.variance, Fitted.of(fit, pairs, loss))


def choose_curve(pairs: Pairs, loss: Loss = HUBER) -> KnotChoice:
    """Fit the curve with the number of knots, evenly spaced in range, that files left out speak for.

    Files are dealt by distance into ten folds.  The fewest knots win whose squared error, file by file, is not above
    the least one by more than a standard error of the difference.  The error of the chosen curve is slightly
    flattering, for it was chosen by it.

    Raises
    ------
    InputError : pairs without files, or too few for two knots.
    """
    errors: dict[int, HeldOut] = {}
    for count in CHOICES:
        places = _even(pairs, count)
        try:
            errors[count] = held_out(pairs, partial(fit_curve, knots=places, loss=loss), folds=FOLDS)
        except InputError:
            if count == CHOICES[0]:
                raise
            break  # knots without readings near them; more knots have fewer still
    best = min(errors.values(), key=lambda one: one.rms)
    count = next(k for k, one in errors.items() if _as_good(one, best))
    return KnotChoice(fit_curve(pairs, _even(pairs, count), loss), errors)


def _even(pairs: Pairs, count: int) -> list[float]:
    return [float(x) for x in np.linspace(pairs.measured.min(), pairs.measured.max(), count)]


def _as_good(one: HeldOut, best: HeldOut) -> bool:
    worse = one.file_rms**2 - best.file_rms**2
    return bool(worse.mean() <= worse.std(ddof=1) / np.sqrt(len(worse)))
