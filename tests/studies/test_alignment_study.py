"""The alignment study on few seeds: its metrics by hand, what it must show, and the shape of what it writes."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

from robustnav.alignment.setting import Wind
from robustnav.cli import main
from robustnav.errors import InputError
from robustnav.evaluate.consistency import chi_square_band
from robustnav.frames import matrix_from_quat, quat_from_euler, quat_from_rotvec, quat_multiply
from robustnav.sim.alignment import simulate_alignment
from robustnav.sim.alignment_scenario import SensorErrors
from robustnav.studies import alignment_runs
from robustnav.studies.alignment import AlignmentStudy, Selection, alignment_study, rows_of
from robustnav.studies.alignment_bounds import fixed_winds, floor, one_wind, told
from robustnav.studies.alignment_errors import additive_covariance, heading_error, tilt_error
from robustnav.studies.alignment_figures import tilt_after
from robustnav.studies.alignment_goals import best_fixed, goals
from robustnav.studies.alignment_report import bound_rows, goal_rows, results, wind_rows, write_study
from robustnav.studies.alignment_runs import Work, run_work
from robustnav.studies.alignment_setting import BOUNDS, METHODS, OURS, Case, all_cases, estimators, start_of, stations
from robustnav.units import ARCMIN, DEG

SEEDS = 4
START = "10-10-60"
CASES = (f"s-{START}", f"s-{START}-printed", f"h-{START}", "h-30-30-170", f"h-{START}-changing", f"h-{START}-75deg")


def test_tilt_is_about_the_estimates_axes_and_free_of_heading():
    rng = np.random.default_rng(1)
    q = quat_from_euler(rng.uniform(-1, 1, (50, 3)))
    turn = np.column_stack([1e-3 * rng.normal(size=(50, 2)), np.zeros(50)])
    true = quat_multiply(quat_from_rotvec(turn), q)
    np.testing.assert_allclose(tilt_error(true, q), turn[:, :2], atol=1e-12)
    yaw = quat_from_rotvec(np.outer(rng.uniform(-3, 3, 50), [0, 0, 1]))
    np.testing.assert_allclose(tilt_error(quat_multiply(yaw, true), q), turn[:, :2], atol=1e-12)
    big = quat_multiply(quat_from_rotvec([0.0, 2.0, 0.0]), q)
    np.testing.assert_allclose(np.linalg.norm(tilt_error(big, q), axis=1), 2.0)


def test_heading_error_is_that_of_the_forward_axis():
    a, b = quat_from_euler([0.1, 0.7, 3.0]), quat_from_euler([-0.2, 0.5, -3.0])
    assert heading_error(a, b) == pytest.approx(6.0 - 2 * np.pi)


def test_covariance_of_an_additive_quaternion_by_draws():
    rng = np.random.default_rng(2)
    Q = 1.1 * quat_from_rotvec([0.4, -1.0, 0.6])
    A = 1e-3 * rng.normal(size=(4, 4))
    P = A @ A.T
    draws = Q + rng.multivariate_normal(np.zeros(4), P, 40000)
    unit = draws / np.linalg.norm(draws, axis=1, keepdims=True)
    C = matrix_from_quat(Q / 1.1)
    turn = matrix_from_quat(unit) @ C.T
    theta = np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]]) / 2
    found = additive_covariance(Q, P)
    np.testing.assert_allclose(found, np.cov(theta), atol=0.03 * np.abs(found).max())


def test_the_start_covers_the_misalignment():
    """The quaternion's own distance from the truth, in the covariance the filters start with."""
    case = Case("s-10-10-60", "none")
    scenario = case.load()
    one = simulate_alignment(scenario, 3)
    start = start_of(one, estimators(scenario)["hinf"])
    assert np.linalg.eigvalsh(start.P).min() > 0
    theta = np.sqrt(np.diag(additive_covariance(one.q_nb_start, start.P[3:7, 3:7])))
    # sin(angle / 2) saturates: of 60 degrees a little less is left
    assert (theta[:2] > 7 * DEG).all() and (theta[:2] < 12 * DEG).all() and 40 * DEG < theta[2] < 60 * DEG


