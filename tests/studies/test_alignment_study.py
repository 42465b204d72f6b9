"""The alignment study on few seeds: its metrics by hand, what it must show, and the shape of what it writes."""

import json

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import matrix_from_quat, quat_from_euler, quat_from_rotvec, quat_multiply
from robustnav.sim.alignment import simulate_alignment
from robustnav.studies import alignment as study_module
from robustnav.studies.alignment import alignment_study, goals, results, rows_of, steps_of
from robustnav.studies.alignment_report import goal_rows, write_study
from robustnav.studies.alignment_runs import additive_covariance, heading_error, run_cases, tilt_error
from robustnav.studies.alignment_setting import METHODS, Case, estimators, groups, start_of
from robustnav.units import ARCMIN, DEG

SEEDS = 4


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
    """The cases that the goals are about."""
    calls = []
    with pytest.MonkeyPatch.context() as patch:
        kept = [(Case("s-10-10-60", "lines"),), (Case("s-10-10-60", "printed"),)]
        kept += [group for group in groups() if group[0].name == "h-10-10-60"]
        patch.setattr(study_module, "groups", lambda: kept)
        yield alignment_study(SEEDS, progress=lambda: calls.append(1)), len(calls), steps_of(SEEDS)


@pytest.fixture(scope="module")
def study(counted):
    return counted[0]


def test_progress_is_called_as_often_as_announced(counted):
    assert counted[1] == counted[2]


def test_the_published_claim_and_its_cause(study):
    for name in ("s-10-10-60", "s-10-10-60-printed"):
        figures = study.cases[name].figures
        assert figures["hinf"]["settle_s"]["median"] < 50
        assert not figures["ukf"]["settle_s"]["median"] < 50
        same = figures["ukf-r1"]["tilt_arcmin"]["median"]
        assert figures["hinf"]["tilt_arcmin"]["median"] == pytest.approx(same, abs=0.3)
        assert figures["ukf"]["tilt_arcmin"]["median"] > 2 * same
        assert figures["hinf"]["no_filter_steps"] == 0 and figures["hinf"]["least_margin"] > 0.5
    assert all(g.met for g in goals(study) if "hinf" in g.name or "ukf" in g.name)


def test_ours_needs_no_start_and_finds_heading_with_fine_gyros(study):
    near, far = (study.cases[f"h-{start}"].figures["align"] for start in ("10-10-60", "30-30-170"))
    assert near == far
    assert far["tilt_arcmin"]["p95"] < 1.5 and far["heading_deg"]["p95"] < 1.0
    assert study.cases["h-30-30-170"].figures["hinf"]["tilt_arcmin"]["median"] > 10


def test_a_seed_gives_the_same_whatever_is_run_beside_it(study):
    case = Case("s-10-10-60", "lines")
    alone = run_cases([case], [0], lambda: None)[0]
    beside = study.examples[case.name]
    for method in METHODS:
        a, b = alone.followed[method][0], beside.followed[method][0]
        np.testing.assert_allclose(a.tilt, b.tilt, atol=1e-3 * ARCMIN)
    np.testing.assert_allclose(alone.margins[0], beside.margins[0])


def test_it_writes_strict_json_and_a_page(study, tmp_path):
    page = write_study(study, tmp_path / "out", "robustnav demo alignment")
    text = (tmp_path / "out" / "results.json").read_text()
    read = json.loads(text, parse_constant=lambda name: pytest.fail(name))
    assert read["study"] == "alignment" and read["seeds"] == SEEDS
    assert set(read["scenarios"]) == set(study.cases)
    for methods in read["scenarios"].values():
        assert set(methods) == set(METHODS)
        for row in methods.values():
            assert {"tilt_arcmin", "settle_s", "heading_deg", "nees"} <= set(row)
            assert set(row["settle_s"]) == {"median", "p95"}
    html = page.read_text()
    assert "existence" in html.lower() and html.count("<figure>") == 8 and "never" in html
    assert len(goal_rows(study)) == len(results(study)["goals"]) == 10
    assert len(rows_of(study.cases["s-10-10-60"].figures)) == len(METHODS)


def test_bad_numbers_and_a_file_in_the_way_are_named(study, tmp_path):
    with pytest.raises(InputError, match="seeds"):
        alignment_study(2)
    with pytest.raises(InputError, match="seed"):
        alignment_study(4, -1)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="output folder"):
        write_study(study, tmp_path / "file", "x")
