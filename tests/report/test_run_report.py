import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from robustnav.doctor.record import Diagnosis, Finding
from robustnav.errors import InputError
from robustnav.evaluate import evaluate
from robustnav.evaluate.attitude import NOT_AN_ERROR
from robustnav.frames import euler_from_quat
from robustnav.records import Run
from robustnav.report import report
from robustnav.report.verdict import innovation_rows, judge

DIAGNOSIS = Diagnosis(
    "flight.ulg",
    (
        Finding("F", "ok", "accelerometer size"),
        Finding("T", "warning", "gaps in accel", "2 gaps <b>", "none", "check the logger"),
    ),
)


def test_report_holds_verdict_first_then_numbers_figures_and_settings(make_sample, tmp_path):
    run, truth, log = make_sample(
        events=("restart at 1 s",), settings={"command": "robustnav run <log>", "rate_hz": 100}
    )
    score = evaluate(run, truth)
    html = report(run, score, tmp_path / "out", log=log, diagnosis=DIAGNOSIS).read_text(encoding="utf-8")
    sections = [f"<h2>{name}</h2>" for name in ("Recording", "Score", "Figures", "Events", "Repeat")]
    places = [html.index(mark) for mark in ("verdict warning", "Total error", *sections)]
    assert places == sorted(places)
    assert html.count("<figure>") == 6
    assert html.count("robustnav run &lt;log&gt;") == 1
    assert "2 gaps &lt;b&gt;" in html and "restart at 1 s" in html
    results = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    assert results["score"]["values"]["total_deg"] == score.values["total_deg"]
    assert results["verdict"]["level"] == "warning" and results["diagnosis"]["worst"] == "warning"
    assert results["versions"]["robustnav"] and results["settings"]["rate_hz"] == 100


def test_equal_runs_give_equal_files(make_sample, tmp_path):
    for name in ("a", "b"):
        run, truth, log = make_sample()
        report(run, evaluate(run, truth), tmp_path / name, log=log)
    for file in ("report.html", "results.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_a_good_run_passes_and_each_fault_is_named(make_sample):
    run, truth, _ = make_sample()
    score = evaluate(run, truth)
    verdict = judge(run, score)
    assert verdict.level == "ok" and verdict.reasons == ()
    assert f"{score.values['total_deg']:.3g} deg RMS attitude error, over 400 samples" in verdict.text
    confident = judge(make_sample(scale=3.0)[0], score)
    assert confident.level == "warning"
    assert any("mag" in reason and "trusts itself too much" in reason for reason in confident.reasons)
    assert any("mag" in reason and "refused" in reason for reason in confident.reasons)
    assert "too little" in judge(make_sample(scale=0.3)[0], score).reasons[0]
    assert judge(run, score, DIAGNOSIS).reasons == ("Doctor: gaps in accel: 2 gaps <b>.",)
    assert judge(run, None).text.endswith("there is no reference to score it against.")
    untested = judge(replace(run, innovations={}), score)
    assert untested.level == "info" and "not tested" in untested.reasons[0]
    bad = Diagnosis("x", (Finding("G", "error", "gravity", "up"),))
    assert judge(run, score, bad).level == "error"


def test_a_nan_estimate_fails_the_run_and_the_report_still_comes(make_sample, tmp_path):
    run, truth, log = make_sample()
    run = replace(run, innovations={})
    run.state["q_nb"][200:] = np.nan
    score = evaluate(run, truth)
    verdict = judge(run, score)
    assert verdict.level == "error" and verdict.reasons[0] == "State block q_nb holds NaN from 2.000 s on."
    report(run, score, tmp_path, log=log)
    assert json.loads((tmp_path / "results.json").read_text())["score"]["values"]["total_deg"] is None


def test_another_estimate_is_called_a_difference(make_sample, tmp_path):
    run, truth, log = make_sample(kind="estimate")
    run = replace(run, innovations={})
    score = evaluate(run, truth)
    assert NOT_AN_ERROR in judge(run, score).text
    html = report(run, score, tmp_path, log=log).read_text(encoding="utf-8")
    assert "Total difference" in html and "Total error" not in html


def test_a_run_without_reference_or_attitude_has_a_report(make_sample, tmp_path):
    run, _, _ = make_sample()
    assert "nothing is scored" in report(run, None, tmp_path).read_text(encoding="utf-8")
    uwb = Run("EKF", "uwb", run.t, {"p_n": np.zeros((400, 3))}, {}, {})
    assert "<figure>" not in report(uwb, None, tmp_path / "uwb").read_text(encoding="utf-8")
    euler = Run("EKF", "attitude_euler", run.t, {"euler": euler_from_quat(run.state["q_nb"])}, {}, {})
    assert "Roll, deg" not in report(euler, None, tmp_path / "e").read_text(encoding="utf-8")  # text is drawn as paths


def test_innovation_rows_have_no_nis_for_constant_gains(make_sample):
    run, _, _ = make_sample()
    row = innovation_rows(run.innovations)[0]
    assert row["readings"] == 400 and row["expected"] == 3 and 85 < row["inside_95_%"] < 100
    constant = run.innovations["accel"]
    constant = type(constant)(constant.t, constant.z, constant.s * np.nan, constant.nis * np.nan, constant.used)
    row = innovation_rows({"accel": constant})[0]
    assert row["mean_nis"] is None and row["missing"] == 0


def test_a_file_is_no_folder_and_a_bad_setting_leaves_nothing(make_sample, tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="a file"):
        report(make_sample()[0], None, tmp_path / "file")
    run, _, _ = make_sample(settings={"bad": object()})
    with pytest.raises(InputError, match="object"):
        report(run, None, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_importing_the_package_loads_neither_matplotlib_nor_scipy():
    code = (
        "import sys, robustnav.report, robustnav.evaluate;"
        "sys.exit(any(m.split('.')[0] in ('matplotlib', 'scipy') for m in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
