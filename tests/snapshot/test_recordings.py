"""Two outdoor recordings of one small rig of four anchors, found through ROBUSTNAV_DATA."""

import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.snapshot import dop_at, solve_ranges

DATA = os.environ.get("ROBUSTNAV_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/hyu")
CASES = {"Trajectory_A/Case_1": (24.2, 15.3, 18.4), "Trajectory_B/Case_3": (7.9, 4.9, 6.1)}


def table(folder, name, columns):
    with (folder / name).open() as file:
        header = file.readline().strip().split(",")
        return np.loadtxt(file, delimiter=",", usecols=[header.index(c) for c in columns])


@pytest.fixture(scope="module", params=CASES)
def case(request):
    folder = Path(DATA or ".") / "uwb/hyu/dynamic/LOS" / request.param
    columns = ["field.stamp", "field.distanceFromTag", "field.x", "field.y", "field.z"]
    logs = [table(folder, f"A{i}.csv", columns) for i in (3, 5, 9, 12)]
    truth = table(folder, "trajectory.csv", ["x", "y", "z"])
    truth[:, 2] += 1.0  # the tag above the truth's own zero
    return request.param, np.array([log[0, 2:] for log in logs]), logs, truth


def test_gdop_in_the_window_of_the_metric(case):
    name, anchors, _, truth = case
    x, y = truth[:, 0], truth[:, 1]
    a = "_A" in name
    start = np.flatnonzero((x > 49.3) & (y > -5) if a else (x < 8.6) & (y < -7))[0]
    stop = start + np.flatnonzero(((x <= 12) & (y > 3.4) if a else (x > 8.6) & (y < -7))[start:])[0]
    medians = [np.median(part) for part in dop_at(anchors, truth[start:stop])]
    assert medians == pytest.approx(CASES[name], abs=0.1)


@pytest.mark.parametrize("window_s", [0.5, 1.0, 2.0, 3.0])
def test_start_from_nothing_while_slow(case, window_s):
    _, anchors, logs, truth = case
    first = max(log[0, 0] for log in logs)
    cut = [log[(log[:, 0] > first - 1e8) & (log[:, 0] < first + window_s * 1e9), 1] for log in logs]
    s = solve_ranges(anchors, [np.median(c) for c in cut], 0.1)
    error = s.position - truth[0]
    assert s.verdict == "unique"
    assert np.linalg.norm(error) < 0.28
    assert error @ np.linalg.solve(s.covariance, error) < 16.3
