"""Scenarios of an initial alignment: their files, and the statistics of what is simulated from them."""

import contextlib
from dataclasses import replace
from importlib.resources import files
from itertools import count, islice
from math import exp, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.engine import strapdown as compiled
from robustnav.errors import InputError
from robustnav.frames import rotation_error
from robustnav.sim.alignment import (
    in_other_wind,
    load_scenario,
    scenario_names,
    simulate_alignment,
    simulate_alignments,
    simulate_unit,
    wind_names,
)
from robustnav.sim.alignment_scenario import SensorErrors
from robustnav.sim.sway import Sway, Swing
from robustnav.sim.wind import Gusts, Line, Markov, WindPart, gauss_markov, wind
from robustnav.strapdown import carry, preintegrate
from robustnav.units import DEG, DEG_PER_HOUR, DPS, MILLI_G

QUIET = SensorErrors(0.0, 0.0, 0.0, 1.0)


def within(value, expected, n, sigmas=4.5):
    """Whether a variance of n normal numbers lies where it should."""
    return abs(value / expected - 1) < sigmas * np.sqrt(2 / n)


# ---- files -----------------------------------------------------------------------------------------------------------


def test_every_scenario_loads_in_every_wind():
    assert scenario_names() == ("s-10-10-60", "s-30-30-170", "h-10-10-60", "h-30-30-170")
    steady = ("printed", "lines", "gusts", "markov", "markov-strong", "lines-markov", "none")
    assert wind_names() == (*steady, "changing", "changing-mean", "changing-back")
    for name in scenario_names():
        for blowing in wind_names():
            scenario = load_scenario(name, blowing)
            unit = DPS if name[0] == "s" else DEG_PER_HOUR
            assert scenario.name == f"{name}, wind {blowing}"
            assert scenario.gyro == SensorErrors(0.01 * unit, 0.01 * unit, 0.01 * unit, 3600.0)
            assert scenario.accel == SensorErrors(*[0.1 * MILLI_G] * 3, 1800.0)
            np.testing.assert_allclose(np.array(scenario.misalignment) / DEG, [float(a) for a in name.split("-")[1:]])
            assert (scenario.every, scenario.intervals) == (100, 2000)
    assert load_scenario("s-10-10-60") == load_scenario("s-10-10-60", "lines")


def whole_file():
    """Text of a user's own file: the built-in h-10-10-60 in one piece."""
    text = files("robustnav.sim").joinpath("alignment.toml").read_text(encoding="utf-8")
    common = text[text.index("\n[common]") + len("\n[common]") : text.index("# The unit of the gyro")]
    return (
        "misalignment_deg = [10.0, 10.0, 60.0]\n"
        "gyro_dph = { bias = 0.01, white_sd = 0.01, markov_sd = 0.01, markov_time_s = 3600.0 }\n"
        + common.replace("[common.", "[")
        + '[[wind]]\nmean_ned_mps = [2.7, 2.0, 0.0]\nlines = "published"\nrandom_phases = true\n'
    )


def test_a_file_of_one_s_own(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(whole_file())
    assert load_scenario(file) == replace(load_scenario("h-10-10-60"), name="mine")
    assert load_scenario(str(file), "none").wind == load_scenario("h-10-10-60", "none").wind


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("duration_s", "duration", "2 mistakes"),
        ("bias = 0.1 ", "bias = -0.1 ", "accel_mg.bias"),
        ("latitude_deg = 32.03", "latitude_deg = 91.0", "latitude_deg"),
        ("latitude_deg = 32.03", "latitude_deg = nan", "latitude_deg"),
        ("markov_time_s = 1800.0", "markov_time_s = 0.0", "markov_time_s"),
        ("gyro_dph", "gyro_dpm", "gyro_dpm"),
        ("[10.0, 10.0, 60.0]", "[10.0, 10.0]", "misalignment_deg"),
        ('"published"', '"unpublished"', "lines of a wind"),
        ('"published"', "7", "wind.0.lines"),
        ("[[wind]]", "[[wind]]\nstart_s = 5.0", "start_s"),
        ("[[wind]]", "[wind]", "wind"),
        ("mean_ned_mps", "mean_enu_mps", "mean_enu_mps"),
        ("duration_s = 200.0", "duration_s = 200.05", "filter intervals"),
        ("imu_rate_hz = 1000.0", "imu_rate_hz = 1005.0", "samples an interval"),
        ("[[wind]]", "[[wind]", "not TOML"),
    ],
)
def test_what_a_file_must_not_say(tmp_path, old, new, match):
    text = whole_file()
    assert old in text
    file = tmp_path / "mine.toml"
    file.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=match):
        load_scenario(file)


