"""Carriers in motion: ``demo``, ``benchmark``, ``simulate`` and ``align --reference gnss``; what is refused."""

import csv
import json
import os
from pathlib import Path

import pytest

from robustnav.cli import main
from robustnav.studies import moving
from robustnav.studies.moving_setting import scenarios

UNIT = ["--reference", "gnss", "--imu", "mpu9250", "--gyro-bias-sd", "0.3", "--accel-bias-sd", "0.15"]
RECEIVER = ["--velocity-sd", "0.1", "--position-sd", "1.5"]
DATA = os.environ.get("ROBUSTNAV_DATA")


@pytest.fixture(scope="module")
def car(tmp_path_factory):
    path = tmp_path_factory.mktemp("driven") / "car.csv"
    assert main(["simulate", "moving", "--case", "car", "--seed", "3", "--duration", "30", "--out", str(path)]) == 0
    return path


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


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with px4/")
def test_a_recorded_compass_is_heard_where_the_flight_is_silent(capsys):
    flight = Path(DATA or ".") / "px4" / "iris_gps.csv"
    words = [*UNIT, "--velocity-sd", 0.1, "--position-sd", 0.5, "--stop", 15]
    alone = told(capsys, "align", flight, *words, code=3)
    heard = told(capsys, "align", flight, *words, "--compass", "--declination", 2.8, code=3)
    assert not any("mag" in event for event in alone["events"])
    assert any("mag readings fused as a heading" in event for event in heard["events"])
    assert heard["settings"]["heading sd [rad]"] == pytest.approx(0.2618, abs=1e-4)
    assert main(["align", str(flight), *map(str, words), "--compass"]) == 2
    assert "--declination" in capsys.readouterr().err


