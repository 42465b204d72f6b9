"""The ranging study on few seeds: what it must show, and the shape of what it writes."""

import json

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.studies.uwb import OWN, goals, results, steps_of, uwb_study
from robustnav.studies.uwb_figures import Followed, is_lost, position_figures, recovery_of
from robustnav.studies.uwb_own import run_bounded
from robustnav.studies.uwb_report import write_study
from robustnav.studies.uwb_runs import fitted_line
from robustnav.studies.uwb_setting import FLIGHT, Scenario, scenarios

SEEDS = 5


@pytest.fixture(scope="module")
def counted():
    calls = []
    return uwb_study(SEEDS, seed=3, progress=lambda: calls.append(1)), len(calls)


@pytest.fixture(scope="module")
def study(counted):
    return counted[0]


def test_progress_is_called_as_often_as_announced(counted):
    assert counted[1] == steps_of(SEEDS)


def test_every_filter_is_near_the_bound_with_gaussian_ranges(study):
    own = study.own.figures
    for name in ("ekf", "gate", "student"):
        assert 0.75 < own[name]["rmse_3d"] / own["bound"]["rmse_3d"] < 1.35


def test_white_noise_makes_a_filter_too_sure_of_lasting_errors(study):
    figures = study.coloured.figures
    assert figures["white noise"]["nees"] > 1.5 * figures["biased"]["nees"]


def test_outliers_cost_little_and_a_tag_carried_away_is_found(study):
    figures = {name: outcome.figures for name, outcome in study.scenarios.items()}
    assert figures["outliers"]["student"]["rmse_3d"] < 1.5 * figures["clean"]["student"]["rmse_3d"]
    for name in ("outage", "kidnapped", "jump"):
        for method in ("gate", "student"):
            assert figures[name][method]["recovery_max_s"] < 2.0
            assert figures[name][method]["lost"] == 0
        assert figures[name]["published"]["lost"] > 0


def test_what_ranges_do_not_tell_is_refused_or_named(study):
    doubtful = study.doubtful
    assert doubtful["anchors in line"]["refused"] == SEEDS
    for name in ("below the plane", "through the plane", "in the plane"):
        assert doubtful[name]["said_two_places"] == SEEDS
        assert doubtful[name]["wrong"] == 0


def test_equal_seeds_give_equal_figures():
    once, again = (run_bounded(4, 7, lambda: None).figures for _ in range(2))
    assert once == again


def test_results_have_the_documented_shape(study, tmp_path):
    page = write_study(study, tmp_path / "out", "robustnav demo uwb")
    found = json.loads((tmp_path / "out" / "results.json").read_text())
    assert found["study"] == "uwb"
    assert found["seeds"] == SEEDS
    for name, scenario in scenarios().items():
        for method in scenario.methods:
            assert {"rmse_2d", "rmse_3d", "p95_3d", "nees", "lost"} <= set(found["scenarios"][name][method])
    assert found["scenarios"][OWN]["bound"]["rmse_3d"] > 0
    assert "trilateration" in found["scenarios"][FLIGHT]
    assert len(found["goals"]) == len(goals(study))
    assert set(results(study)["doubtful"]) == set(found["doubtful"])
    html = page.read_text()
    assert "src=" not in html
    assert "<script" not in html
    assert html.count("<figure>") == 7


def test_too_few_seeds_and_a_file_as_folder_are_refused(study, tmp_path):
    with pytest.raises(InputError, match="seeds"):
        uwb_study(3)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="folder"):
        write_study(study, tmp_path / "file", "")


def test_the_line_is_undone():
    true = np.array([3.0, 8.0, 15.0])
    np.testing.assert_allclose(fitted_line(1)(1.0045 * true + 0.075), true, atol=0.02)


def followed(far, t=None):
    t = np.arange(len(far)) * 0.1 if t is None else t
    error = np.zeros((len(far), 3))
    error[:, 0] = np.where(far, 5.0, 0.1)
    return Followed(t, error, np.ones_like(error))


def timed(returns):
    one = scenarios()["clean"]
    return Scenario(one.words, one.setup, one.motion, one.methods, returns=returns)


def test_recovery_is_the_time_until_the_error_stays_small_for_a_second():
    far = np.zeros(100, bool)
    far[50:63] = True
    assert recovery_of(followed(far), 5.0) == pytest.approx(1.2)
    far[70] = True
    assert recovery_of(followed(far), 5.0) == pytest.approx(2.0)
    assert recovery_of(followed(far | (np.arange(100) > 65)), 5.0) == np.inf
    assert recovery_of(followed(np.zeros(100, bool)), 5.0) == 0.0


def test_a_run_is_lost_when_its_error_stays_large_while_ranges_come():
    far = np.zeros(100, bool)
    far[20:38] = True
    assert not is_lost(followed(far), timed(None))
    far[20:45] = True
    assert is_lost(followed(far), timed(None))
    assert not is_lost(followed(far), timed(3.5))
    far[20:] = True
    assert is_lost(followed(far), timed(3.5))


def test_position_figures_are_those_of_all_runs_together():
    errors = [np.array([[3.0, 4.0, 0.0]]), np.array([[0.0, 0.0, 12.0]])]
    figures = position_figures(errors)
    assert figures["rmse_2d"] == pytest.approx(np.sqrt(12.5))
    assert figures["rmse_3d"] == pytest.approx(np.sqrt(0.5 * (25 + 144)))
