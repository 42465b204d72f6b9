"""The command line: exit codes, clean output, one JSON document, errors without tracebacks."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from robustnav.cli import main

DATA = os.environ.get("ROBUSTNAV_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="ROBUSTNAV_DATA does not name a folder with recordings")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("simulated")
    assert main(["simulate", "--motion", "case-two", "--runs", "2", "--out", str(folder), "--json"]) == 0
    return folder / "run_0000.csv"


def test_simulate_writes_one_table_a_run_and_repeats(recording, tmp_path, capsys):
    assert main(["simulate", "--motion", "case-two", "--runs", "1", "--out", str(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [Path(f).name for f in told["files"]] == ["run_0000.csv"]
    assert (tmp_path / "run_0000.csv").read_bytes() == recording.read_bytes()


@pytest.mark.parametrize("name", ["h2", "mekf", "ukf", "h2-euler", "ekf-euler"])
def test_run_scores_every_estimator_as_one_json_document(recording, name, capsys):
    assert main(["run", str(recording), "--estimator", name, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["estimator"] == name
    assert 0 < told["score"]["total_deg"] < 5
    assert told["score"]["samples"] == told["samples"] == 1001


def test_backends_agree(recording, capsys):
    scores = []
    for backend in ("c", "numpy", "float"):
        assert main(["run", str(recording), "--estimator", "mekf", "--backend", backend, "--json"]) == 0
        scores.append(json.loads(capsys.readouterr().out)["score"]["total_deg"])
    assert scores[0] == pytest.approx(scores[1], rel=1e-9)
    assert scores[0] == pytest.approx(scores[2], rel=1e-2)


def test_run_writes_page_numbers_and_table(recording, tmp_path, capsys):
    out = tmp_path / "page"
    assert main(["run", str(recording), "--out", str(out)]) == 0
    shown = capsys.readouterr()
    assert "report.html" in shown.err
    assert "Total, deg" in shown.out
    assert {p.name for p in out.iterdir()} == {"report.html", "results.json", "estimate.csv"}
    header, first = (out / "estimate.csv").read_text().splitlines()[:2]
    assert header.startswith("t_s,q_nb_w,q_nb_x,q_nb_y,q_nb_z,gyro_bias_x")
    assert len(first.split(",")) == len(header.split(","))


def test_compare_lists_every_pair(recording, capsys):
    assert main(["compare", str(recording), str(recording.with_name("run_0001.csv")), "--json", "--quiet"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert [(r["log"], r["estimator"]) for r in rows] == [
        ("run_0000.csv", "h2"), ("run_0000.csv", "mekf"), ("run_0001.csv", "h2"), ("run_0001.csv", "mekf")
    ]  # fmt: skip


def test_doctor_passes_a_good_log_and_stops_a_poisoned_one(recording, tmp_path, capsys):
    assert main(["doctor", str(recording)]) == 0
    assert main(["doctor", str(recording), "--json"]) == 0
    text = recording.read_text()
    capsys.readouterr()
    lines = text.splitlines()
    at = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    columns = lines[at].split(",")
    bad = []
    for line in lines[at + 1 :]:
        cells = line.split(",")
        for k, name in enumerate(columns):
            if name.startswith("gyro_") and "bias" not in name and cells[k]:
                cells[k] = repr(57.29578 * float(cells[k]))
        bad.append(",".join(cells))
    poisoned = tmp_path / "degrees.csv"
    poisoned.write_text("\n".join([*lines[: at + 1], *bad]) + "\n")
    assert main(["doctor", str(poisoned), "--json"]) == 2
    told = json.loads(capsys.readouterr().out)
    assert any(f["level"] == "error" for f in told["findings"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "nowhere.ulg"], ["nowhere.ulg", "check the path"]),
        (["run", "{log}", "--estimator", "kalmann"], ["kalmann", "mekf"]),
        (["run", "{log}", "--imu", "mpu9251"], ["mpu9251", "mpu9250"]),
        (["run", "{log}", "--backend", "gpu"], ["backend"]),
        (["run", "{log}", "--estimatr", "h2"], ["estimatr"]),
        (["compare", "{log}", "--estimators", ","], ["names with commas"]),
        (["simulate", "--runs", "0", "--out", "{tmp}/x"], ["runs"]),
        (["demo", "attitude", "--seeds", "2", "--out", "{tmp}/x"], ["seeds"]),
        (["design", "h2", "--rate-hz", "-5"], ["rate"]),
        (["design", "h2", "--dip-deg", "90"], ["detectable"]),
        (["doctor", "{tmp}"], ["folder"]),
    ],
)
def test_bad_input_is_one_clear_error_and_exit_2(arguments, words, recording, tmp_path):
    filled = [a.format(log=recording, tmp=tmp_path) for a in arguments]
    result = subprocess.run([sys.executable, "-m", "robustnav", *filled], capture_output=True, text=True, check=False)
    assert result.returncode in (2, 3)
    assert "Traceback" not in result.stderr + result.stdout
    assert all(w.lower() in (result.stderr + result.stdout).lower() for w in words), result.stderr
    assert not (tmp_path / "x").exists()


def test_design_routes_agree_and_certify(capsys):
    pytest.importorskip("cvxpy")
    assert main(["design", "h2", "--route", "both", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["largest_difference_of_the_routes"] < 1e-5
    assert told["certificate"]["verified"] == pytest.approx(told["h2_norm"], rel=1e-6)
    assert main(["design", "hinf", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["largest_gain_over_frequency"] <= told["gamma"]


def test_help_of_every_verb_is_light():
    code = "import sys; from robustnav.cli import main; main(['--help']); print(sorted(sys.modules), file=sys.stderr)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for heavy in ("scipy", "matplotlib", "sympy", "cvxpy", "pandas", "pyulog"):
        assert f"'{heavy}'" not in result.stderr


@needs_data
def test_the_autopilots_attitude_is_matched_within_what_two_estimators_differ_by(capsys):
    for name in ("h2", "mekf"):
        assert main(["run", str(Path(DATA) / "px4" / "sample.ulg"), "--estimator", name, "--json"]) == 0
        score = json.loads(capsys.readouterr().out)["score"]
        assert score["total_deg"] < 1.5
        assert score["inclination_deg"] < 0.5


@needs_data
def test_a_stated_declination_turns_the_result_to_true_north(capsys):
    log = Path(DATA) / "px4" / "sample_logging_tagged_and_default_params.ulg"
    assert main(["run", str(log), "--estimator", "mekf", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["settings"]["north"] == "true"
    assert abs(told["score"]["yaw_rms_deg"]) < 0.5
