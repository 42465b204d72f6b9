"""The range line: the published estimates, honest intervals, gross errors, and what is no line."""

import numpy as np
import pytest
from scipy.stats import binom

from robustnav.calibrate import HUBER, LEAST_SQUARES, STUDENT_T, Loss, Pairs, RangeLine, fit_line
from robustnav.errors import EstimatorError, InputError

LOSSES = [LEAST_SQUARES, HUBER, STUDENT_T]
name_of = lambda loss: loss.kind  # noqa: E731


def alone(pairs):
    """Return the pairs without their files: independent readings."""
    return Pairs(pairs.distance_true, pairs.measured)


def test_least_squares_gives_the_published_estimates(made):
    pairs = made(np.random.default_rng(1))
    line = fit_line(alone(pairs), LEAST_SQUARES)
    d, r, n = pairs.distance_true, pairs.measured, len(pairs)
    a = np.sum((d - d.mean()) * (r - r.mean())) / np.sum((d - d.mean()) ** 2)
    b = r.mean() - a * d.mean()
    s2 = np.sum((r - a * d - b) ** 2) / (n - 2)
    np.testing.assert_allclose([line.slope, line.offset, line.range_variance], [a, b, s2], rtol=1e-11)
    np.testing.assert_allclose(line.variance, s2 / a**2, rtol=1e-11)
    new = np.array([3.0, 31.0, 70.0])
    np.testing.assert_allclose(line.distance(new), new / a - b / a, rtol=1e-13)
    spread = 1 + 1 / n + (line.distance(new) - d.mean()) ** 2 / np.sum((d - d.mean()) ** 2)
    np.testing.assert_allclose(line.distance_variance(new), s2 / a**2 * spread, rtol=1e-9)


def within(hits, runs, level=0.95):
    """Whether a count of covered truths is one that intervals of this level give in 999 cases of 1000."""
    low, high = binom.ppf([0.0005, 0.9995], runs, level)
    return low <= hits <= high


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
def test_intervals_cover_the_truth_as_often_as_they_say(made, loss):
    rng = np.random.default_rng(2)
    runs, hits = 400, dict.fromkeys(("slope", "offset", "range_variance"), 0)
    truth = {"slope": 1.004, "offset": 0.08, "range_variance": 0.05**2}
    for _ in range(runs):
        ends = fit_line(alone(made(rng, files=20, each=8)), loss).intervals(0.95)
        for name, (low, high) in ends.items():
            hits[name] += low < truth[name] < high
    assert all(within(count, runs) for count in hits.values()), hits


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
def test_errors_common_to_a_file_are_covered_only_with_the_files(made, loss):
    rng = np.random.default_rng(3)
    runs, told, untold = 300, 0, 0
    for _ in range(runs):
        pairs = made(rng, files=40, each=8, sd=0.03, file_sd=0.05)
        low, high = fit_line(pairs, loss).intervals()["slope"]
        told += low < 1.004 < high
        low, high = fit_line(alone(pairs), loss).intervals()["slope"]
        untold += low < 1.004 < high
    assert 0.90 * runs < told < 0.985 * runs
    assert untold < 0.7 * runs


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
def test_files_of_independent_errors_change_no_interval(made, loss):
    pairs = made(np.random.default_rng(11), files=400, each=10)
    told, untold = fit_line(pairs, loss), fit_line(alone(pairs), loss)
    # The spread of a variance over 400 files is sqrt(2 / 400) of it.
    np.testing.assert_allclose(told.fitted.covariance, untold.fitted.covariance, rtol=4 * np.sqrt(2 / 400))
    assert (told.fitted.dof, untold.fitted.dof) == (398, 3998)


def test_a_calibrated_distance_errs_as_its_variance_says(made):
    rng = np.random.default_rng(4)
    ratios = []
    for _ in range(800):
        line = fit_line(alone(made(rng, files=4, each=2)), LEAST_SQUARES)
        r = 1.004 * 90 + 0.08 + 0.05 * rng.standard_normal()  # far outside: the line's own part counts most
        ratios.append((float(line.distance(r)) - 90) ** 2 / float(line.distance_variance(r)))
    # The square of Student's t with six degrees of freedom has the mean 1.5 and the variance 13.5.
    assert abs(np.mean(ratios) - 1.5) < 3.5 * np.sqrt(13.5 / 800)


