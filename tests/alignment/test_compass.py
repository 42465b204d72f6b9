"""The compass: the row it adds, C and NumPy alike, honest headings from any gyro, disturbed fields, bad input."""

from dataclasses import replace
from math import nan, pi

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav.alignment import align, reading_rows
from robustnav.alignment.compass import bearing, fair_fields, take_bearing
from robustnav.alignment.filter import COMPASS, RATE, predict, start, update, with_wind
from robustnav.alignment.heading import answer
from robustnav.alignment.readings import FIELD, VELOCITY
from robustnav.alignment.setting import AlignSetup, Wind
from robustnav.errors import InputError
from robustnav.frames import matrix_from_quat, quat_conjugate, quat_from_rotvec, quat_multiply, rotate, wrap_angle
from robustnav.units import DEG, DPS, MICRO_TESLA

from .conftest import COARSE, FINE, Case, make_case, setup_of, tilt_of
from .test_filter import one_filter

DECLINATION = 5 * DEG
COMPASS_NUMBERS = {"declination": DECLINATION, "compass_sd": 1 * DEG, "compass_bias_sd": 2 * DEG}
MEMS = {
    "gyro_density": 6e-5,
    "gyro_bias_sd": 0.5 * DPS,
    "gyro_bias_walk": 5e-6,
    "accel_density": 1e-3,
    "accel_bias_sd": 0.05,
    "accel_bias_walk": 1e-4,
}
GRADES = {"mems": MEMS, "fine": {}, "coarse": vars(setup_of(COARSE))}


def with_compass(grade: str = "coarse", **numbers: float) -> AlignSetup:
    return replace(setup_of(FINE, **COMPASS_NUMBERS), **{**GRADES[grade], **COMPASS_NUMBERS, **numbers})


def field_of(case: Case, seed: int, dip: float = 60 * DEG) -> tuple[np.ndarray, float]:
    """Field in body axes (n, 3) [T] with the setup's errors, and the constant one [rad]."""
    rng, compass = np.random.default_rng(10_000 + seed), case.setup.compass
    error = compass.bias_sd * rng.standard_normal()
    azimuth = compass.declination + error + compass.sd * rng.standard_normal(len(case.t))
    level = np.cos(dip) * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    field_n = 48 * MICRO_TESLA * np.column_stack([level, np.full(len(case.t), np.sin(dip))])
    return rotate(quat_conjugate(case.q_nb), field_n), error


def run(case: Case, field, **options):
    return align(case.increments, case.reference, case.t, case.setup, field_b=field, **options)


def heading_error(said, case: Case) -> float:
    C = matrix_from_quat(case.q_nb[-1])
    return float(wrap_angle(said.heading[-1] - np.arctan2(C[1, 0], C[0, 0])))


def nees(setup: AlignSetup, wind: str, seconds: float, runs: int, spoil=lambda field, rng: field):
    """Mean NEES of tilt, heading and compass error at the end, share observable, and the medians of two sd."""
    rows = []
    for seed in range(runs):
        case = make_case(setup, 900 + seed, seconds, wind)
        field, error = field_of(case, seed)
        said = run(case, spoil(field, np.random.default_rng(seed)))
        tilt = tilt_of(said.q_nb[-1:], case.q_nb[-1:])[0]
        size = tilt @ tilt / (0.5 * np.trace(said.tilt_cov[-1]))
        off = (heading_error(said, case) / said.heading_sd[-1]) ** 2
        compass = ((said.compass_bias[-1] - error) / said.compass_bias_sd[-1]) ** 2
        rows.append([size, off, compass, said.heading_observable[-1], said.heading_sd[-1], said.compass_bias_sd[-1]])
    rows = np.array(rows)
    return (*rows[:, :4].mean(axis=0), *np.median(rows[:, 4:], axis=0))


def in_band(mean: float, freedom: int, runs: int) -> bool:
    low, high = chi2.ppf([0.005, 0.995], freedom * runs) / runs
    return low < mean < high


def test_bearing_and_its_slope_by_the_attitude():
    """Where the field is, by hand; then the slope the row uses, by turning the attitude a little."""
    q = quat_from_rotvec([0.3, -0.8, 1.1])
    field_b = rotate(quat_conjugate(q), np.array([-3.0, 4.0, 12.0]))
    seen = bearing(q, field_b)
    assert seen.azimuth == pytest.approx(np.arctan2(4.0, -3.0))
    assert seen.steepness == pytest.approx(12 / 5)
    expected = [-seen.steepness * np.cos(seen.azimuth), -seen.steepness * np.sin(seen.azimuth), 1.0]
    for j in range(3):
        ahead, behind = (
            bearing(quat_multiply(quat_from_rotvec(h * np.eye(3)[j]), q), field_b).azimuth for h in (1e-5, -1e-5)
        )
        assert (ahead - behind) / 2e-5 == pytest.approx(expected[j], abs=1e-6)
    assert bearing(q, np.full(3, nan)) is None
    assert bearing(q, rotate(quat_conjugate(q), np.array([0.05, 0.0, 1.0]))) is None


