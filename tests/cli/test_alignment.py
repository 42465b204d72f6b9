"""``align`` and ``simulate alignment``: round trip, exit codes, and every mistake a user can make told in words."""

import csv
import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from robustnav.cli import main
from robustnav.cli.alignment_case import setup_of
from robustnav.frames import quat_conjugate, quat_from_rotvec, rotate
from robustnav.logs import write_table
from robustnav.records import Stream
from robustnav.sim.alignment import load_scenario
from robustnav.sim.alignment_log import alignment_log
from robustnav.studies.alignment_setting import setup_of as study_setup
from robustnav.units import DEG

SCENARIO = """
duration_s = 40.0
imu_rate_hz = 50.0
filter_rate_hz = 10.0
latitude_deg = 45.0
height_m = 100.0
heading_deg = 30.0
velocity_sd_mps = 0.05
roll = {amplitude_deg = 3.0, frequency_hz = 0.2}
pitch = {mean_deg = 5.0, amplitude_deg = 2.0, frequency_hz = 0.3}
gyro_dph = {bias = 0.01, white_sd = 0.01, markov_sd = 0.01, markov_time_s = 3600.0}
accel_mg = {bias = 0.1, white_sd = 0.1, markov_sd = 0.1, markov_time_s = 1800.0}
misalignment_deg = [10.0, 10.0, 60.0]
[[wind]]
mean_ned_mps = [2.0, 1.0, 0.0]
lines = [{frequency_radps = 1.0, amplitude_ned_mps = [0.3, 0.2, 0.0]}]
"""
GRADE = ["--grade", "0.01deg/h,0.1mg"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("moored")
    (where / "calm.toml").write_text(SCENARIO)
    made = ["simulate", "alignment", "--scenario", str(where / "calm.toml"), "--seed", "4"]
    assert main([*made, "--out", str(where / "log.csv"), "--json"]) == 0
    return where


def told(capsys, *arguments, code=0):
    capsys.readouterr()
    assert main([*map(str, arguments), "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_a_recording_gives_what_its_scenario_gives(folder, capsys):
    made = told(capsys, "align", "--scenario", folder / "calm.toml", "--seed", 4)
    read = told(capsys, "align", folder / "log.csv", *GRADE)
    assert made["verdict"]["level"] == read["verdict"]["level"] == "ok"
    # not the same: the grade states its noise at 1 kHz, the scenario at 50 Hz
    assert read["final"]["q_nb"] == pytest.approx(made["final"]["q_nb"], abs=3e-3)
    assert read["aligned_after_s"] == pytest.approx(made["aligned_after_s"], abs=2)
    assert abs(read["final"]["heading"]["value_deg"] - 30.0) < 2 * read["final"]["heading"]["within_deg"]
    assert read["errors"]["tilt_arcmin"] < 3
    assert read["errors"]["heading_deg"] == pytest.approx(30.0 - read["final"]["heading"]["value_deg"], abs=1e-6)
    assert made["wind"]["line_period"] == pytest.approx([6.283], rel=0.02)
    assert read["settings"]["latitude_deg"] == 45.0 and read["settings"]["height_m"] == 100.0
    assert read["settings"]["gravity_m_s2"] < 9.8062 - 2e-4  # less than at the ellipsoid


def test_words_page_and_table(folder, tmp_path, capsys):
    assert (
        main(["align", "--scenario", "s-10-10-60", "--wind", "gusts", "--seed", "4", "--out", str(tmp_path / "a b")])
        == 0
    )
    shown = capsys.readouterr()
    assert "aligned after" in shown.out and "heading not observable: a gyro bias of 0.0141 deg/s" in shown.out
    assert "12.6 s (0.58 m/s)" in shown.out and "gusts" in shown.out and "Tilt arcmin" in shown.out
    assert {p.name for p in (tmp_path / "a b").iterdir()} == {"report.html", "results.json", "alignment.csv"}
    assert (
        "robustnav align --scenario s-10-10-60 --wind gusts --seed 4" in (tmp_path / "a b" / "report.html").read_text()
    )
    with (tmp_path / "a b" / "alignment.csv").open() as file:
        assert sum(1 for _ in csv.reader(file)) == 2001


def test_a_part_can_be_taken_and_the_clock_stays(folder, capsys):
    part = told(capsys, "align", folder / "log.csv", *GRADE, "--start", 10, "--stop", 35, "--period", 0.5)
    assert part["final"]["t_s"] == pytest.approx(35.0, abs=0.5)
    assert part["aligned_at_s"] - part["aligned_after_s"] == pytest.approx(9.98, abs=0.5)
    assert part["settings"]["period_s"] == 0.5


def test_short_data_never_align_and_that_is_exit_3(folder, capsys):
    short = told(capsys, "align", folder / "log.csv", *GRADE, "--stop", 4, code=3)
    assert short["aligned_after_s"] is None and short["verdict"]["level"] == "error"
    assert main(["align", str(folder / "log.csv"), *GRADE, "--stop", "4"]) == 3
    assert "never aligned" in capsys.readouterr().out


def test_a_base_at_rest_needs_no_reference(folder, tmp_path, capsys):
    lines = (folder / "log.csv").read_text().splitlines()
    path = columns(tmp_path, lines, drop="velocity")
    rest = told(capsys, "align", path, *GRADE, "--reference", "zero")
    assert rest["errors"]["tilt_arcmin"] < 10 and rest["wind"] is None and rest["reference_readings"] == 0
    assert main(["align", str(path), *GRADE]) == 2
    assert "--reference zero" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["s-10-10-60", "h-30-30-170"])
def test_a_scenario_states_its_sensors_as_the_study_does(name):
    scenario = load_scenario(name)
    np.testing.assert_allclose(setup_of(scenario).numbers, study_setup(scenario).numbers, rtol=1e-9)


def columns(folder, lines, *, drop=None, scale=None, rename=None, rows=None):
    """Write a table again, columns left out, scaled or renamed, rows (after the header) left out."""
    at = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    names = lines[at].split(",")
    kept = [k for k, name in enumerate(names) if drop is None or not name.startswith(drop)]
    out = [",".join(rename.get(names[k], names[k]) if rename else names[k] for k in kept)]
    for number, line in enumerate(lines[at + 1 :]):
        if rows is not None and not rows(number):
            continue
        cells = line.split(",")
        if scale is not None:
            prefix, factor = scale
            cells = [
                repr(float(c) * factor) if n.startswith(prefix) and c else c for n, c in zip(names, cells, strict=True)
            ]
        out.append(",".join(cells[k] for k in kept))
    path = folder / "changed.csv"
    path.write_text("\n".join([*lines[:at], *out]) + "\n")
    return path


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"scale": ("gyro", 57.29578)}, ["rad/s, not deg/s", "doctor"]),
        ({"scale": ("accel", 1 / 9.80665)}, ["accelerometer at rest", "9.81"]),
        ({"scale": ("velocity", 100.0)}, ["at a mooring", "unit"]),
        (
            {"rename": {"velocity_north_m_s": "velocity_north_kn"}},
            ["velocity_north_kn", "velocity_north_m_s", "mapping"],
        ),
        ({"drop": "gyro"}, ["no stream 'gyro'"]),
        (
            {"rows": lambda k: not 501 <= k < 601},
            ["1 gap,", "after 10.000 s", "--start 12.020 --stop 40.000", "--longest"],
        ),
        ({"rows": lambda k: k < 80}, ["too short"]),
    ],
)
def test_a_spoiled_recording_is_one_clear_error(folder, tmp_path, change, words, capsys):
    path = columns(tmp_path, (folder / "log.csv").read_text().splitlines(), **change)
    assert main(["align", str(path), *GRADE]) == 2
    shown = capsys.readouterr()
    assert all(word in shown.err for word in words), shown.err
    assert not shown.out


