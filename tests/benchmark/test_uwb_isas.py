"""The ISAS benchmark: bags in a folder, offsets on the ranges, errors after alignment."""

import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.benchmark import uwb_isas
from robustnav.benchmark.uwb_isas import OFFSETS, benchmark_isas, isas_bags, tables
from robustnav.errors import InputError
from robustnav.evaluate.tables import text_table
from robustnav.frames import matrix_from_quat, quat_from_euler
from robustnav.logs import RangeRecording
from robustnav.records import Anchors, Log, Ranges, Stream

DATA = os.environ.get("ROBUSTNAV_DATA")
TURN = matrix_from_quat(quat_from_euler([0.2, -0.1, 2.0]))


def walk(t):
    return np.column_stack([np.cos(t), np.sin(2 * t), 0.2 * np.cos(3 * t)])


def recording(ids=("7475", "9524", "10548", "15155")):
    t = np.repeat(np.arange(0.0, 20.0, 0.1), 4)
    anchor = np.tile(np.arange(4), 200)
    anchors = Anchors(ids, np.array([[0, 0, 0], [5, 0, 0], [5, 5, 2], [0, 5, 0.0]]))
    distance = np.linalg.norm(walk(t) - anchors.p_a[anchor], axis=1) - [OFFSETS.get(ids[a], 0.0) for a in anchor]
    ranges = Ranges(t, anchor, np.zeros(len(t), int), distance, anchors)
    t_ref = np.arange(-1.0, 19.0, 0.02)
    reference = Stream("position", t_ref, walk(t_ref) @ TURN.T + [1.0, 2, 3], "m", "vive")
    vendor = Stream("vendor", t[::4], walk(t[::4]) + np.array([0, 0, 9.0]), "m", "a")
    return RangeRecording(ranges, Log({}, "made"), {"position": reference}, {"vendor": vendor})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "Walk.bag").write_bytes(b"bag")
    monkeypatch.setattr(uwb_isas, "read_uwb_isas", lambda path: recording())
    return tmp_path


def test_bags_are_found_by_name(folder, tmp_path):
    assert isas_bags(folder) == {"Walk": folder / "sub" / "Walk.bag"}
    assert isas_bags(folder / "sub" / "Walk.bag") == {"Walk": folder / "sub" / "Walk.bag"}
    (tmp_path / "Walk.bag").write_bytes(b"bag")
    with pytest.raises(InputError, match="a walk twice"):
        isas_bags(folder)
    for place in (tmp_path / "none", folder / "sub"):
        (folder / "sub" / "Walk.bag").unlink(missing_ok=True)
        with pytest.raises(InputError, match="no ISAS walks"):
            isas_bags(place)


def test_methods_get_calibrated_ranges_and_are_aligned(folder):
    seen = []

    def method(given, t):
        near = np.linalg.norm(walk(given.ranges.t) - given.ranges.anchors.p_a[given.ranges.anchor], axis=1)
        seen.append(np.abs(given.ranges.distance - near).max())
        return np.where(t[:, None] < 0.55, np.nan, walk(t) + np.array([7.0, 0, 0]))

    results = benchmark_isas(folder, {"ours": method, "stuck": lambda given, t: np.zeros((len(t), 3))})
    assert seen[0] < 1e-12
    row = results["cases"]["Walk"]
    assert row["published"]["vendor"]["rmse_3d"] < 1e-3  # a constant offset is aligned away
    assert row["ours"]["rmse_3d"] < 1e-3 and "failed" not in row["ours"]
    assert row["ours"]["alignment_deg"] == pytest.approx(np.degrees(np.arccos((np.trace(TURN) - 1) / 2)), abs=0.1)
    assert (row["ours"]["unstarted"], row["ours"]["samples"]) == (6, 170)  # from 2 s on to 18.9 s
    assert row["ours"]["full_samples"] == 184
    assert "on a line" in row["stuck"]["failed"] and "on a line" in text_table(tables(results)[0][1])


def test_anchors_without_an_offset_are_named(folder, monkeypatch):
    monkeypatch.setattr(uwb_isas, "read_uwb_isas", lambda path: recording(("7475", "1", "2", "3")))
    assert benchmark_isas(folder, {})["without_offset"] == {"Walk": ["1", "2", "3"]}


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
def test_a_real_walk():
    pytest.importorskip("rosbags")

    def again(given, t):
        return given.estimates["vendor"].values[np.searchsorted(given.estimates["vendor"].t, t)]

    results = benchmark_isas(Path(DATA) / "uwb" / "isas_walk1", {"again": again})
    vendor = results["cases"]["ISAS-Walk1"]["published"]["vendor"]
    assert vendor["rmse_3d"] == pytest.approx(8.475, abs=0.005) and vendor["samples"] == 970
    assert results["without_offset"] == {"ISAS-Walk1": []}
    assert results["cases"]["ISAS-Walk1"]["again"]["samples"] == 913