def test_the_row_is_that_of_the_model():
    """Where the state is off by a little, the innovation is off by the row times it: no move when the state is true."""
    setup, azimuth = with_compass(), 0.4
    q = quat_from_rotvec([0.1, -0.2, 0.9])
    length, error = setup.horizontal_earth_rate, 0.03
    bearing_true = azimuth + DECLINATION + error
    field = rotate(quat_conjugate(q), np.array([np.cos(bearing_true), np.sin(bearing_true), 1.7]))
    x = np.r_[np.zeros(8), length * np.cos(azimuth), length * np.sin(azimuth), error]
    belief = start(setup, Wind(0.0, 4.0), q, np.zeros(2))
    core = replace(belief.core, x=x, north=azimuth + 0.2, steepness=1.7)
    P = np.diag(np.r_[[1e-10] * 2, 1e-4, [1e-8] * 8, [1e-12] * 2, 1e-4, [0.0] * 2])
    belief = with_wind(core, P[:14, :14], belief.wind)
    same = take_bearing(belief, setup, field)
    np.testing.assert_allclose(same.core.x, x, atol=1e-9)
    assert same.P[2, 2] < belief.P[2, 2]
    for j, step in ((2, 1e-3), (0, 1e-3), (COMPASS, 1e-3), (RATE, 1e-3 * length), (RATE + 1, 1e-3 * length)):
        e = np.zeros(16)
        e[j] = step
        moved = replace(core, q=quat_multiply(quat_from_rotvec(e[:3]), q), x=x + e[3:14])
        # A state that is known but for one direction is brought back along it.
        P = np.diag(np.r_[[1e-16] * 11, [1e-22] * 2, 1e-16, [0.0] * 2])
        P[j, j] = (10 * step) ** 2
        tight = replace(setup, compass_sd=1e-4 * DEG)
        after = take_bearing(with_wind(moved, P[:14, :14], belief.wind), tight, field)
        back = np.r_[2 * quat_multiply(after.core.q, quat_conjugate(q))[1:], after.core.x - x]
        assert abs(back[j]) < 0.03 * step


@pytest.mark.parametrize("wind", [Wind(0.5, 4.0), Wind(0.1, 2.0, (0.7, 1.9), (0.1, 0.05))])
def test_one_filter_compiled_equals_numpy(wind):
    case = make_case(with_compass(), 6, 8.0, "gusts")
    field = field_of(case, 6)[0]
    field[[3, 40]], field[50] = nan, -field[50]
    rows = reading_rows(case.increments, case.reference, field)
    belief, said = start(case.setup, wind, case.q_nb[0], np.zeros(2)), []
    for row in rows:
        moved = update(predict(belief, case.setup, row), case.setup, row[VELOCITY])
        belief = take_bearing(moved, case.setup, row[FIELD])
        said.append(answer(belief, case.setup).row)
    answers, _, state, P = one_filter(case, wind, field=field)
    np.testing.assert_allclose(answers, said, rtol=1e-6, atol=1e-9)
    n = len(belief.P)
    np.testing.assert_allclose(P[: n * n].reshape(n, n), belief.P, rtol=1e-7, atol=1e-14)
    np.testing.assert_allclose(state[: n + 1], np.concatenate([belief.core.q, belief.core.x, belief.d]), atol=1e-9)


@pytest.mark.parametrize(("grade", "period", "seconds"), [("mems", 0.1, 13.0), ("coarse", 0.5, 70.5)])
def test_whole_compiled_equals_numpy(grade, period, seconds):
    case = make_case(with_compass(grade, period=period), 7, seconds, "lines")
    field = field_of(case, 7)[0]
    field[1], field[20:25] = -field[1], nan
    compiled, numpy = run(case, field), run(case, field, backend="numpy")
    for name in ("q_nb", "tilt_cov", "heading", "heading_sd", "gyro_bias", "compass_bias", "compass_bias_sd"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(numpy, name), rtol=1e-5, atol=1e-7, err_msg=name)
    np.testing.assert_array_equal(compiled.heading_observable, numpy.heading_observable)


@pytest.mark.parametrize(
    ("grade", "wind"), [("mems", "lines"), ("mems", "markov"), ("fine", "lines"), ("fine", "none")]
)
def test_heading_tilt_and_compass_are_as_good_as_they_say(grade, wind):
    runs = 30
    tilt, heading, compass, seen, heading_sd, _ = nees(with_compass(grade), wind, 45.0, runs)
    assert in_band(tilt, 2, runs) and in_band(heading, 1, runs) and in_band(compass, 1, runs)
    assert seen == 1.0
    assert heading_sd < 2.2 * DEG


def test_gyros_that_find_north_find_the_error_of_the_compass_and_others_do_not():
    """However many readings: a constant error seen by nothing else stays as unknown as it was."""
    wide = {"compass_bias_sd": 12 * DEG}
    *_, fine = nees(with_compass("fine", **wide), "none", 60.0, 6)
    *_, heading_sd, coarse = nees(with_compass("coarse", **wide), "none", 60.0, 6)
    assert fine < 2.0 * DEG
    assert heading_sd > 11 * DEG and coarse > 11 * DEG


