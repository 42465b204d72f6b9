import numpy as np
import pytest

from robustnav.errors import EstimatorError, InputError
from robustnav.evaluate import chi_square_band, consistency, nees, nis
from robustnav.records import Innovations


def covariances(shape, n, seed=0):
    root = np.random.default_rng(seed).normal(size=(*shape, n, n))
    return root @ np.swapaxes(root, -1, -2) + 0.1 * np.eye(n)


def test_nees_equals_the_formula_and_is_invariant_under_units():
    P = covariances((4, 7), 3)
    e = np.random.default_rng(1).normal(size=(4, 7, 3))
    expected = np.einsum("...i,...ij,...j", e, np.linalg.inv(P), e)
    np.testing.assert_allclose(nees(e, P), expected, rtol=1e-9)
    T = np.diag([1e3, 57.3, 1e-2])
    np.testing.assert_allclose(nees(e @ T, T @ P @ T), expected, rtol=1e-9)


def test_band_is_that_of_the_chi_square_distribution():
    from scipy.stats import chi2

    for dof, runs, confidence in ((1, 1, 0.95), (6, 50, 0.95), (15, 500, 0.99)):
        expected = chi2.ppf([(1 - confidence) / 2, (1 + confidence) / 2], dof * runs) / runs
        np.testing.assert_allclose(chi_square_band(dof, runs, confidence), expected, rtol=1e-9)


def test_a_consistent_filter_is_inside_and_a_confident_one_outside():
    rng = np.random.default_rng(3)
    P = covariances((), 6)
    e = rng.normal(size=(40, 2000, 6)) @ np.linalg.cholesky(P).T
    values = nees(e, np.broadcast_to(P, (40, 2000, 6, 6)))
    good = consistency(values, 6)
    spread = 4 * np.sqrt(0.95 * 0.05 / 2000)
    assert abs(good.inside - 0.95) < spread
    assert abs(good.mean - 6) < 4 * np.sqrt(12 / values.size)
    assert good.low < 6 < good.high and (good.runs, good.steps, good.missing) == (40, 2000, 0)
    assert consistency(values / 0.7, 6).inside < 0.1


def test_correlation_in_time_leaves_the_share_inside_unbiased():
    """A random walk's errors are correlated over the whole run; each step's average still fills the band."""
    rng = np.random.default_rng(4)
    steps = np.arange(1, 201)
    shares = []
    for _ in range(60):
        e = np.cumsum(rng.normal(size=(20, 200, 1)), axis=1)
        P = np.broadcast_to(steps[:, None, None], (20, 200, 1, 1))
        shares.append(consistency(nees(e, P.astype(float)), 1).inside)
    assert abs(np.mean(shares) - 0.95) < 4 * np.std(shares) / np.sqrt(60)


def test_nan_is_a_failure_in_nees():
    e = np.ones((2, 5, 2))
    e[1, 3] = np.nan
    values = nees(e, np.broadcast_to(np.eye(2), (2, 5, 2, 2)))
    assert np.isnan(values[1, 3]) and np.isfinite(values).sum() == 9
    test = consistency(values, 2)
    assert np.isnan(test.mean) and test.missing == 1 and test.inside == 0.8


def test_a_covariance_that_is_none_is_refused():
    with pytest.raises(EstimatorError, match="eigenvalue of -1"):
        nees(np.ones((1, 2)), np.diag([1.0, -1.0])[None])


@pytest.mark.parametrize("shape", [(3, 2), (3, 2, 3), (4, 2, 2)])
def test_shapes_that_do_not_fit_are_refused(shape):
    with pytest.raises(InputError, match="nees"):
        nees(np.ones((3, 2)), np.ones(shape))


@pytest.mark.parametrize("arguments", [(0, 1, 0.9), (1, 0, 0.9), (1, 1, 0.0), (1, 1, 1.0)])
def test_a_band_needs_runs_freedom_and_probability(arguments):
    with pytest.raises(InputError, match="chi-square band"):
        chi_square_band(*arguments)


def innovations(seed, refuse=False):
    z = np.random.default_rng(seed).normal(size=(400, 3)) * 2
    values = (z**2 / 4).sum(axis=1)
    return Innovations(np.arange(400.0), z, np.full_like(z, 4.0), values, values < 7.8 if refuse else values < np.inf)


def test_nis_counts_refused_readings_and_leaves_out_missing_ones():
    runs = [innovations(seed, refuse=True) for seed in range(10)]
    assert not all(run.used.all() for run in runs)
    whole = nis(runs)
    assert whole == nis([innovations(seed) for seed in range(10)])
    assert whole.dof == 3 and abs(whole.mean - 3) < 4 * np.sqrt(6 / 4000)
    z, values = runs[2].z.copy(), runs[2].nis.copy()
    z[5, 1], values[5] = np.nan, 0.4  # a partial reading has fewer degrees of freedom
    runs[2] = Innovations(runs[2].t, z, runs[2].s, values, runs[2].used)
    cut = nis(runs)
    assert (cut.steps, cut.missing) == (399, 1)


def test_nis_needs_runs_of_one_shape_and_a_covariance():
    with pytest.raises(InputError, match="common shape"):
        nis([])
    one = innovations(0)
    none = np.full(400, np.nan)
    with pytest.raises(InputError, match="no step with a NIS"):
        nis([Innovations(one.t, one.z, one.s * np.nan, none, one.used)])
    with pytest.raises(InputError, match="consistency"):
        consistency(np.ones(3), 1)