def test_two_gyros_or_none_are_refused(tmp_path):
    file = tmp_path / "mine.toml"
    line = "gyro_dps = { bias = 0.01, white_sd = 0.01, markov_sd = 0.01, markov_time_s = 3600.0 }\n"
    for text in (line + whole_file(), whole_file().replace("gyro_dph", "#")):
        file.write_text(text)
        with pytest.raises(InputError, match="one of gyro_dps and gyro_dph"):
            load_scenario(file)


def test_unknown_names_are_listed(tmp_path):
    for call in (lambda: load_scenario("s-1-2-3"), lambda: load_scenario("s-10-10-60", "storm")):
        with pytest.raises(InputError, match="one of"):
            call()
    with pytest.raises(InputError, match="cannot be read"):
        load_scenario(tmp_path / "absent.toml")


@settings(max_examples=100)
@given(at=st.integers(0, 10_000), junk=st.text(max_size=4), cut=st.integers(0, 30))
def test_a_damaged_file_is_refused_or_whole(tmp_path_factory, at, junk, cut):
    text = whole_file()
    at %= len(text)
    file = tmp_path_factory.getbasetemp() / "damaged.toml"
    file.write_text(text[:at] + junk + text[at + cut :], encoding="utf-8")
    with contextlib.suppress(InputError):
        load_scenario(file)


def test_only_the_wind_and_the_start_can_be_others():
    first = simulate_alignment(short(duration=0.1), 5)
    near = in_other_wind(first, short("s-10-10-60", duration=0.1))
    np.testing.assert_array_equal(near.q_nb_start, simulate_alignment(near.scenario, 5).q_nb_start)
    for other in (short("h-30-30-170", duration=0.1), short(duration=0.1, latitude=0.1), short(duration=0.2)):
        with pytest.raises(InputError, match="other wind"):
            in_other_wind(first, other)


# ---- one run ---------------------------------------------------------------------------------------------------------


def short(name="s-30-30-170", blowing=None, **changes):
    return replace(load_scenario(name, blowing), **({"duration": 10.0} | changes))


def test_without_errors_the_increments_lead_along_the_truth():
    scenario = short(gyro=QUIET, accel=QUIET, velocity_sd=0.0, latitude=radians(60), duration=20.0)
    data = simulate_alignment(scenario, 3)
    q, v = carry(data.truth.q_nb[0], np.zeros(3), data.increments, scenario.place)
    assert np.linalg.norm(rotation_error(q, data.truth.q_nb), axis=1).max() < 1e-9
    assert np.abs(v).max() < 2e-7
    np.testing.assert_array_equal(data.velocity.values, data.wind_n)
    assert len(data.increments) == len(data.velocity) == len(data.truth.t) - 1 == 200
    np.testing.assert_array_equal(data.velocity.t, data.truth.t[1:])


def test_compiled_increments_are_the_same():
    scenario = short()
    one, other = simulate_alignment(scenario, 4), simulate_alignment(scenario, 4, compiled.preintegrate)
    np.testing.assert_allclose(one.increments.rows, other.increments.rows, atol=1e-13)


def test_a_seed_is_a_run_and_a_wind_changes_nothing_else():
    first, again = (simulate_alignment(short(), 5) for _ in range(2))
    other = simulate_alignment(short(blowing="markov"), 5)
    np.testing.assert_array_equal(first.velocity.values, again.velocity.values)
    np.testing.assert_array_equal(first.increments.rows, other.increments.rows)
    np.testing.assert_array_equal(first.q_nb_start, other.q_nb_start)
    assert (first.wind_n != other.wind_n).all(axis=1).sum() == 0  # down is calm in both
    assert (first.wind_n[:, :2] != other.wind_n[:, :2]).all()
    np.testing.assert_allclose(first.velocity.values - first.wind_n, other.velocity.values - other.wind_n, atol=1e-14)
    moved = in_other_wind(first, replace(other.scenario, velocity_sd=0.02))
    again = simulate_alignment(moved.scenario, 5)
    assert moved.increments is first.increments
    np.testing.assert_array_equal(moved.velocity.values, again.velocity.values)
    np.testing.assert_array_equal(moved.wind_n, again.wind_n)
    np.testing.assert_array_equal(moved.q_nb_start, again.q_nb_start)
    runs = simulate_alignments(short(duration=0.1), count())  # endless, so nothing is made ahead
    assert [run.seed for run in islice(runs, 3)] == [0, 1, 2]
    with pytest.raises(InputError, match="seed"):
        simulate_alignment(short(), -1)


