"""The whole alignment: C and NumPy alike, causal, any heading, honest, and what it refuses."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from robustnav.alignment import Aligner, AlignSetup, align, reading_rows, zero_velocity
from robustnav.engine import _kernel
from robustnav.errors import InputError
from robustnav.frames import euler_from_quat, matrix_from_quat, quat_conjugate, quat_from_rotvec, quat_multiply
from robustnav.strapdown import Increments
from robustnav.units import ARCMIN, DEG

from .conftest import COARSE, FINE, make_case, setup_of, tilt_of

FIELDS = ("q_nb", "tilt_cov", "heading", "heading_sd", "gyro_bias", "accel_bias", "wind")


def run(case, **options):
    return align(case.increments, case.reference, case.t, case.setup, **options)


@pytest.mark.parametrize(("period", "seconds", "wind"), [(0.1, 13.0, "gusts"), (0.5, 70.5, "lines")])
def test_compiled_equals_numpy(period, seconds, wind):
    """At two readings a second the windows after the first minute are within reach of NumPy."""
    case = make_case(setup_of(COARSE, period), 7, seconds, wind)
    case.reference[len(case.t) // 2 :] += np.linspace(0, 2, len(case.t) - len(case.t) // 2)[:, None] ** 2
    case.reference[[2, 60, 61]] = np.nan
    compiled, numpy = run(case), run(case, backend="numpy")
    for field in FIELDS:
        np.testing.assert_allclose(getattr(compiled, field), getattr(numpy, field), rtol=1e-5, atol=1e-7, err_msg=field)
    np.testing.assert_array_equal(compiled.heading_observable, numpy.heading_observable)


def test_float_is_as_good_as_double(fine_case):
    double, single = run(fine_case), run(fine_case, backend="compiled-float")
    tilt = [np.linalg.norm(tilt_of(one.q_nb, fine_case.q_nb)[900:], axis=1).mean() for one in (double, single)]
    assert tilt[1] == pytest.approx(tilt[0], rel=0.1)
    np.testing.assert_allclose(single.tilt_radius[900:], double.tilt_radius[900:], rtol=0.1)
    np.testing.assert_allclose(single.heading_sd[900:], double.heading_sd[900:], rtol=0.1)


def test_nothing_is_known_before_its_time(fine_case):
    """What was said after the first part does not change with what came later, nor with how it was handed over."""
    whole, half = run(fine_case), run(fine_case.head(333))
    for field in FIELDS:
        np.testing.assert_array_equal(getattr(whole, field)[:333], getattr(half, field))
    rows = reading_rows(fine_case.increments, fine_case.reference)
    state, out = _kernel.align_begin("double", fine_case.setup.numbers), np.empty((len(rows), 22))
    for part in (slice(0, 7), slice(7, 500), slice(500, len(rows))):
        _kernel.align_run(state, rows[part], 1, out[part])
    np.testing.assert_array_equal(out[:, 12:15], whole.gyro_bias)
    every = np.empty((len(rows) // 10, 22))
    _kernel.align_run(_kernel.align_begin("double", fine_case.setup.numbers), rows, 10, every)
    np.testing.assert_array_equal(every, out[9::10])


@pytest.mark.parametrize("turn", [0.4, pi, -2.0])
@pytest.mark.parametrize("tilt_deg", [0.0, 30.0])
def test_no_attitude_is_preferred(turn, tilt_deg):
    """A unit mounted any other way on the same base levels as well: the filter's axes are turned, the wind is not."""
    case = make_case(setup_of(COARSE), 3, 40.0, "lines")
    body, inc = quat_from_rotvec([tilt_deg * DEG, 0.0, turn]), case.increments
    C = matrix_from_quat(body)
    rotation = quat_multiply(quat_multiply(body, inc.rotation), quat_conjugate(body))
    turned = Increments.of(rotation, inc.velocity @ C.T, (C @ inc.J @ C.T, C @ inc.H @ C.T), inc.dt)
    said = align(turned, case.reference, case.t, case.setup)
    tilt = np.linalg.norm(tilt_of(quat_multiply(said.q_nb, body), case.q_nb), axis=1)
    assert (tilt[200:] < 1.6 * said.tilt_radius[200:]).all()