def told(capsys, *arguments, code=0):
    capsys.readouterr()
    assert main([*map(str, arguments), "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_a_simulated_car_is_aligned_and_shown(car, tmp_path, capsys):
    done = told(capsys, "align", car, *UNIT, *RECEIVER, "--out", tmp_path / "out")
    assert done["verdict"]["level"] == "ok" and done["heading_observable"]
    assert 3 < done["aligned_after_s"] < 15 and done["duration_s"] == pytest.approx(30, abs=0.2)
    within = done["final"]["heading"]["within_deg"]
    assert within < 5 and abs(done["errors"]["heading_deg"]) < 2 * within
    assert done["errors"]["tilt_arcmin"] < 1.6 * done["final"]["tilt_95_arcmin"]
    assert done["settings"]["velocity sd [m/s]"] == 0.1 and "tdoa sd [m]" not in done["settings"]
    assert done["settings"]["gyro_bias_sd_deg_s"] == pytest.approx(0.3) and done["wind"] is None
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Route" in page and "Reference velocity" not in page and "--imu mpu9250 --reference gnss" in page
    rows = list(csv.DictReader((tmp_path / "out" / "alignment.csv").read_text().splitlines()))
    assert rows[0]["q_nb_w"] == "" and float(rows[-1]["p_n_x_m"]) == done["final"]["p_n_m"][0]
    assert len(rows) == pytest.approx(300, abs=2) and "wind_north_m_s" not in rows[0]
    open_yet = [row["heading_95_deg"] == "" for row in rows if float(row["t_s"]) < done["aligned_at_s"] - 0.1]
    assert all(open_yet)
    thin = told(capsys, "align", car, *UNIT, "--velocity-sd", 0.1, "--period", 1)
    assert thin["final"]["q_nb"] == pytest.approx(done["final"]["q_nb"], abs=0.02)
    assert "gnss_position without position_sd: not fused" in thin["events"]
    armed = told(capsys, "align", car, *UNIT, *RECEIVER, "--lever", "3,0,-1", "--delay", "0.3", code=3)
    assert armed["settings"]["lever_b_m"] == "3, 0, -1" and armed["settings"]["delay_s"] == 0.3
    assert "far more than claimed" in " ".join(armed["verdict"]["reasons"])  # there is no arm and no delay


def test_a_short_drive_finds_no_heading_and_that_is_exit_3(car, capsys):
    short = told(capsys, "align", car, *UNIT, *RECEIVER, "--stop", 3, code=3)
    assert short["aligned_after_s"] is None and short["final"]["heading"]["value_deg"] is None
    assert "heading never found" in short["verdict"]["text"]
    assert main(["align", str(car), *UNIT, *RECEIVER, "--stop", "3"]) == 3
    assert "standard deviation is" in capsys.readouterr().out
    assert main(["align", str(car), *UNIT, *RECEIVER, "--stop", "0.5"]) == 3
    shown = capsys.readouterr()
    assert "no tilt to start from" in shown.err and not shown.out


def changed(car, folder, cell):
    """Write the table again with each cell as ``cell`` says, None to leave the column out."""
    lines = car.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    names = lines[at].split(",")
    rows = [[cell(name, value) for name, value in zip(names, line.split(","), strict=True)] for line in lines[at + 1 :]]
    kept = [k for k, value in enumerate(rows[0]) if value is not None]
    out = [",".join(row[k] for k in kept) for row in [names, *rows]]
    path = folder / "changed.csv"
    path.write_text("\n".join([*lines[:at], *out]) + "\n")
    return path


@pytest.mark.parametrize(
    ("cell", "code", "words"),
    [
        (lambda n, v: None if n.startswith("gnss") else v, 2, ["no GNSS to align with", "gnss_velocity"]),
        (lambda n, v: "nan" if n.startswith("gnss") and v else v, 3, ["no tilt to start from"]),
        (lambda n, v: None if n.startswith("gyro") else v, 2, ["no stream 'gyro'"]),
        (lambda n, v: None if n.startswith("accel") else v, 2, ["no stream 'accel'"]),
    ],
    ids=["no GNSS", "no fix", "no gyro", "no accelerometer"],
)
def test_a_spoiled_recording_is_one_clear_error(car, tmp_path, cell, code, words, capsys):
    assert main(["align", str(changed(car, tmp_path, cell)), *UNIT, *RECEIVER]) == code
    shown = capsys.readouterr()
    assert all(word in shown.err for word in words) and not shown.out, shown.err


def test_a_heading_far_from_the_truth_is_exit_3(car, tmp_path, capsys):
    def swapped(name, value):  # the truth's nose is turned by half a turn
        return {"q_nb_w": "0.0", "q_nb_x": "0.0", "q_nb_y": "0.0", "q_nb_z": "1.0"}.get(name, value)

    done = told(capsys, "align", changed(car, tmp_path, swapped), *UNIT, *RECEIVER, code=3)
    assert any(reason.startswith("The heading is off by") for reason in done["verdict"]["reasons"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--imu", "mpu9250"], ["noise of the satellite receiver", "--velocity-sd"]),
        (["--imu", "mpu9250", "--velocity-sd", "0"], ["velocity_sd", "above zero"]),
        (["--imu", "mpu9250", *RECEIVER, "--lever", "1,2"], ["--lever", "0.3,-0.2,-0.5"]),
        (["--imu", "mpu9250", *RECEIVER, "--lever", "1,2,nan"], ["lever", "finite"]),
        (["--imu", "mpu9250", *RECEIVER, "--compass"], ["no stream 'mag'"]),
        (["--imu", "mpu9250", *RECEIVER, "--compass-sd", "5"], ["--compass-sd", "--heading-sd"]),
        (["--imu", "mpu9250", *RECEIVER, "--longest"], ["--longest"]),
        (["--imu", "mpu9250", *RECEIVER, "--period", "0"], ["--period"]),
        (["--imu", "mpu9250", *RECEIVER, "--start", "99"], ["'gyro'", "0 samples"]),
        (RECEIVER, ["--imu", "--grade"]),
    ],
)
def test_what_cannot_be_is_exit_2(car, arguments, words, capsys):
    assert main(["align", str(car), "--reference", "gnss", *arguments]) == 2
    shown = capsys.readouterr()
    assert all(word in shown.err for word in words) and not shown.out, shown.err


def test_a_receiver_is_for_motion_alone(car, capsys):
    assert main(["align", str(car), "--imu", "mpu9250", "--delay", "0.1"]) == 2
    assert "--reference gnss" in capsys.readouterr().err


def test_what_a_receiver_claims_of_itself_is_taken_and_named(car, tmp_path, capsys):
    path = tmp_path / "claimed.csv"
    path.write_text(car.read_text().replace('"latitude_deg"', '"gnss_speed_sd_m_s": 0.2, "latitude_deg"', 1))
    done = told(capsys, "align", path, *UNIT)
    assert done["settings"]["velocity sd [m/s]"] == 0.2
    assert "velocity sd 0.2, as the receiver claims of itself" in done["events"]