def test_start_and_heading_are_spread():
    runs = [simulate_alignment(short(duration=0.1), seed, compiled.preintegrate) for seed in range(120)]
    off = np.array([rotation_error(run.q_nb_start, run.truth.q_nb[0]) for run in runs])
    np.testing.assert_allclose(np.abs(off) / DEG, np.tile([30.0, 30.0, 170.0], (120, 1)), atol=1e-9)
    assert len({tuple(row) for row in np.sign(off).astype(int)}) == 8
    headings = np.array([simulate_unit(short(duration=0.1), seed).heading for seed in range(120)])
    assert np.histogram(headings, 4, (0, 2 * pi))[0].min() > 13
    fixed = simulate_unit(short(duration=0.1, heading=1.0), 3)
    assert fixed.heading == 1.0


# ---- statistics ------------------------------------------------------------------------------------------------------

STILL = Sway(Swing(), Swing())


def test_white_noise_enters_an_interval_as_it_should():
    """Variance of a period: (sd Ts)^2 for each of its samples; biases known from the truth come off."""
    scenario = short("s-10-10-60", duration=50.0)
    data = simulate_alignment(scenario, 6, compiled.preintegrate)
    clean = simulate_alignment(replace(scenario, gyro=QUIET, accel=QUIET), 6, compiled.preintegrate)
    rotation, velocity = data.increments.corrected(data.gyro_bias[:-1], data.accel_bias[:-1])
    turned = rotation_error(rotation, clean.increments.rotation)
    n, per_sample = turned.size, 1e-3 * np.sqrt(100)
    assert within(turned.var(), (scenario.gyro.white_sd * per_sample) ** 2, n)
    # a turn of the axes during the interval, seen against gravity, adds a third of (g T)^2 times its variance
    leaning = turned.var() * (9.8 * 0.1) ** 2 / 3 * 2 / 3
    assert within(
        (velocity - clean.increments.velocity).var(), (scenario.accel.white_sd * per_sample) ** 2 + leaning, n
    )
    assert abs(turned.mean()) < 4.5 * turned.std() / np.sqrt(n)


def test_every_error_has_draws_of_its_own():
    white = SensorErrors(1.0, 1.0, 1.0, 100.0)
    unit = simulate_unit(short(sway=STILL, gyro=white, accel=white, latitude=0.0), 2)
    noise = np.hstack([unit.samples.angle, unit.samples.velocity])
    off_diagonal = np.corrcoef(noise - noise.mean(axis=0), rowvar=False)[~np.eye(6, dtype=bool)]
    assert np.abs(off_diagonal).max() < 5 / np.sqrt(len(noise))
    runs = [simulate_alignment(short(duration=0.1, gyro=white), k, compiled.preintegrate) for k in range(120)]
    start = [np.sign(rotation_error(run.q_nb_start, run.truth.q_nb[0])) for run in runs]
    rows = np.hstack([start, [run.gyro_bias[0] for run in runs], [run.velocity.values[0] for run in runs]])
    assert np.abs(np.corrcoef(rows, rowvar=False)[:3, 3:]).max() < 4.5 / np.sqrt(len(runs))


def test_constant_biases_have_their_size_and_either_sign():
    constant = SensorErrors(2.0, 0.0, 0.0, 100.0)
    units = [simulate_unit(short(sway=STILL, duration=0.1, gyro=constant, accel=constant), k) for k in range(60)]
    signs = np.array([np.r_[unit.gyro_bias[0], unit.accel_bias[0]] for unit in units])
    np.testing.assert_array_equal(np.abs(signs), 2.0)
    assert (np.abs(signs.mean(axis=0)) < 2 * 4 / np.sqrt(60)).all()
    for unit in units[:3]:
        np.testing.assert_allclose(unit.samples.angle.mean(axis=0) / 1e-3 - unit.gyro_bias[0], 0, atol=1e-4)


def test_markov_biases_are_stationary_from_the_start_and_in_the_samples():
    markov = SensorErrors(0.0, 0.0, 3.0, 2.0)
    scenario = short(sway=STILL, duration=4.0, gyro=markov, accel=QUIET, imu_rate_hz=100.0)
    units = [simulate_unit(scenario, seed) for seed in range(300)]
    bias = np.array([unit.gyro_bias for unit in units])
    for k in (0, 20, 40):
        assert within(bias[:, k].var(), 9.0, 900)
    correlation = (bias[:, 10] * bias[:, 30]).mean() / 9.0
    assert abs(correlation - exp(-2.0 / 2.0)) < 4.5 / np.sqrt(900)
    in_samples = units[0].samples.angle.reshape(40, 10, 3) / 0.01
    np.testing.assert_allclose(in_samples.mean(axis=1), bias[0][:-1], atol=1e-4)  # the rest is the Earth's rate