def nees(runs: int, gyro_rms: float, wind: str, seconds: float) -> tuple[float, float, float, float]:
    """Mean NEES of tilt and heading, share of heading observable, median tilt [rad] at the end."""
    tilt, heading, seen, size = [], [], [], []
    for seed in range(runs):
        case = make_case(setup_of(gyro_rms), 500 + seed, seconds, wind)
        said = run(case)
        error = tilt_of(said.q_nb[-1:], case.q_nb[-1:])[0]
        # The covariance stands about the axes of the wander frame: compare turned invariants, its mean radius.
        tilt.append(error @ error / (0.5 * np.trace(said.tilt_cov[-1])))
        np.testing.assert_allclose(euler_from_quat(said.q_nb[-1])[2], said.heading[-1], atol=1e-9)
        C = matrix_from_quat(case.q_nb[-1])
        off = (said.heading[-1] - np.arctan2(C[1, 0], C[0, 0]) + pi) % (2 * pi) - pi
        heading.append((off / said.heading_sd[-1]) ** 2)
        seen.append(said.heading_observable[-1])
        size.append(np.linalg.norm(error))
    return float(np.mean(tilt)), float(np.mean(heading)), float(np.mean(seen)), float(np.median(size))


@pytest.mark.parametrize("wind", ["gusts", "none"])
def test_fine_gyros_find_north_and_know_how_well(wind):
    runs = 24
    tilt, heading, seen, size = nees(runs, FINE, wind, 60.0)
    low, high = chi2.ppf([0.005, 0.995], 2 * runs) / runs
    assert low < tilt < high
    low, high = chi2.ppf([0.005, 0.995], runs) / runs
    assert low < heading < high
    assert seen == 1.0
    assert size < 1.2 * ARCMIN


def test_coarse_gyros_level_and_say_that_north_is_out_of_reach():
    runs = 24
    tilt, _, seen, size = nees(runs, COARSE, "lines", 45.0)
    low, high = chi2.ppf([0.005, 0.995], 2 * runs) / runs
    assert low < tilt < high
    assert seen == 0.0
    assert size < 2.0 * ARCMIN


def test_level_within_ten_arcminutes_soon():
    times = []
    for seed in range(12):
        case = make_case(setup_of(COARSE), 700 + seed, 40.0, "lines")
        said = run(case)
        wrong = np.flatnonzero(np.linalg.norm(tilt_of(said.q_nb, case.q_nb)[30:], axis=1) > 10 * ARCMIN)
        times.append(case.t[30 + wrong[-1]] if wrong.size else 0.0)
        assert said.aligned_at < 40.0
    assert np.median(times) < 16
    assert np.percentile(times, 95) < 25


def test_a_tilt_is_not_told_from_a_large_bias_of_the_accelerometer():
    """Two degrees of it: a base that hardly sways leaves them as they were, and the claim with them."""
    setup, share = setup_of(COARSE, accel_bias_sd=0.35), []
    for seed in range(12):
        case = make_case(setup, 300 + seed, 40.0, "none")
        said = run(case)
        error = tilt_of(said.q_nb[-1:], case.q_nb[-1:])[0]
        share.append(error @ error / (0.5 * np.trace(said.tilt_cov[-1])))
    low, high = chi2.ppf([0.005, 0.995], 2 * 12) / 12
    assert low < np.mean(share) < high


def test_a_gap_in_the_reference_is_survived(fine_case):
    case = replace(fine_case, reference=fine_case.reference.copy())
    case.reference[300:400] = np.nan
    said = run(case)
    assert np.linalg.norm(tilt_of(said.q_nb, case.q_nb)[-1]) < said.tilt_radius[-1]
    assert (np.diff(said.tilt_radius[302:399]) > 0).mean() > 0.9


def test_a_base_at_rest_needs_no_reference(fine_case):
    at_rest, zeros = align(fine_case.increments, None, fine_case.t, fine_case.setup), np.zeros((len(fine_case.t), 2))
    same = align(fine_case.increments, zeros, fine_case.t, fine_case.setup)
    np.testing.assert_array_equal(at_rest.q_nb, same.q_nb)
    np.testing.assert_array_equal(zero_velocity(fine_case.increments), zeros)
    assert np.linalg.norm(tilt_of(at_rest.q_nb, fine_case.q_nb)[-1]) < at_rest.tilt_radius[-1]


