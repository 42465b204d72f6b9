"""The bank over a wind that changes: what the lines taught is kept, and C does what NumPy does."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav.alignment import align
from robustnav.frames import quat_conjugate, rotate
from robustnav.units import DEG, DPS, MILLI_G

from .conftest import COARSE, FINE, Case, make_case, setup_of, tilt_of

CHANGE = 100.0  # s
BACKENDS = ("compiled", "numpy")


def changed(case: Case, seed: int) -> Case:
    """Return the case with a Gauss-Markov wind of 0.5 m/s and 4 s instead of its lines after the change."""
    other = make_case(case.setup, seed, float(case.t[-1]), "markov").reference
    return replace(case, reference=np.where(case.t[:, None] > CHANGE, other, case.reference))


def test_lines_that_end_leave_what_they_taught():
    """Good gyros hold the level that lines gave; a filter that never knew them has only what the new wind allows."""
    before, after, radius = [], [], []
    for seed in range(6):
        case = changed(make_case(setup_of(FINE), 80 + seed, 140.0, "lines"), seed)
        said = align(case.increments, case.reference, case.t, case.setup)
        size = np.linalg.norm(tilt_of(said.q_nb, case.q_nb), axis=1)
        stretch = case.t > CHANGE + 20
        before.append(size[(case.t > 50) & (case.t < CHANGE)].mean())
        after.append(size[stretch].mean())
        radius.append((size < said.tilt_radius)[stretch].mean())
    assert np.median(after) < 1.5 * np.median(before)
    assert np.mean(radius) > 0.8


def test_compiled_equals_numpy_where_lines_end():
    case = changed(make_case(setup_of(FINE, 0.5), 7, 122.0, "lines"), 3)
    compiled, numpy = (align(case.increments, case.reference, case.t, case.setup, backend=b) for b in BACKENDS)
    for field in ("q_nb", "tilt_cov", "heading", "wind"):
        np.testing.assert_allclose(getattr(compiled, field), getattr(numpy, field), rtol=1e-4, atol=1e-6, err_msg=field)


def raw(seed: int, period: float, seconds: float, wind: str, **numbers: float) -> Case:
    """A unit straight from its maker: gyros off by degrees a second, accelerometers by degrees of tilt."""
    setup = setup_of(COARSE, period, gyro_bias_sd=2.9 * DPS, accel_bias_sd=46 * MILLI_G, **numbers)
    return make_case(setup, seed, seconds, wind)


@pytest.mark.parametrize(("seconds", "wind"), [(35.0, "none"), (24.0, "lines")])
def test_large_biases_of_gyro_and_accelerometer_are_told_as_far_as_they_can(seconds, wind):
    runs, share = 24, []
    for seed in range(runs):
        case = raw(900 + seed, 0.1, seconds, wind)
        said = align(case.increments, case.reference, case.t, case.setup)
        error = tilt_of(said.q_nb[-1:], case.q_nb[-1:])[0]
        share.append(error @ error / (0.5 * np.trace(said.tilt_cov[-1])))
    low, high = chi2.ppf([0.005, 0.995], 2 * runs) / runs
    assert low < np.mean(share) < high


@pytest.mark.parametrize("compass", [False, True])
def test_compiled_equals_numpy_over_recentrings(compass):
    """After 5, 12 and 30 s; the anchor moves every 15 s from 45 s on; a filter starts from an anchored snapshot."""
    given = {"declination": 0.1, "compass_sd": 1 * DEG, "compass_bias_sd": 2 * DEG} if compass else {}
    case = changed(raw(3, 0.5, 122.0, "lines", **given), 3)
    field_n = np.tile([0.5, 0.05, 0.8], (len(case.t), 1))
    field_b = rotate(quat_conjugate(case.q_nb), field_n) if compass else None
    compiled, numpy = (
        align(case.increments, case.reference, case.t, case.setup, backend=b, field_b=field_b) for b in BACKENDS
    )
    for field in ("q_nb", "tilt_cov", "heading", "gyro_bias", "accel_bias", "wind", "compass_bias"):
        np.testing.assert_allclose(getattr(compiled, field), getattr(numpy, field), rtol=1e-4, atol=1e-6, err_msg=field)