@pytest.mark.parametrize("sign", ["both", "long"])
def test_one_gross_error_in_five_does_not_move_the_robust_lines(made, sign):
    rng = np.random.default_rng(5)
    pairs = made(rng, files=30, each=20)
    gross = rng.random(len(pairs)) < 0.2
    jump = rng.uniform(1, 5, len(pairs)) * (1 if sign == "long" else rng.choice([-1, 1], len(pairs)))
    spoiled = Pairs(pairs.distance_true, pairs.measured + np.where(gross, jump, 0))
    clean = fit_line(alone(pairs), LEAST_SQUARES)
    error = {}
    for loss in LOSSES:
        line = fit_line(spoiled, loss)
        error[loss.kind] = np.abs(
            line.distance(np.array([2.0, 30, 60])) - clean.distance(np.array([2.0, 30, 60]))
        ).max()
        if loss is not LEAST_SQUARES:
            assert abs(line.fitted.outliers - gross.sum()) <= 3
            assert 0.04 < np.sqrt(line.range_variance) < 0.075
    assert error["student_t"] < 0.012
    assert error["huber"] < (0.05 if sign == "long" else 0.02)
    assert error["least_squares"] > (0.5 if sign == "long" else 0.05)


def test_endless_constants_give_least_squares(made):
    pairs = made(np.random.default_rng(6), file_sd=0.02)
    want = fit_line(pairs, LEAST_SQUARES)
    for loss in (Loss("huber", 1e9), Loss("student_t", 1e12), Loss("huber"), Loss("student_t")):
        line = fit_line(pairs, loss)
        np.testing.assert_allclose([line.slope, line.offset], [want.slope, want.offset], rtol=1e-8)
        np.testing.assert_allclose(line.fitted.covariance, want.fitted.covariance, rtol=1e-6)


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
def test_shifts_units_and_order_change_what_they_should(made, loss):
    pairs = made(np.random.default_rng(7), file_sd=0.02)
    line = fit_line(pairs, loss)

    def same(other, slope, offset, variance):
        got = [other.slope, other.offset, other.range_variance]
        np.testing.assert_allclose(got, [slope, offset, variance], rtol=1e-6, atol=1e-9)
        assert other.fitted.outliers == line.fitted.outliers

    moved = fit_line(Pairs(pairs.distance_true, pairs.measured + 5, file=pairs.file), loss)
    same(moved, line.slope, line.offset + 5, line.range_variance)
    far = fit_line(Pairs(pairs.distance_true + 7, pairs.measured, file=pairs.file), loss)
    same(far, line.slope, line.offset - 7 * line.slope, line.range_variance)
    np.testing.assert_allclose(far.distance_variance(30.0), line.distance_variance(30.0), rtol=1e-6)
    small = fit_line(Pairs(pairs.distance_true * 1000, pairs.measured * 1000, file=pairs.file), loss)
    same(small, line.slope, line.offset * 1000, line.range_variance * 1e6)
    order = np.random.default_rng(8).permutation(len(pairs))
    mixed = fit_line(pairs.where(order), loss)
    same(mixed, line.slope, line.offset, line.range_variance)
    np.testing.assert_allclose(mixed.fitted.covariance, line.fitted.covariance, rtol=1e-6)


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
def test_readings_on_a_line_give_it_back(loss):
    d = np.array([1.0, 2.0, 5.0, 9.0, 9.0])
    line = fit_line(Pairs(d, 1.01 * d - 0.3), loss)
    np.testing.assert_allclose([line.slope, line.offset], [1.01, -0.3], rtol=1e-12)
    assert line.range_variance < 1e-24
    np.testing.assert_allclose(line.distance(1.01 * d - 0.3), d, rtol=1e-12)


def test_a_majority_on_a_line_beats_gross_errors_exactly():
    d = np.arange(1.0, 21.0)
    r = 1.01 * d + 0.2
    r[::4] += 3.0
    for loss in (HUBER, STUDENT_T):
        line = fit_line(Pairs(d, r), loss)
        np.testing.assert_allclose([line.slope, line.offset], [1.01, 0.2], atol=1e-6)


