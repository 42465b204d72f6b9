"""The inertial filter on a walk with an inertial unit, five anchors and a tracker: what it reaches and says."""

import os
from dataclasses import replace
from pathlib import Path

import pytest

from robustnav.benchmark.isas_methods import LEVER_B, isas_methods, ours
from robustnav.benchmark.uwb_isas import benchmark_isas
from robustnav.logs import read_uwb_isas
from robustnav.run.inertial import run_inertial

DATA = os.environ.get("ROBUSTNAV_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")


def test_a_walk_is_followed_without_a_prior():
    pytest.importorskip("rosbags")
    row = benchmark_isas(Path(DATA) / "uwb" / "isas_walk1", isas_methods())["cases"]["ISAS-Walk1"]
    assert row["ekf"]["rmse_3d"] < 0.138 and row["rts"]["rmse_3d"] < 0.080
    assert row["ekf"]["max_3d"] < 0.45 and row["ekf"]["unstarted"] < 10
    assert row["ekf"]["rmse_3d"] < 0.6 * row["snapshot"]["rmse_3d"]


def test_it_says_when_it_knew_the_heading():
    pytest.importorskip("rosbags")
    recording = read_uwb_isas(Path(DATA) / "uwb" / "isas_walk1" / "ISAS-Walk1.bag")
    run = run_inertial(ours(), replace(recording.ranges, lever_b=LEVER_B), recording.log)
    assert any(e.startswith("heading found") for e in run.events) and not any("lost" in e for e in run.events)
