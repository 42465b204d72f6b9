"""The bank over a wind that changes: what the lines taught is kept, and C does what NumPy does."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav.alignment import align
from robustnav.frames import quat_conjugate, rotate
from robustnav.units import ARCMIN, DEG, DPS, MILLI_G

from .conftest import COARSE, FINE, Case, make_case, markov, setup_of, tilt_of

CHANGE = 100.0  # s
BACKENDS = ("compiled", "numpy")


def changed(case: Case, seed: int) -> Case:
    """Return the case with a Gauss-Markov wind of 0.5 m/s and 4 s instead of its lines after the change."""
    other = make_case(case.setup, seed, float(case.t[-1]), "markov").reference
    return replace(case, reference=np.where(case.t[:, None] > CHANGE, other, case.reference))


def in_markov(case: Case, seed: int, sd: float, time: float) -> Case:
    """Return the case with a Gauss-Markov wind besides its own."""
    wind = markov(np.random.default_rng(seed), len(case.t), case.setup.period, sd, time)
    return replace(case, reference=case.reference + wind)


def in_another_mean(case: Case) -> Case:
    """Return the case with a mean wind that jumps at the change."""
    return replace(case, reference=case.reference + np.where(case.t[:, None] > CHANGE, [-1.5, 1.0], 0.0))


def judged(cases: list[Case], times: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the size of tilt (cases, n) [rad] at all instants, and the mean NEES, two expected, at times [s]."""
    size, nees = [], []
    for case in cases:
        said = align(case.increments, case.reference, case.t, case.setup)
        error = tilt_of(said.q_nb, case.q_nb)
        size.append(np.linalg.norm(error, axis=1))
        at = np.searchsorted(case.t, np.array(times) - 1e-6)
        nees.append([error[k] @ np.linalg.solve(said.tilt_cov[k], error[k]) for k in at])
    return np.array(size), np.mean(nees, axis=0)


@pytest.mark.parametrize("change", [changed, lambda case, _: in_another_mean(case)], ids=["lines end", "mean"])
def test_what_lines_taught_is_kept_and_doubt_is_true_from_the_change_on(change):
    """Good gyros hold the level that lines gave; a filter that never knew them has only what the new wind allows."""
    runs = 24
    cases = [change(make_case(setup_of(FINE), 80 + seed, 190.0, "lines"), seed) for seed in range(runs)]
    size, nees = judged(cases, [CHANGE + after for after in (0, 1, 3, 8, 15, 25, 50, 90)])
    t = cases[0].t
    before, after = (size[:, (t > first) & (t < first + 50)].mean(axis=1) for first in (CHANGE - 50, CHANGE))
    assert np.median(after) < 1.15 * np.median(before)
    assert np.max(after) < 1.5 * np.max(before)
    low, high = chi2.ppf([0.001, 0.999], 2 * runs) / runs
    assert (low < nees).all() and (nees < high).all(), nees


@pytest.mark.parametrize(
    ("wind", "sd", "time"), [("none", 0.2, 8.0), ("none", 1.0, 8.0), ("none", 0.7, 2.0), ("lines", 0.1, 4.0)]
)
def test_doubt_is_true_in_winds_that_the_bank_does_not_hold(wind, sd, time):
    runs = 24
    cases = [in_markov(make_case(setup_of(COARSE), 40 + k, 100.0, wind), k, sd, time) for k in range(runs)]
    _, nees = judged(cases, (50.0, 100.0))
    low, high = chi2.ppf([0.001, 0.999], 2 * runs) / runs
    assert (0.5 * low < nees).all() and (nees < high).all(), nees  # a wind of unknown speed is rather taken for slow


def test_a_mean_wind_that_jumps_is_learned_anew():
    runs = 24
    cases = [in_another_mean(make_case(setup_of(COARSE), 200 + k, 190.0, "lines")) for k in range(runs)]
    size, nees = judged(cases, (CHANGE + 50, CHANGE + 90))
    low, high = chi2.ppf([0.001, 0.999], 2 * runs) / runs
    assert (low < nees).all() and (nees < high).all(), nees
    assert np.median(size[:, -1]) < 1.5 * ARCMIN