def test_the_longest_piece_is_aligned_when_asked(folder, tmp_path, capsys):
    path = columns(tmp_path, (folder / "log.csv").read_text().splitlines(), rows=lambda k: not 501 <= k < 601)
    assert main(["align", str(path), *GRADE, "--longest"]) == 0
    assert "longest piece, 12.020 to 40.000 s" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["neither a recording nor a scenario", "--scenario"]),
        (["{log}"], ["--imu", "--grade"]),
        (["{log}", "--grade", "0.01deg/h"], ["0.01deg/h,0.1mg"]),
        (["{log}", "--imu", "mpu9251"], ["mpu9251", "mpu9250"]),
        (["{log}", "--imu", "mpu9250", *GRADE], ["both"]),
        (["{log}", *GRADE, "--latitude", "-89"], ["latitude", "85"]),
        (["{log}", *GRADE, "--latitude", "nan"], ["latitude"]),
        (["{log}", *GRADE, "--height", "nan"], ["height"]),
        (["{log}", *GRADE, "--height", "-7000000"], ["height"]),
        (["{log}", *GRADE, "--period", "0"], ["dt", "positive"]),
        (["{log}", *GRADE, "--period", "0.3"], ["period", "0.1 to 0.5"]),
        (["{log}", *GRADE, "--reference-sd", "0"], ["reference_sd"]),
        (["{log}", *GRADE, "--reference", "gps"], ["reference"]),
        (["{log}", *GRADE, "--start", "50"], ["0 and 0 readings"]),
        (["{log}", *GRADE, "--out", "{log}"], ["a file"]),
        (["{log}", *GRADE, "--wind", "gusts"], ["--wind", "a recording"]),
        (["{log}", "--scenario", "s-10-10-60"], ["--scenario", "a recording"]),
        (["{log}", *GRADE, "--compass"], ["'mag'"]),
        (["--scenario", "s-10-10-60", "--latitude", "3"], ["--latitude", "a scenario"]),
        (["--scenario", "s-10-10-61"], ["s-10-10-61", "s-10-10-60"]),
        (["--scenario", "s-10-10-60", "--wind", "storm"], ["storm", "gusts"]),
        (["--scenario", "s-10-10-60", "--seed", "-1"], ["seed"]),
        (["--scenario", "{tmp}/no.toml"], ["no.toml"]),
        (["nowhere.csv", *GRADE], ["nowhere.csv", "check the path"]),
        (["{tmp}/empty.csv", *GRADE], ["empty file"]),
        (["{tmp}/bare.csv", *GRADE], ["latitude", "--latitude DEG"]),
    ],
)
def test_bad_input_is_one_clear_error_and_exit_2(arguments, words, folder, tmp_path, capsys):
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "bare.csv").write_text("t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s\n0,0,0,0\n")
    filled = [a.format(log=folder / "log.csv", tmp=tmp_path) for a in arguments]
    try:
        code = main(["align", *filled])
    except SystemExit as stopped:  # usage
        code = stopped.code
    shown = capsys.readouterr()
    assert code == 2
    said = (shown.err + shown.out).lower()
    assert all(word.lower() in said for word in words), said
    assert "traceback" not in said