def test_a_precise_compass_does_not_level():
    """A tilt not known yet moves the bearing by more than the noise, in second order too."""
    runs = 16
    tilt, heading, *_ = nees(with_compass("fine", compass_sd=0.1 * DEG), "markov", 30.0, runs)
    assert in_band(tilt, 2, runs) and in_band(heading, 1, runs)


def spikes(field, rng):
    hit = rng.random(len(field)) < 0.2
    field[hit] = 50 * MICRO_TESLA * rng.standard_normal((hit.sum(), 3))
    return field


def passing_iron(field, rng):
    field[200:280] += np.array([40, 40, 0]) * MICRO_TESLA
    return field


def wrong_start(field, rng):
    field[:8] *= -1
    return field


def late(field, rng):
    field[:200] = nan
    return field


@pytest.mark.parametrize("spoil", [spikes, passing_iron, wrong_start, late])
def test_a_disturbed_field_is_told_from_a_heading(spoil):
    runs = 16
    tilt, heading, _, seen, heading_sd, _ = nees(with_compass("mems"), "lines", 40.0, runs, spoil)
    assert in_band(tilt, 2, runs) and in_band(heading, 1, runs)
    assert seen == 1.0 and heading_sd < 2.5 * DEG


def test_near_a_pole_of_the_field_and_in_single_precision():
    """At 80 degrees of dip a tilt moves the bearing nearly six times as far."""
    case = make_case(with_compass("fine", latitude=80 * DEG), 3, 40.0, "none")
    field, _ = field_of(case, 3, dip=80 * DEG)
    double, single = run(case, field), run(case, field, backend="compiled-float")
    assert abs(heading_error(double, case)) < 3 * double.heading_sd[-1] < 8 * DEG
    assert abs(wrap_angle(single.heading[-1] - double.heading[-1])) < 0.1 * double.heading_sd[-1]
    np.testing.assert_allclose(single.heading_sd[100:], double.heading_sd[100:], rtol=0.1)


def test_without_field_the_heading_drifts_and_says_so():
    case = make_case(with_compass("mems"), 5, 60.0, "none")
    field, _ = field_of(case, 5)
    field[25:] = nan
    said = run(case, field)
    assert said.heading_observable[24] and said.heading_sd[24] < 4 * DEG
    assert (np.diff(said.heading_sd[130:200]) > 0).all()
    assert said.heading_sd[-1] > 3 * said.heading_sd[24]
    assert abs(heading_error(said, case)) < 3 * said.heading_sd[-1]


def test_a_compass_that_says_nothing_changes_nothing():
    case = make_case(with_compass(), 4, 30.0, "lines")
    bare = align(case.increments, case.reference, case.t, case.setup.without_compass())
    unused, silent = run(case, None), run(case, np.full((300, 3), nan))
    np.testing.assert_array_equal(unused.q_nb, bare.q_nb)
    for without in (bare, unused):
        assert np.isnan(without.compass_bias).all() and np.isnan(without.compass_bias_sd).all()
    np.testing.assert_allclose(silent.q_nb, bare.q_nb, atol=1e-9)
    np.testing.assert_allclose(silent.compass_bias_sd[20:], 2 * DEG, rtol=1e-6)
    assert not silent.heading_observable.any()


def test_any_unit_and_any_declination():
    case = make_case(with_compass(), 4, 20.0, "lines")
    field, _ = field_of(case, 4)
    said, other = run(case, field), run(case, 1e9 * field)
    np.testing.assert_allclose(other.heading, said.heading, atol=1e-9)
    west = replace(case, setup=replace(case.setup, declination=DECLINATION - 0.5))
    # The gyros have little say here: the heading goes with the declination.
    off = wrap_angle(run(west, field).heading - said.heading + 0.5)
    assert abs(off[-1]) < 1 * DEG


def test_odd_fields_of_the_start_are_left_out():
    case = make_case(with_compass(), 8, 2.0, "none")
    field, _ = field_of(case, 8)
    field[[2, 5]], field[9], field[11] = -field[[2, 5]], nan, rotate(quat_from_rotvec([0, 0, 1.0]), field[11])
    fair = fair_fields(reading_rows(case.increments, case.reference, field), case.setup, case.q_nb[0])
    assert np.flatnonzero(~fair).tolist() == [2, 5, 9, 11]


def test_bad_input_is_refused():
    case = make_case(with_compass(), 1, 1.0, "none")
    field, _ = field_of(case, 1)
    with pytest.raises(InputError, match="magnetic field"):
        run(case, field[:4])
    for bad in (np.inf, 0.0):
        with pytest.raises(InputError, match="row 3"):
            run(case, np.where(np.arange(10)[:, None] == 3, bad, field))
    with pytest.raises(InputError, match="without a compass"):
        run(replace(case, setup=case.setup.without_compass()), field)
    with pytest.raises(InputError, match="all three"):
        replace(case.setup, compass_sd=None)
    with pytest.raises(InputError, match="45 degrees"):
        replace(case.setup, compass_bias_sd=pi / 4)
    with pytest.raises(InputError, match="compass_sd"):
        replace(case.setup, compass_sd=0.0)