def test_gauss_markov_is_its_recursion():
    normal = np.random.default_rng(1).standard_normal((37, 2))
    x = [normal[0]]
    for row in normal[1:]:
        x.append(0.9 * x[-1] + np.sqrt(1 - 0.81) * row)
    np.testing.assert_allclose(gauss_markov(normal, 0.9), x, atol=1e-14)


def test_the_printed_wind_is_equation_13():
    t = np.arange(1, 2001) * 0.1
    found = wind(load_scenario("s-10-10-60", "printed").wind, t, np.random.default_rng(0))
    slow = 0.15 * np.sin(2 * t) + 0.2 * np.sin(t + 0.5)
    np.testing.assert_allclose(found[:, 0], 2.7 + slow + 0.3 * np.sin(0.5 * t), atol=1e-14)
    np.testing.assert_allclose(found[:, 1], 2.0 + slow + 0.5 * np.sin(0.5 * t), atol=1e-14)
    assert not found[:, 2].any()


def test_random_phases_differ_by_run_and_keep_the_power():
    parts, t = load_scenario("s-10-10-60").wind, np.arange(1, 2001) * 0.1
    one, other = (wind(parts, t, np.random.default_rng(seed)) for seed in (1, 2))
    assert np.abs(one - other)[:, :2].max() > 0.1
    for found in (one, other):
        np.testing.assert_allclose(found.var(axis=0)[:2], [0.0763, 0.1563], rtol=0.05)  # half the sum of squares


def test_gusts_are_as_frequent_and_as_strong_as_stated():
    t = np.arange(20_000) * 0.1
    part = WindPart(0.0, (1.0, 0.0, 0.0), gusts=Gusts((3.0, 2.0, 0.0), 0.05))
    found = wind((part,), t, np.random.default_rng(3)) - [1.0, 0, 0]
    struck = found[:, 0] != 0
    assert abs(struck.mean() - 0.05) < 4.5 * np.sqrt(0.05 * 0.95 / len(t))
    assert within(found[struck, 0].var(), 9.0, struck.sum()) and within(found[struck, 1].var(), 4.0, struck.sum())


def test_a_markov_wind_has_its_strength_and_memory():
    t = np.arange(100_000) * 0.1
    (part,) = load_scenario("s-10-10-60", "markov").wind
    assert part.markov == Markov((0.5, 0.5, 0.0), 4.0)
    found = wind((part,), t, np.random.default_rng(4))[:, :2] - part.mean_n[:2]
    independent = len(t) * 0.1 / 4.0  # times over which the sum of squares averages, two axes
    assert within(found.var(), 0.25, 2 * independent)
    correlation = (found[40:] * found[:-40]).mean() / 0.25
    assert abs(correlation - exp(-1)) < 4.5 / np.sqrt(2 * independent)


def test_a_wind_that_changes_changes_once():
    lines = WindPart(0.0, (1.0, 0.0, 0.0), lines=(Line(0.5, (0.2, 0.1, 0.0)),), random_phases=True)
    after = WindPart(5.0, (0.0, 0.0, 0.0))
    t = np.arange(100) * 0.1
    alone, changed = (wind(parts, t, np.random.default_rng(5)) for parts in ((lines,), (lines, after)))
    np.testing.assert_array_equal(changed[:50], alone[:50])
    assert not changed[50:].any()
    there, back = (load_scenario("s-10-10-60", name).wind for name in ("changing", "changing-back"))
    assert [part.start for part in there] == [part.start for part in back] == [0.0, 100.0]
    assert (there[0].lines, there[1].markov) == (back[1].lines, back[0].markov)


@pytest.mark.parametrize(
    "parts",
    [
        (),
        (WindPart(1.0, (0.0, 0.0, 0.0)),),
        (WindPart(0.0, (0.0, 0.0, 0.0)), WindPart(0.0, (0.0, 0.0, 0.0))),
        (WindPart(0.0, (0.0, 0.0, 0.0), markov=Markov((1.0, 1.0, 0.0), 0.0)),),
        (WindPart(0.0, (0.0, 0.0, 0.0), gusts=Gusts((1.0, 1.0, 0.0), 1.5)),),
    ],
)
def test_winds_that_make_no_sense_are_refused(parts):
    with pytest.raises(InputError, match="wind"):
        wind(parts, np.arange(3) * 0.1, np.random.default_rng(0))


def test_the_reference_has_its_white_noise():
    data = simulate_alignment(short(duration=100.0, sway=STILL, imu_rate_hz=100.0), 8)
    noise = data.velocity.values - data.wind_n
    assert within(noise.var(), 0.05**2, noise.size)
    assert data.velocity.frame == "n" and data.truth.north == "true"
    assert preintegrate(simulate_unit(short(duration=0.1), 1).samples, 100).dt == pytest.approx(0.1)
