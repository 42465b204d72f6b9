"""The study of moving carriers on few seeds: what it must show, and the shape of its numbers."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.studies import moving
from robustnav.studies.moving import error_rows, found_rows, goals, moving_study, results, steps_of
from robustnav.studies.moving_recordings import moving_recordings
from robustnav.studies.moving_report import GROUPS, page, write_study
from robustnav.studies.moving_setting import TIMES, mems, scenarios, tactical

DATA = os.environ.get("ROBUSTNAV_DATA")
SEEDS = 5
CHOSEN = ("drone, MEMS", "car, tactical")


@pytest.fixture(scope="module")
def counted():
    calls, few = [], {name: one for name, one in scenarios().items() if name in CHOSEN}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(moving, "scenarios", lambda: few)
        return moving_study(SEEDS, seed=3, progress=lambda: calls.append(1)), len(calls), steps_of(SEEDS)


@pytest.fixture(scope="module")
def study(counted):
    return counted[0]


def test_progress_is_called_as_often_as_announced(counted):
    assert counted[1] == counted[2] == SEEDS * len(CHOSEN)


def test_headings_are_found_soon_and_right(study):
    for row in found_rows(study):
        assert row["not_found"] == row["wrong"] == row["restarts"] == 0
        assert row["found_95_s"] < 13.0


def test_errors_fall_and_are_as_large_as_stated(study):
    for name, one in study.outcomes.items():
        figures = one.figures
        assert figures["heading_deg_50s"] < 0.7 * figures["heading_deg_5s"]
        assert figures["heading_over_peer_50s"] < 2.0
        assert 0.4 < np.mean([figures[f"nees_heading_{t:g}s"] for t in TIMES]) < 1.8, name
    fine = study.outcomes["car, tactical"].figures
    assert fine["tilt_deg_50s"] < 0.05 and fine["heading_deg_50s"] < 0.3


def test_numbers_go_out_as_json(study):
    out = json.loads(json.dumps(results(study)))
    assert set(out["scenarios"]) == set(CHOSEN) and out["seeds"] == SEEDS
    assert len(goals(study)) == 3 * len(CHOSEN) == len(out["goals"])
    assert len(error_rows(study)) == len(CHOSEN) * len(TIMES)


def test_units_are_told_to_the_filter_as_they_are_simulated():
    for grade in (mems(), tactical()):
        for name in ("gyro", "accel"):
            spec = getattr(grade.imu, name)
            assert getattr(grade.unit.noise, f"{name}_density") ** 2 == pytest.approx(spec.intensity)
            assert getattr(grade.unit.noise, f"{name}_bias_density") == spec.random_walk
            assert getattr(grade.unit, f"{name}_bias_sd") == spec.turn_on_bias_sd


def test_too_few_seeds_are_refused():
    with pytest.raises(InputError, match="seeds"):
        moving_study(3)


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with px4/")
def test_recorded_flights_of_a_simulator():
    rows = {(row["recording"], row["delay_s"]): row for row in moving_recordings(Path(DATA or ".") / "px4")}
    for row in rows.values():
        assert abs(row["heading_deg"] - row["compass_deg"]) < 2 * row["heading_sd_deg"]
    ahead = rows["ekf_gsf_reset.csv", 0.1]
    assert 25 < ahead["found_s"] < 28 and ahead["heading_sd_deg"] < 3  # it takes off at 22 s
    assert ahead["nis"] < 1.2 < rows["ekf_gsf_reset.csv", 0.0]["nis"] and ahead["neighbours"] < 0.35
    climbs = rows["iris_gps.csv", 0.1]  # straight up and down: no heading can be told
    assert np.isnan(climbs["found_s"]) and climbs["heading_sd_deg"] > 10


def test_the_page_shows_every_scenario_and_is_written_whole(study, tmp_path):
    assert sorted(name for names in GROUPS.values() for name in names) == sorted(scenarios())
    page = write_study(study, tmp_path / "out", "robustnav demo moving --seeds 5")
    text = page.read_text()
    for words in (
        *CHOSEN,
        "6 of 6 goals are met",
        "robustnav demo moving --seeds 5",
        "Error of heading",
        "Expected 1; band",
    ):
        assert words in text
    assert "Velocities or positions alone" not in text  # none of them ran
    assert text.count("<figure>") == 2
    assert json.loads((tmp_path / "out" / "results.json").read_text())["study"] == "moving"
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="output folder"):
        write_study(study, tmp_path / "file", "")


def test_a_missed_goal_is_said_first(study):
    one = study.outcomes["drone, MEMS"]
    off = replace(study, outcomes={"drone, MEMS": replace(one, squares=4 * one.squares, wrong=1)})
    text = page(off, "").html()
    assert "1 of 3 goals are met" in text and "Missed: drone, MEMS: largest heading NEES" in text
    assert text.index("Missed") < text.index("When the heading is found")