def test_no_reference_teaches_nothing():
    case = make_case(setup_of(FINE), 4, 15.0, "none")
    for backend in ("compiled", "numpy"):
        said = align(case.increments, np.full_like(case.reference, np.nan), case.t, case.setup, backend=backend)
        assert np.isnan(said.aligned_at)
        assert not said.heading_observable.any()
        assert (said.tilt_radius[20:] > 0.3).all()


def test_no_answer_in_the_first_two_seconds(fine_case):
    said = run(fine_case.head(30))
    assert np.isnan(said.q_nb[:19]).all() and np.isfinite(said.q_nb[19:]).all()
    assert not said.heading_observable[:19].any()
    assert np.isnan(run(fine_case.head(10)).aligned_at)
    assert len(run(fine_case.head(0)).t) == 0
    assert Aligner(fine_case.setup).read() is None


def test_bad_input_is_refused(fine_case):
    case = fine_case.head(5)
    inc, z, t, setup = case.increments, case.reference, case.t, case.setup
    with pytest.raises(InputError, match="reference velocity"):
        align(inc, z[:4], t, setup)
    with pytest.raises(InputError, match="row 2"):
        align(inc, np.where(np.arange(5)[:, None] == 2, np.inf, z), t, setup)
    with pytest.raises(InputError, match="time of alignment"):
        align(inc, z, t[:4], setup)
    with pytest.raises(InputError, match="row 3"):
        align(inc, z, t + 0.02 * (np.arange(5) >= 3), setup)
    with pytest.raises(InputError, match="backend"):
        align(inc, z, t, setup, backend="fortran")
    with pytest.raises(InputError, match=r"0\.2 s each"):
        align(replace(inc, dt=0.2), z, t, setup)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[("period", seconds) for seconds in (0.05, 0.3, -0.1)],
        *[("gust_share", share) for share in (1.0, -0.1)],
        ("latitude", 89 * DEG),
        ("gyro_density", 0.0),
        ("reference_sd", float("nan")),
        ("gravity", float("inf")),
    ],
)
def test_a_bad_setup_is_refused(name, value):
    with pytest.raises(InputError, match=name):
        replace(setup_of(), **{name: value})


def test_published_setting():
    setup = AlignSetup.published(1e-4, 1e-3, 0.0)
    assert setup.gyro_density == pytest.approx(1e-4 * np.sqrt(1e-3))
    assert setup.heading_floor == pytest.approx(np.sqrt(2) * 1e-4 / 7.292115e-5)


ANYTHING = st.one_of(
    st.none(),
    st.floats(),
    st.integers(-3, 3),
    st.text(max_size=2),
    st.builds(np.zeros, st.integers(0, 60)),
    st.builds(lambda n: np.full(n, np.nan), st.sampled_from([15, 30, 60, 300])),
    st.lists(st.floats(), min_size=15, max_size=15),
)


@settings(max_examples=50)
@given(st.lists(ANYTHING, min_size=4, max_size=10))
def test_the_extension_answers_or_refuses(arguments):
    state = _kernel.align_begin("double", setup_of().numbers)
    for call in (
        lambda: _kernel.align_begin(*arguments[:2]),
        lambda: _kernel.align_begin("float", arguments[0]),
        lambda: _kernel.align_run(*arguments[:4]),
        lambda: _kernel.align_run(state, *arguments[:3]),
        lambda: _kernel.align_one("double", *arguments),
        lambda: _kernel.align_lines("double", np.zeros((9, 2)), np.ones(9), tuple(arguments[:5]), *arguments[-3:]),
    ):
        try:
            call()
        except (TypeError, ValueError, OverflowError):
            continue


@settings(max_examples=50)
@given(st.lists(st.floats(), min_size=15, max_size=15), st.floats())
def test_odd_numbers_do_no_harm(numbers, fill):
    try:
        state = _kernel.align_begin("double", np.array(numbers))
    except ValueError:
        numbers[0] = 0.5
        state = _kernel.align_begin("float", np.array(numbers))
    out = np.empty((30, 22))
    _kernel.align_run(state, np.full((30, 30), fill), 1, out)
