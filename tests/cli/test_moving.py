"""``demo moving`` and ``benchmark moving``: tables, pages, and what is refused."""

import json
import os
from pathlib import Path

import pytest

from robustnav.cli import main
from robustnav.studies import moving
from robustnav.studies.moving_setting import scenarios

DATA = os.environ.get("ROBUSTNAV_DATA")


@pytest.fixture
def one_scenario(monkeypatch):
    monkeypatch.setattr(moving, "scenarios", lambda: {"drone, MEMS": scenarios()["drone, MEMS"]})


def test_the_study_is_told_and_written(one_scenario, tmp_path, capsys):
    study = ["demo", "moving", "--seeds", "4", "--seed", "2", "--quiet", "--out", str(tmp_path / "out")]
    assert main(study) == 0
    shown = capsys.readouterr().out
    for words in ("When the heading was found", "Errors over 4 seeds", "drone, MEMS", "Goals", "report.html"):
        assert words in shown
    page = (tmp_path / "out" / "report.html").read_text()
    assert "robustnav demo moving --seeds 4 --seed 2" in page
    assert main([*study, "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out) == json.loads((tmp_path / "out" / "results.json").read_text())
    assert "report.html" in told.err and (tmp_path / "out" / "report.html").read_text() == page


def test_what_cannot_be_studied_is_exit_2(one_scenario, tmp_path, capsys):
    assert main(["demo", "moving", "--seeds", "2", "--out", str(tmp_path)]) == 2
    assert "seeds" in capsys.readouterr().err
    assert main(["benchmark", "moving", str(tmp_path)]) == 2
    assert "ekf_gsf_reset.csv" in capsys.readouterr().err


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with px4/")
def test_recorded_flights_are_told(capsys):
    assert main(["benchmark", "moving", str(Path(DATA or ".") / "px4"), "--json"]) == 0
    flights = json.loads(capsys.readouterr().out)["flights"]
    assert len(flights) == 4 and {one["recording"] for one in flights} == {"ekf_gsf_reset.csv", "iris_gps.csv"}
    assert [one["found_s"] is None for one in flights] == [False, False, True, True]  # one flight tells no heading