@pytest.fixture(scope="module")
def counted():
    """The invariant filters, half of the time, on the gyros that the published claim is about."""
    calls = []
    chosen = [Selection(CASES[:2]), Selection(CASES[2:], ("ukf", "hinf", OURS, *BOUNDS))]
    ran = [alignment_study(SEEDS, progress=lambda: calls.append(1), selection=one) for one in chosen]
    cases, examples = ({k: v for one in ran for k, v in getattr(one, part).items()} for part in ("cases", "examples"))
    return AlignmentStudy(SEEDS, 0, cases, examples), len(calls), sum(one.steps(SEEDS) for one in chosen)


@pytest.fixture(scope="module")
def study(counted):
    return counted[0]


def test_progress_is_called_as_often_as_announced(counted):
    assert counted[1] == counted[2] == SEEDS * len(CASES)


def test_cases_stand_together_where_their_inertial_data_are_the_same():
    cases = all_cases()
    assert len({case.name for case in cases}) == len(cases)
    groups = stations(cases)
    assert sorted(case.name for group in groups for case in group) == sorted(case.name for case in cases)
    for group in groups:
        units = [case.load() for case in group]
        assert len({(one.gyro, one.accel, one.latitude, one.sway) for one in units}) == 1
    assert Case("h-10-10-60", latitude_deg=75.0).load().latitude == 75 * DEG


def test_the_published_claim_and_its_cause(study):
    for name in CASES[:2]:
        figures = study.cases[name].figures
        assert figures["hinf"]["settle_s"]["median"] < 50
        assert not figures["ukf"]["settle_s"]["median"] < 50
        same = figures["ukf-r1"]["tilt_arcmin"]["median"]
        assert figures["hinf"]["tilt_arcmin"]["median"] == pytest.approx(same, abs=0.3)
        assert figures["ukf"]["tilt_arcmin"]["median"] > 2 * same
        assert figures["hinf"]["no_filter_steps"] == 0 and figures["hinf"]["least_margin"] > 0.5
    assert all(g.met for g in goals(study) if "hinf" in g.name or "ukf" in g.name)


def test_ours_needs_no_start_and_finds_heading_with_fine_gyros(study):
    near, far = (study.cases[f"h-{start}"].figures[OURS] for start in (START, "30-30-170"))
    assert near == far
    assert far["tilt_arcmin"]["p95"] < 1.5 and far["heading_deg"]["p95"] < 1.0
    assert far["heading_known_runs"] == SEEDS and far["heading_latest_known_s"] < 45
    assert study.cases["h-30-30-170"].figures["hinf"]["tilt_arcmin"]["median"] > 10
    coarse = study.cases[f"s-{START}"].figures[OURS]
    assert coarse["heading_known_runs"] == coarse["heading_ever_known"] == 0


def test_who_knows_the_wind_is_hardly_better(study):
    for name in (f"s-{START}", f"h-{START}"):
        figures = study.cases[name].figures
        ours, told_it, least = (figures[one]["tilt_arcmin"]["median"] for one in (OURS, "told", "floor"))
        assert told_it == pytest.approx(ours, rel=0.1) and 0.3 * ours < least < 1.1 * ours
    cells = bound_rows(study)[0]
    ratio = float(cells["align over told"].split(" / ")[0])
    figures = study.cases[CASES[0]].figures
    assert ratio == pytest.approx(
        figures[OURS]["tilt_arcmin"]["median"] / figures["told"]["tilt_arcmin"]["median"], abs=0.01
    )


