"""What a correction is worth on files it was not fitted to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from robustnav.calibrate.pairs import Pairs
from robustnav.errors import InputError
from robustnav.records import Array, IntArray


class Correction(Protocol):
    """What turns measured ranges into distances, and says how sure these are."""

    def distance(self, measured: ArrayLike) -> Array:
        """Return calibrated distances [m] of measured ranges [m]."""

    def distance_variance(self, measured: ArrayLike) -> Array:
        """Return their variances [m^2]."""


@dataclass(frozen=True)
class HeldOut:
    """Errors of corrections on files left out of their fit.

    Parameters
    ----------
    error : (n,) corrected minus true distance [m], in the order of the pairs.
    files : (files,) their numbers, ascending.
    file_rms : (files,) root mean square error of each file [m].
    """

    error: Array
    files: IntArray
    file_rms: Array

    @property
    def rms(self) -> float:
        """Root mean square error over all readings [m]."""
        return float(np.sqrt(np.mean(self.error**2)))


def held_out(pairs: Pairs, fit: Callable[[Pairs], Correction], *, folds: int | None = None) -> HeldOut:
    """Return the errors of each file under a correction fitted to the others.

    Parameters
    ----------
    pairs : with their files.
    fit : the fit to repeat: ``fit_line``, or a function of its loss or knots.
    folds : leave out this many groups of files, dealt by mean distance, in place of one file after the other.

    Raises
    ------
    InputError : pairs without files, fewer than two files or folds, or what the fit refuses.
    """
    files, number = np.unique(np.zeros(0, int) if pairs.file is None else pairs.file, return_inverse=True)
    count = len(files)
    if count < 2 or (folds is not None and folds < 2):
        got = "no files" if pairs.file is None else f"{count} files, {folds} folds"
        raise InputError("held-out errors", got=got, expected="two files and two folds at least")
    mean = np.bincount(number, pairs.distance_true) / np.bincount(number)
    fold = np.empty(count, int)
    fold[np.argsort(mean, kind="stable")] = np.arange(count) % min(folds or count, count)
    error = np.empty(len(pairs))
    for k in range(int(fold.max()) + 1):
        out = fold[number] == k
        error[out] = fit(pairs.where(~out)).distance(pairs.measured[out]) - pairs.distance_true[out]
    file_rms = np.sqrt(np.bincount(number, error**2) / np.bincount(number))
    return HeldOut(error, files, file_rms)
