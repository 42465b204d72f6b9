"""Bands that a right simulation leaves once in a thousand seeds."""

import numpy as np
import pytest
from scipy.stats import chi2, norm


@pytest.fixture(scope="session")
def in_band():
    """Return a check that the mean square of independent zero-mean numbers has the stated variance."""

    def check(x, variance, dof=None):
        dof = dof or np.size(x)
        low, high = chi2.ppf([0.0005, 0.9995], dof) / dof
        assert low < np.mean(np.square(x)) / variance < high

    return check


@pytest.fixture(scope="session")
def near():
    """Return a check that a mean of ``n`` independent numbers of known sd has the stated value."""

    def check(mean, expected, sd, n):
        assert abs(mean - expected) < norm.ppf(0.9995) * sd / np.sqrt(n)

    return check
