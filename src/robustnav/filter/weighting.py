"""What a reading that is far off counts for: gate, Huber and Student-t weights.

A reading whose sum of squared normalised innovations over m rows is nis gets a weight w in [0, 1]; the filter then
uses the gain w P H' S^-1 and the covariance P - w P H' S^-1 H P.  For one row that is the update of a reading whose
variance is inflated until s becomes s / w.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError


@dataclass(frozen=True)
class Gate:
    """All or nothing: a reading with nis above ``limit`` is refused; infinity takes everything."""

    limit: float = float("inf")

    def __post_init__(self) -> None:
        _check("gate", self.limit, "a largest accepted NIS above zero")

    @classmethod
    def probability(cls, share: float, rows: int = 1) -> Gate:
        """Return the gate that a reading of ``rows`` rows with its stated noise passes with probability ``share``."""
        from scipy.stats import chi2

        if not 0 < share < 1:
            raise InputError("gate probability", got=str(share), expected="a share between 0 and 1, as 0.997")
        return cls(float(chi2.ppf(share, rows)))

    def weight(self, nis: float, rows: int) -> float:
        """Return 1 or 0."""
        return float(nis <= self.limit and np.isfinite(nis))


@dataclass(frozen=True)
class Huber:
    """Weight 1 up to ``limit`` standard deviations, falling as 1 / distance beyond (Huber 1964)."""

    limit: float = 1.345

    def __post_init__(self) -> None:
        _check("Huber limit", self.limit, "a number of standard deviations above zero")

    def weight(self, nis: float, rows: int) -> float:
        """Return min(1, limit / sqrt(nis)); NaN for a NaN."""
        return float(np.minimum(1.0, self.limit / np.sqrt(nis))) if nis > 0 else _at_zero(nis)


@dataclass(frozen=True)
class StudentT:
    """Weight of a Student-t distributed reading with ``limit`` degrees of freedom: falls as 1 / distance squared.

    Never zero, so a filter that is far off finds back by itself (Lange, Little and Taylor 1989).
    """

    limit: float = 4.0

    def __post_init__(self) -> None:
        _check("Student-t", self.limit, "degrees of freedom above zero")

    def weight(self, nis: float, rows: int) -> float:
        """Return min(1, (limit + rows) / (limit + nis)); NaN for a NaN."""
        return float(np.minimum(1.0, (self.limit + rows) / (self.limit + nis)))


Rule = Gate | Huber | StudentT
KINDS: dict[type, int] = {Gate: 0, Huber: 1, StudentT: 2}


def _at_zero(nis: float) -> float:
    return 1.0 if nis == 0 else float("nan")


def _check(name: str, value: float, expected: str) -> None:
    if not value > 0:
        raise InputError(name, got=str(value), expected=expected)
