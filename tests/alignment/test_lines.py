"""Finding lines: the evidence against a dense Gaussian density, frequencies found, none invented, C and NumPy alike."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from robustnav.alignment.identify import identify, likeliest
from robustnav.alignment.lines import LINE_SD, NO_LINES, Whitened, Window, alone, given, search
from robustnav.alignment.setting import BANK, LINED
from robustnav.engine import _kernel

from .conftest import lines, markov

POLY_SD = np.array([3.0, 3.0, 0.5, 0.05, 0.03])


def make_window(seed: int, n: int = 90, period: float = 0.2, wind: str = "lines") -> Window:
    rng = np.random.default_rng(seed)
    t = period * np.arange(n)
    x = (2 * np.arange(n) + 1) / n - 1
    r = 0.05 * rng.standard_normal((n, 2)) + np.polynomial.legendre.legvander(x, 4) @ (
        POLY_SD[:, None] * rng.normal(size=(5, 2))
    )
    if wind == "lines":
        r += lines(rng, t)
    if wind == "markov":
        r += markov(rng, n, period, 0.5, 4.0)
    return Window(r, np.ones(n), period, 0.05, POLY_SD)


@pytest.mark.parametrize(("markov_sd", "markov_time"), [(0.0, 4.0), (0.2, 4.0), (1.5, 1.0)])
def test_evidence_is_the_density_of_the_data(markov_sd, markov_time):
    window = make_window(1, n=40)
    weight = window.weight.copy()
    weight[[5, 17, 18]] = 0.0
    weight[30] = 0.5
    window = Window(np.where(weight[:, None] > 0, window.r, 0.0), weight, window.period, window.noise_sd, POLY_SD)
    omega, there = np.array([0.6, 2.1]), weight > 0
    t = window.period * np.arange(40)
    columns = [np.polynomial.legendre.legvander((2 * np.arange(40) + 1) / 40 - 1, 4) * POLY_SD]
    columns += [LINE_SD * f(np.outer(t, omega)) for f in (np.cos, np.sin)]
    A = np.hstack(columns)
    lag = np.abs(np.subtract.outer(t, t))
    cov = A @ A.T + markov_sd**2 * np.exp(-lag / markov_time) + np.diag(0.05**2 / np.maximum(weight, 1e-9))
    density = multivariate_normal(cov=cov[np.ix_(there, there)])
    expected = sum(density.logpdf(window.r[there, axis]) for axis in range(2)) + there.sum() * np.log(2 * np.pi)
    seen = Whitened(window, markov_sd, markov_time)
    assert seen.base + seen.evidence(omega) == pytest.approx(expected, rel=1e-9)
    assert alone(window, markov_sd, markov_time) == pytest.approx(seen.base + seen.evidence(np.zeros(0)))


def test_lines_are_found_where_they_are():
    for seed in range(4):
        found = search(make_window(seed), 0.0, 4.0, -np.inf)
        np.testing.assert_allclose(np.sort(found.omega), [0.5, 1.0, 2.0], atol=0.03)
        order = np.argsort(found.omega)
        assert (np.abs(found.omega[order] - [0.5, 1.0, 2.0]) < 4 * found.omega_sd[order]).all()


def test_noise_about_lines_is_named_among_what_it_may_be():
    """The rate at which the wind changes, 2 sd^2 / time, is within the bank's steps of the true one."""
    for seed in range(4):
        window, rng = make_window(seed), np.random.default_rng(50 + seed)
        noisy = replace(window, r=window.r + markov(rng, 90, 0.2, 0.2, 4.0))
        for winds, speed in ((identify(window), 0.0), (identify(noisy), 0.02)):
            assert 1 <= len(winds) <= LINED
            assert all(len(wind.omega) == len(winds[0].omega) == len(wind.omega_sd) for wind in winds)
            speeds = [2 * wind.markov_sd**2 / wind.markov_time for wind in winds]
            assert min(speeds) <= 2.5 * speed + 1e-3
            assert max(speeds) >= speed / 2.5


def test_a_window_without_lines_has_none_and_the_likeliest_wind_of_the_bank():
    window = make_window(3, wind="markov")
    assert identify(window) == []
    assert likeliest(window) in BANK
    assert likeliest(make_window(3)).omega


def test_evidence_of_given_lines_is_that_of_their_search():
    window = make_window(2)
    found = search(window, 0.07, 4.0, -np.inf)
    assert given(window, 0.07, 4.0, found) == pytest.approx(found.evidence)
    assert given(window, 0.5, 4.0, found) < found.evidence


def test_no_line_is_invented():
    for seed in range(6):
        assert not search(make_window(seed, wind="none"), 0.0, 4.0, -np.inf).omega.size
        assert not search(make_window(seed, wind="markov"), 0.5, 4.0, -np.inf).omega.size


def test_the_right_noise_has_the_most_evidence():
    noises = [(0.0, 4.0), (0.1, 2.0), (0.2, 4.0), (0.5, 4.0), (1.5, 4.0)]
    for seed in range(4):
        window = make_window(seed, wind="markov")
        assert int(np.argmax([search(window, *noise, -np.inf).evidence for noise in noises])) == 3


def test_a_goal_out_of_reach_ends_the_search_early():
    window = make_window(2, wind="markov")
    free, bound = search(window, 0.0, 4.0, -np.inf), search(window, 0.0, 4.0, 1e6)
    assert len(bound.omega) == 1 < len(free.omega)


@pytest.mark.parametrize("wind", ["lines", "markov", "none"])
@pytest.mark.parametrize("noise", [(0.0, 4.0), (0.2, 4.0)])
def test_compiled_equals_numpy(wind, noise):
    window = make_window(3, n=81, wind=wind)
    omega, omega_sd = np.zeros(5), np.zeros(5)
    numbers = (window.period, window.noise_sd, *noise, -1e9)
    base, evidence, count = _kernel.align_lines("double", window.r, window.weight, numbers, POLY_SD, omega, omega_sd)
    found = search(window, *noise, -1e9, NO_LINES)
    assert base == pytest.approx(alone(window, *noise), rel=1e-9)
    assert count == len(found.omega)
    np.testing.assert_allclose(omega[:count], found.omega, rtol=1e-5)
    np.testing.assert_allclose(omega_sd[:count], found.omega_sd, rtol=1e-3)
    assert evidence == pytest.approx(found.evidence, abs=1e-4)