def test_in_a_shell_errors_have_no_traceback(folder, tmp_path):
    command = [sys.executable, "-m", "robustnav", "align", str(folder / "log.csv"), "--grade", "good"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 2 and "Traceback" not in result.stderr and result.stderr.startswith("error:")


@pytest.mark.parametrize(
    "arguments", [["--scenario", "nothing"], [], ["--scenario", "{tmp}/calm.toml", "--out", "{tmp}"]]
)
def test_a_simulation_that_cannot_be_written_is_refused(arguments, folder, capsys):
    assert main(["simulate", "alignment", *(a.format(tmp=folder) for a in arguments)]) == 2
    assert "error:" in capsys.readouterr().err


def test_a_compass_gives_the_heading_that_coarse_gyros_do_not(folder, tmp_path, capsys):
    text = (folder / "calm.toml").read_text().replace("gyro_dph", "gyro_dps")
    (tmp_path / "coarse.toml").write_text(text)
    log = alignment_log(load_scenario(tmp_path / "coarse.toml"), 1)
    north = quat_from_rotvec([0.0, 0.0, 3 * DEG])  # declination
    field_n = rotate(north, np.array([20e-6, 0.0, 40e-6]))
    mag = Stream("mag", log.truth.t, rotate(quat_conjugate(log.truth.q_nb), field_n), "T")
    write_table(replace(log, streams={**log.streams, "mag": mag}), tmp_path / "log.csv")
    arguments = ("align", tmp_path / "log.csv", "--grade", "0.01deg/s,0.1mg")
    assert not told(capsys, *arguments)["heading_observable"]
    found = told(capsys, *arguments, "--compass", "--declination", 3, "--compass-bias-sd", 1)
    assert found["heading_observable"] and found["settings"]["declination_deg"] == 3.0
    assert abs(found["errors"]["heading_deg"]) < 1.0
    assert 1.5 < found["final"]["heading"]["within_deg"] < 3.0
    assert main([*map(str, arguments), "--compass"]) == 2
    assert "--declination DEG" in capsys.readouterr().err