@pytest.mark.parametrize("seed", range(2))
def test_the_floor_is_what_constant_biases_leave_without_any_noise(seed):
    """Where nothing errs but a bias, an estimator that knows the wind ends on the floor."""
    case, quiet = Case(f"h-{START}", "none").load(), SensorErrors(0.0, 0.0, 0.0, 1.0)
    level = {"accel": replace(case.accel, white_sd=0.0, markov_sd=0.0), "gyro": quiet}
    turned = {"accel": quiet, "gyro": SensorErrors(5e-8, 0.0, 0.0, 1.0)}
    ends = []
    for errors in (level, turned):
        run = simulate_alignment(replace(case, velocity_sd=1e-4, **errors), seed)
        data = replace(run, scenario=case)  # what it is told of its sensors is not zero
        ends.append((floor(data), told(data)))
    (least, best), (least_turned, best_turned) = ends
    size = [np.linalg.norm(one.tilt[-1]) for one in (least, best)]  # told has level axes of its own
    assert size[0] == pytest.approx(size[1], rel=0.02) and size[0] > 0.2 * ARCMIN
    assert best_turned.heading[-1] == pytest.approx(least_turned.heading[-1], rel=0.05)
    assert abs(least_turned.heading[-1]) > 0.01 * DEG and not least.known.any()


def test_single_winds_are_those_of_the_bank_and_the_true_lines():
    start, back = (simulate_alignment(Case(f"s-{START}", wind).load(), 1) for wind in ("markov", "changing-back"))
    near, late = fixed_winds(start), fixed_winds(back)
    assert near["0.5 m/s, 4 s"] < 0.2 * near["0 m/s, 4 s"]
    assert set(late) == {*near, "known lines"} and late["0.5 m/s, 4 s"] < 0.2 * late["known lines"]
    reference, lines = back.velocity.values[:, :2], Wind(0.0, 4.0, (2.0, 1.0, 0.5), (0.0,) * 3)
    assert late["known lines"] == tilt_after(back.truth.t - 100.0, one_wind(back, reference, lines).tilt)


def test_tilt_after_a_change_is_that_of_the_stretch():
    since = np.arange(-50.0, 100.0)
    tilt = np.zeros((150, 2))
    tilt[(since >= 20) & (since <= 50)] = [3 * ARCMIN, 4 * ARCMIN]
    assert tilt_after(since, tilt) == pytest.approx(5.0)


def test_goals_are_the_figures_between_their_limits(study):
    found = {goal.name: goal for goal in goals(study)}
    figures = study.cases[f"h-{START}"].figures[OURS]
    tail = found[f"h-{START}, align, tilt, arcmin, 95 %"]
    assert (tail.value, tail.high) == (figures["tilt_arcmin"]["p95"], 1.1)
    assert tail.met == (tail.value <= 1.1)
    assert tail.told == study.cases[f"h-{START}"].figures["told"]["tilt_arcmin"]["p95"]
    honest = found[f"h-{START}-75deg, align, NEES of heading"]
    assert (honest.low, honest.high) == chi_square_band(1, SEEDS)
    assert honest.value == study.cases[f"h-{START}-75deg"].figures[OURS]["heading_nees"]
    name, tilt = best_fixed(study, f"h-{START}-changing", "median")
    fixed = study.cases[f"h-{START}-changing"].fixed
    assert tilt == min(one["median"] for one in fixed.values()) == fixed[name]["median"]
    ratio = study.cases[f"h-{START}-changing"].figures[OURS]["after_arcmin"]["median"] / tilt
    assert found[f"h-{START}-changing, align over the best fixed wind, median"].value == pytest.approx(ratio)
    assert f"s-{START}, align, NEES of heading" not in found and not any("gusts" in one for one in found)


def test_a_seed_gives_the_same_whatever_is_run_beside_it(study):
    case = Case(f"s-{START}")
    alone = run_work([Work([case], frozenset(case.methods))], [0], lambda: None)[0][0].example
    beside = study.examples[case.name]
    for method in case.methods:
        np.testing.assert_allclose(alone.followed[method].tilt, beside.followed[method].tilt, atol=1e-3 * ARCMIN)


