"""The planar model on a trolley with three tags: better than instants by themselves, and why."""

import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.benchmark import lias_methods
from robustnav.benchmark.uwb_lias import benchmark_lias

DATA = os.environ.get("ROBUSTNAV_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")


def test_a_trolley_is_followed(monkeypatch):
    def figures():
        return benchmark_lias(Path(DATA) / "uwb" / "lias_mid")["cases"]["dynamic_exp_mid"]

    row = figures()
    assert row["ekf"]["rmse_2d"] < 0.025 and row["ekf"]["yaw_rmse_deg"] < 3.4
    assert row["rts"]["rmse_2d"] < 0.022 and row["rts"]["yaw_rmse_deg"] < 2.7
    monkeypatch.setattr(lias_methods, "PATTERN", np.zeros((3, 4)))
    assert figures()["ekf"]["rmse_2d"] > 0.030