@pytest.mark.parametrize("loss", [LEAST_SQUARES, HUBER, Loss("huber", 0.5), STUDENT_T], ids=str)
def test_the_influence_slopes_as_its_derivative_says(loss):
    u = np.linspace(-6, 6, 101) + 0.0123
    h = 1e-6
    numeric = ((u + h) * loss.weight(u + h) - (u - h) * loss.weight(u - h)) / (2 * h)
    np.testing.assert_allclose(loss.slope(u), numeric, atol=1e-8)


@pytest.mark.parametrize(
    ("d", "r", "words"),
    [
        ([], [], "0 distances"),
        ([1.0], [1.0], "1 distances"),
        ([5.0] * 9, np.linspace(5, 6, 9), "1 distances"),
        ([1.0, 1.0, 2.0, 2.0], [1.0, 1.1, 2.0, 2.1], "2 distances"),
        ([1.0, 2.0, 3.0], [3.0, 2.0, 1.0], "grow with the distance"),
        (5 + 1e-6 * np.arange(40), 5 + 0.05 * np.sin(np.arange(40.0) ** 2), "grow with the distance"),
        (1 + 1e-15 * np.arange(9), np.arange(9.0), "distances"),
    ],
)
@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
def test_what_holds_no_line_is_refused(d, r, words, loss):
    with pytest.raises(InputError, match=words):
        fit_line(Pairs(np.array(d), np.array(r)), loss)


def test_too_few_files_are_refused(made):
    pairs = made(np.random.default_rng(9))
    with pytest.raises(InputError, match="2 files"):
        fit_line(Pairs(pairs.distance_true, pairs.measured, file=pairs.file % 2))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"distance_true": [1.0, np.nan], "measured": [1.0, 2.0]}, "distance_true, row 1"),
        ({"distance_true": [1.0, 2.0], "measured": [np.inf, 2.0]}, "measured, row 0"),
        ({"distance_true": [-1.0, 2.0], "measured": [1.0, 2.0]}, "distance_true, row 0"),
        ({"distance_true": [1.0, 2.0], "measured": [1.0]}, "shape"),
        ({"distance_true": [[1.0]], "measured": [[1.0]]}, "shape"),
        ({"distance_true": [1.0], "measured": [1.0], "anchor": ["a", "b"]}, "anchor(.|\n)*shape"),
        ({"distance_true": [1.0], "measured": [1.0], "file": ["a"]}, "whole numbers"),
    ],
)
def test_pairs_that_do_not_pair_are_refused(arguments, words):
    with pytest.raises(InputError, match=words):
        Pairs(**arguments)


@pytest.mark.parametrize("arguments", [(0.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (1.0, np.nan, 1.0), (1.0, 0.0, -1.0)])
def test_a_line_of_impossible_numbers_is_refused(arguments):
    with pytest.raises(InputError, match="range line"):
        RangeLine(*arguments)


@pytest.mark.parametrize("arguments", [("median",), ("huber", 0.0), ("huber", np.nan), ("least_squares", 2.0)])
def test_a_loss_that_is_none_is_refused(arguments):
    with pytest.raises(InputError, match="loss"):
        Loss(*arguments)


def test_a_stated_line_has_no_intervals_but_a_variance():
    line = RangeLine(1.02, 0.1, 0.0004)
    np.testing.assert_allclose(line.distance_variance([1.0, 50.0]), 0.0004 / 1.02**2)
    with pytest.raises(InputError, match="fitted line"):
        line.intervals()


def test_levels_outside_one_are_refused(made):
    line = fit_line(made(np.random.default_rng(10)))
    with pytest.raises(InputError, match="level"):
        line.intervals(1.0)


def test_two_lines_of_equal_weight_end_in_an_answer_or_say_so():
    d = np.tile(np.arange(1.0, 30.0), 2)
    r = d + np.repeat([0.0, 5.0], 29)
    for loss in (HUBER, STUDENT_T):
        try:
            assert np.isfinite(fit_line(Pairs(d, r), loss).offset)
        except EstimatorError as why:
            assert "two lines" in str(why)
