"""The bias curve: hat functions, exact recovery, knots by held-out files."""

import numpy as np
import pytest

from robustnav.calibrate import LEAST_SQUARES, BiasCurve, Pairs, choose_curve, fit_curve, fit_line, held_out
from robustnav.calibrate.bias_curve import hats
from robustnav.errors import InputError


def curved(rng, bias, *, files=40, each=12, sd=0.02, file_sd=0.02):
    file = np.repeat(np.arange(files), each)
    d = np.linspace(1, 60, files)[file]
    common = file_sd * rng.standard_normal(files)[file]
    return Pairs(d, d + bias(d) + common + sd * rng.standard_normal(len(d)), file=file)


def test_hats_sum_to_one_and_are_one_at_their_knot():
    knots = (2.0, 5.0, 11.0, 30.0)
    r = np.linspace(-5, 40, 200)
    np.testing.assert_allclose(hats(r, knots).sum(axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(hats(np.array(knots), knots), np.eye(4))


def test_a_curve_of_its_own_kind_is_found_exactly():
    truth = BiasCurve((2.0, 10.0, 40.0), (0.1, -0.2, 0.3), 0.0)
    r = np.linspace(0, 50, 200)
    pairs = Pairs(r - np.interp(r, truth.knots, truth.bias) + 1, r + 1)
    curve = fit_curve(pairs, (3.0, 11.0, 41.0))
    np.testing.assert_allclose(curve.bias, truth.bias, atol=1e-9)
    np.testing.assert_allclose(curve.distance(pairs.measured), pairs.distance_true, atol=1e-9)


def test_the_variance_holds_the_doubt_about_the_curve():
    rng = np.random.default_rng(1)
    at, error, claimed = np.array([5.0, 28.0, 55.0]), [], []
    for _ in range(400):
        d = rng.uniform(1, 60, 40)
        curve = fit_curve(Pairs(d, d + 0.2 + 0.05 * rng.standard_normal(40)), (5.0, 30.0, 55.0), LEAST_SQUARES)
        error.append(curve.distance(at + 0.2) - at)
        claimed.append(curve.distance_variance(at + 0.2) - curve.range_variance)
    ratio = np.var(error, axis=0) / np.mean(claimed, axis=0)
    assert (np.abs(ratio - 1) < 4 * np.sqrt(2 / 400) + 0.05).all()


def test_held_out_files_choose_few_knots_for_a_line_and_more_for_a_bend():
    rng = np.random.default_rng(2)
    straight = choose_curve(curved(rng, lambda d: 0.1 + 0.002 * d))
    assert len(straight.curve.knots) == 2
    bent_pairs = curved(rng, lambda d: 0.3 * np.tanh(d / 12))
    bent = choose_curve(bent_pairs)
    assert 3 <= len(bent.curve.knots) <= 8
    assert bent.errors[len(bent.curve.knots)].rms < 0.8 * held_out(bent_pairs, fit_line).rms
    assert bent.curve.fitted.files == 40


def test_what_holds_no_curve_is_refused():
    rng = np.random.default_rng(3)
    pairs = curved(rng, np.zeros_like)
    with pytest.raises(InputError, match="near the knot at 90 m"):
        fit_curve(pairs, (2.0, 70.0, 90.0))
    with pytest.raises(InputError, match="ascending"):
        fit_curve(pairs, (5.0, 2.0))
    with pytest.raises(InputError, match="ascending"):
        fit_curve(pairs, (5.0,))
    with pytest.raises(InputError, match="no files"):
        choose_curve(Pairs(pairs.distance_true, pairs.measured))
    same = Pairs(np.full(30, 5.0), np.full(30, 5.1), file=np.arange(30))
    with pytest.raises(InputError):
        choose_curve(same)
    with pytest.raises(InputError, match="bias curve"):
        BiasCurve((1.0, 2.0), (0.0,), 0.1)