def test_runs_keep_their_order_over_parts(monkeypatch):
    """More seeds than one worker takes at a time."""
    monkeypatch.setattr(alignment_runs, "CHUNK", 2)
    work = [Work([Case(f"s-{START}", "none")], frozenset(["floor"]))]
    whole, last = (run_work(work, seeds, lambda: None)[0][0].runs["floor"] for seeds in (range(5), [4]))
    assert len(whole.figures["tilt_arcmin"]) == 5
    np.testing.assert_array_equal(whole.size[-1:], last.size)


def test_it_writes_strict_json_and_a_page(study, tmp_path):
    page = write_study(study, tmp_path / "out", "robustnav demo alignment")
    text = (tmp_path / "out" / "results.json").read_text()
    read = json.loads(text, parse_constant=lambda name: pytest.fail(name))
    assert read["study"] == "alignment" and read["seeds"] == SEEDS
    assert set(read["scenarios"]) == set(study.cases) == set(CASES)
    for name, methods in read["scenarios"].items():
        rivals = set(METHODS) if name in CASES[:2] else {"ukf", "hinf"} if name in CASES[2:4] else set()
        assert set(methods) == {OURS, *BOUNDS} | rivals
        for method in set(methods) - set(BOUNDS):
            assert {"tilt_arcmin", "settle_s", "heading_deg", "nees"} <= set(methods[method])
            assert set(methods[method]["settle_s"]) == {"median", "p95"}
    html = page.read_text()
    assert "existence" in html.lower() and html.count("<figure>") == 10 and "never" in html
    assert len(goal_rows(study)) == len(results(study)["goals"]) == len(goals(study)) > 20
    assert len(rows_of(study.cases["s-10-10-60"].figures)) == len(METHODS) + len(BOUNDS)
    assert [row["case"] for row in wind_rows(study)] == [f"h-{START}-changing"]


def test_a_selection_runs_and_shows_no_more(tmp_path):
    study = alignment_study(SEEDS, selection=Selection((f"s-{START}-none",), ("ukf-r1",)))
    assert list(study.cases) == [f"s-{START}-none"] and list(study.cases[f"s-{START}-none"].figures) == ["ukf-r1"]
    assert goals(study) == [] and wind_rows(study) == bound_rows(study) == []
    ours = alignment_study(SEEDS, selection=Selection((f"s-{START}-none",), (OURS,)))
    assert bound_rows(ours) == [] and len(goals(ours)) == 1
    html = write_study(study, tmp_path, "x").read_text()
    assert "ukf-r1" in html and "hinf" not in html and "<figure>" not in html
    assert Selection((), ("hinf",)).steps(1) == 18


def test_the_command_runs_a_selection_and_says_how_to_repeat_it(tmp_path, capsys):
    chosen = ["--only", "align", "--only", "floor", "--case", f"h-{START}-none", "--seeds", str(SEEDS)]
    assert main(["demo", "alignment", *chosen, "--out", str(tmp_path), "--json"]) == 0
    told = capsys.readouterr()
    shown = json.loads(told.out)
    assert list(shown["scenarios"]) == [f"h-{START}-none"] and shown == json.loads(
        (tmp_path / "results.json").read_text()
    )
    assert " s, peak memory" in told.err or sys.platform == "win32"
    assert f"--only align --only floor --case h-{START}-none" in (tmp_path / "report.html").read_text()
    assert main(["demo", "alignment", "--case", "h-10", "--out", str(tmp_path / "x")]) == 2
    assert not (tmp_path / "x").exists() and f"h-{START}" in capsys.readouterr().err


def test_bad_numbers_names_and_a_file_in_the_way_are_named(study, tmp_path):
    with pytest.raises(InputError, match="seeds"):
        alignment_study(2)
    with pytest.raises(InputError, match="seed"):
        alignment_study(4, -1)
    with pytest.raises(InputError, match="unknown case 's-1-2-3'"):
        Selection(("s-1-2-3",))
    with pytest.raises(InputError, match="unknown method 'ekf'"):
        Selection((), ("ekf",))
    with pytest.raises(InputError, match="no case"):
        alignment_study(4, selection=Selection((f"s-{START}-0deg",), ("ukf",)))
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="output folder"):
        write_study(study, tmp_path / "file", "x")
