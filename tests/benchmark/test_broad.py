import json
import sys

import numpy as np
import pytest
from scipy.io import savemat

from robustnav.benchmark import broad
from robustnav.benchmark.broad import benchmark_broad, default_estimators, group_rows, trial_files, trial_rows
from robustnav.benchmark.peers import PEERS, installed_peers
from robustnav.errors import EstimatorError, InputError
from robustnav.evaluate.tables import plain, text_table
from robustnav.run.recorded import Sensors, run_recorded

SENSORS = Sensors("mpu9250", "ak8963")
FIGURES = ("total_deg", "heading_deg", "inclination_deg")


def test_results_have_every_trial_estimator_and_group(folder):
    steps = []
    results = benchmark_broad(folder, ["h2", "mekf"], sensors=SENSORS, progress=lambda: steps.append(1))
    assert len(steps) == 4
    assert list(results["trials"]) == ["03", "30"]
    assert list(results["estimators"]) == ["h2", "mekf"]
    for name in ("h2", "mekf"):
        groups = results["estimators"][name]
        assert {g: figures["trials"] for g, figures in groups.items()} == {"undisturbed": 1, "disturbed": 1, "all": 2}
        for figure in FIGURES:
            rows = [results["trials"][trial][name][figure] for trial in ("03", "30")]
            assert groups["all"][figure] == pytest.approx(np.mean(rows))
            assert 0 < rows[0] < 5
        metric = results["trials"]["03"][name]
        assert (metric["samples"], metric["nan_estimates"]) == (1500, 0)
        assert "failed" not in metric and groups["all"]["failed"] == 0
    document = json.loads(json.dumps(plain(results), allow_nan=False))
    assert document["estimators"]["h2"]["all"].keys() == {*FIGURES, "trials", "failed"}
    assert document["settings"] == {"imu": "mpu9250", "magnetometer": "ak8963"}


def test_a_group_without_trials_is_left_out(tmp_path, fields):
    savemat(tmp_path / "01_undisturbed.mat", fields)
    results = benchmark_broad(tmp_path, ["h2"], sensors=SENSORS)
    assert list(results["estimators"]["h2"]) == ["undisturbed", "all"]
    (row,) = group_rows(results)
    assert "disturbed_total_deg" not in row and row["trials"] == 1


def test_the_default_is_ours_and_every_peer_that_is_installed(monkeypatch):
    assert default_estimators() == ["h2", "mekf", *installed_peers()]
    for name in PEERS:
        monkeypatch.setitem(sys.modules, PEERS[name].module, None)
    assert default_estimators() == ["h2", "mekf"]


def test_a_missing_peer_is_listed_and_left_out(monkeypatch, folder):
    monkeypatch.setitem(sys.modules, "vqf", None)
    results = benchmark_broad(folder, ["vqf", "mekf"], sensors=SENSORS)
    assert list(results["estimators"]) == ["mekf"]
    assert "vqf" in results["missing_peers"] and "mekf" not in results["missing_peers"]


def test_smoothers_are_told_apart(folder):
    if "vqf" not in installed_peers():
        pytest.skip("needs the peer library vqf")
    results = benchmark_broad(folder, ["vqf", "offline-vqf"], sensors=SENSORS)
    assert {row["estimator"]: row["kind"] for row in group_rows(results)} == {
        "vqf": "online",
        "offline-vqf": "smoother",
    }
    assert results["settings"]["vqf"]["library"].startswith("vqf ")


@pytest.mark.parametrize("error", [EstimatorError("the filter broke"), ZeroDivisionError("the filter broke")])
def test_an_estimator_that_fails_is_reported_and_spoils_its_mean(monkeypatch, folder, error):
    calls = []

    def breaks_once(name, log, sensors):
        calls.append(name)
        if len(calls) == 1:
            raise error
        return run_recorded(name, log, sensors)

    monkeypatch.setattr(broad, "run_recorded", breaks_once)
    results = benchmark_broad(folder, ["mekf"], sensors=SENSORS)
    assert results["trials"]["03"]["mekf"]["failed"] == "the filter broke"
    assert np.isnan(results["trials"]["03"]["mekf"]["total_deg"])
    groups = results["estimators"]["mekf"]
    assert [groups[g]["failed"] for g in ("undisturbed", "disturbed", "all")] == [1, 0, 1]
    assert [groups[g]["trials"] for g in ("undisturbed", "disturbed", "all")] == [1, 1, 2]
    assert np.isnan(groups["all"]["total_deg"]) and np.isfinite(groups["disturbed"]["total_deg"])
    assert "the filter broke" in text_table(trial_rows(results))
    assert json.loads(json.dumps(plain(results)))["estimators"]["mekf"]["all"]["total_deg"] is None


def test_nan_estimates_count_as_a_failure(monkeypatch, folder):
    def forgets(name, log, sensors):
        run = run_recorded(name, log, sensors)
        run.state["q_nb"][-3:] = np.nan
        return run

    monkeypatch.setattr(broad, "run_recorded", forgets)
    metric = benchmark_broad(folder, ["mekf"], sensors=SENSORS)["trials"]["03"]["mekf"]
    assert metric["nan_estimates"] == 3 and metric["failed"] == "3 of 1500 scored estimates are NaN"


def test_rows_show_every_trial_and_every_mean(folder):
    results = benchmark_broad(folder, ["h2", "mekf"], sensors=SENSORS)
    rows = trial_rows(results)
    pairs = [("03", "undisturbed"), ("30", "disturbed")]
    wanted = [(*pair, name) for pair in pairs for name in ("h2", "mekf")]
    assert [(row["trial"], row["group"], row["estimator"]) for row in rows] == wanted
    means = group_rows(results)
    assert means[1]["all_total_deg"] == results["estimators"]["mekf"]["all"]["total_deg"]
    assert means[1]["heading_deg"] == results["estimators"]["mekf"]["all"]["heading_deg"]


def test_a_name_given_twice_runs_once(folder):
    assert list(benchmark_broad(folder, ["h2", "h2"], sensors=SENSORS)["estimators"]) == ["h2"]


def test_an_unknown_estimator_is_refused_with_the_known_ones(folder):
    with pytest.raises(InputError, match="estimator 'madgwick'") as error:
        benchmark_broad(folder, ["h2", "madgwick"], sensors=SENSORS)
    assert "mekf" in str(error.value) and "offline-vqf" in str(error.value)


@pytest.mark.parametrize("sensors", [Sensors("nonesuch", "ak8963"), Sensors("mpu9250", "nonesuch")])
def test_an_unknown_preset_is_an_error_not_a_failed_trial(folder, sensors):
    with pytest.raises(InputError, match="nonesuch"):
        benchmark_broad(folder, ["h2"], sensors=sensors)


def test_folders_that_are_none_are_refused(tmp_path):
    for place, got in ((tmp_path / "nowhere", "not a folder"), (tmp_path, "no .mat file")):
        with pytest.raises(InputError, match="no BROAD trials") as error:
            trial_files(place)
        assert got in str(error.value) and place.name in str(error.value)


def test_files_that_are_no_trials_are_refused_by_name(tmp_path, fields):
    (tmp_path / "notes.mat").write_bytes(b"x")
    with pytest.raises(InputError, match="notes"):
        trial_files(tmp_path)
    (tmp_path / "notes.mat").rename(tmp_path / "01_damaged.mat")
    with pytest.raises(InputError, match="01_damaged"):
        benchmark_broad(tmp_path, ["h2"], sensors=SENSORS)
    savemat(tmp_path / "01_again.mat", fields)
    with pytest.raises(InputError, match="trial 01 twice"):
        trial_files(tmp_path)