def test_lines_that_begin_are_soon_free_of_the_wind_before_them():
    """The first windows in which they are found hold both."""
    cases = []
    for k in range(40):
        first, then = (make_case(setup_of(FINE), 700 + k, 150.0, wind) for wind in ("markov", "lines"))
        cases.append(replace(first, reference=np.where(first.t[:, None] > CHANGE, then.reference, first.reference)))
    size, _ = judged(cases, (150.0,))
    late = size[:, cases[0].t > CHANGE + 30].mean(axis=1)
    assert np.median(late) < 0.8 * ARCMIN
    assert np.sum(late > 2 * ARCMIN) <= 1


def test_a_stronger_wind_is_followed():
    runs = 24
    cases = []
    for k in range(runs):
        case = in_markov(make_case(setup_of(COARSE), 60 + k, 130.0, "none"), k, 0.2, 4.0)
        strong = in_markov(case, 500 + k, 1.0, 8.0)
        cases.append(replace(case, reference=np.where(case.t[:, None] > CHANGE, strong.reference, case.reference)))
    _, nees = judged(cases, (CHANGE + 10, CHANGE + 25))
    low, high = chi2.ppf([0.001, 0.999], 2 * runs) / runs
    assert (low < nees).all() and (nees < high).all(), nees


@pytest.mark.parametrize(
    "change", [changed, lambda case, _: in_another_mean(case), lambda case, k: in_markov(case, k, 0.1, 4.0)]
)
def test_compiled_equals_numpy_where_the_wind_changes(change):
    case = change(make_case(setup_of(FINE, 0.5), 7, 131.0, "lines"), 3)
    compiled, numpy = (align(case.increments, case.reference, case.t, case.setup, backend=b) for b in BACKENDS)
    for field in ("q_nb", "tilt_cov", "heading", "wind"):
        np.testing.assert_allclose(getattr(compiled, field), getattr(numpy, field), rtol=1e-4, atol=1e-6, err_msg=field)


def raw(seed: int, period: float, seconds: float, wind: str, **numbers: float) -> Case:
    """A unit straight from its maker: gyros off by degrees a second, accelerometers by degrees of tilt."""
    biases = {"gyro_bias_sd": 2.9 * DPS, "accel_bias_sd": 46 * MILLI_G}
    setup = setup_of(COARSE, period, **{**biases, **numbers})
    return make_case(setup, seed, seconds, wind)


@pytest.mark.parametrize(("seconds", "wind"), [(35.0, "none"), (24.0, "lines")])
def test_large_biases_of_gyro_and_accelerometer_are_told_as_far_as_they_can(seconds, wind):
    runs = 24
    _, nees = judged([raw(900 + k, 0.1, seconds, wind) for k in range(runs)], (seconds,))
    low, high = chi2.ppf([0.005, 0.995], 2 * runs) / runs
    assert low < nees[0] < high


@pytest.mark.parametrize(("gyro_dps", "wind"), [(2.9, "none"), (2.9, "lines"), (0.04, "lines")])
def test_large_biases_stay_told_apart_while_the_estimate_turns_about_down(gyro_dps, wind):
    """46 mg hide 2.6 deg of tilt for minutes; linear about the estimate a filter would soon claim a tenth of that."""
    cases = [raw(900 + k, 0.1, 190.0, wind, gyro_bias_sd=gyro_dps * DPS) for k in range(24)]
    _, nees = judged(cases, (60.0, 100.0, 140.0, 190.0))
    assert (nees > 1.0).all() and (nees < 4.0).all(), nees


@pytest.mark.parametrize("compass", [False, True])
def test_compiled_equals_numpy_over_recentrings(compass):
    """After 5, 12 and 30 s; later a filter starts from an anchored snapshot."""
    given = {"declination": 0.1, "compass_sd": 1 * DEG, "compass_bias_sd": 2 * DEG} if compass else {}
    case = changed(raw(3, 0.5, 122.0, "lines", **given), 3)
    field_n = np.tile([0.5, 0.05, 0.8], (len(case.t), 1))
    field_b = rotate(quat_conjugate(case.q_nb), field_n) if compass else None
    compiled, numpy = (
        align(case.increments, case.reference, case.t, case.setup, backend=b, field_b=field_b) for b in BACKENDS
    )
    for field in ("q_nb", "tilt_cov", "heading", "gyro_bias", "accel_bias", "wind", "compass_bias"):
        np.testing.assert_allclose(getattr(compiled, field), getattr(numpy, field), rtol=1e-4, atol=1e-6, err_msg=field)
