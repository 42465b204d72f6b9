"""The LIAS benchmark: poses from made ranges, files side by side, the reference figures on the real set."""

import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.benchmark.lias_pose import planar_poses
from robustnav.benchmark.uwb_lias import SHEET, benchmark_lias, default_methods, lias_cases, tables
from robustnav.errors import InputError
from robustnav.evaluate.tables import text_table
from robustnav.frames import wrap_angle
from robustnav.logs.uwb_lias import ANCHORS, LEVER_B, TAGS
from robustnav.records import Ranges

DATA = os.environ.get("ROBUSTNAV_DATA")
HEIGHT = -0.97


def made(n=60, sd=0.0):
    rng = np.random.default_rng(8)
    t = np.repeat(np.arange(n) * 0.01, 24)
    anchor, tag = np.tile(np.repeat(np.arange(8), 3), n), np.tile(np.arange(3), 8 * n)
    xy, yaw = rng.uniform(-2, 2, (n, 2)), rng.uniform(-np.pi, np.pi, n)
    c, s = np.cos(yaw), np.sin(yaw)
    C = np.moveaxis(np.array([[c, -s, 0 * c], [s, c, 0 * c], [0 * c, 0 * c, 1 + 0 * c]]), -1, 0)
    centre = np.column_stack([xy, np.full(n, HEIGHT)])
    at = np.repeat(centre, 24, axis=0) + np.einsum("nij,tj->nti", C, np.tile(LEVER_B, (8, 1))).reshape(-1, 3)
    distance = np.linalg.norm(at - ANCHORS.p_a[anchor], axis=1) + sd * rng.standard_normal(24 * n)
    return Ranges(t, anchor, tag, distance, ANCHORS, TAGS, LEVER_B), xy, yaw


def test_poses_are_found_from_any_place_and_heading():
    ranges, xy, yaw = made()
    found = planar_poses(ranges, HEIGHT)
    np.testing.assert_allclose(found.xy, xy, atol=1e-6)
    np.testing.assert_allclose(wrap_angle(found.yaw - yaw), 0, atol=1e-5)
    few = planar_poses(ranges, HEIGHT, every=7)
    np.testing.assert_allclose(few.t, found.t[::7])
    np.testing.assert_allclose(few.xy, xy[::7], atol=1e-6)


def test_a_pose_is_a_minimum_of_the_squared_residuals():
    ranges, _, _ = made(n=3, sd=0.03)
    found = planar_poses(ranges, HEIGHT)

    def cost(k, x, y, yaw):
        c, s = np.cos(yaw), np.sin(yaw)
        tag = [x, y, HEIGHT] + LEVER_B @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        here = slice(24 * k, 24 * (k + 1))
        d = np.linalg.norm(tag[ranges.tag[here]] - ANCHORS.p_a[ranges.anchor[here]], axis=1)
        return np.sum((ranges.distance[here] - d) ** 2)

    for k in range(3):
        pose = np.array([*found.xy[k], found.yaw[k]])
        for step in 1e-3 * np.vstack([np.eye(3), -np.eye(3)]):
            assert cost(k, *(pose + step)) > cost(k, *pose)


def test_missing_links_are_left_out_and_too_few_give_nothing():
    ranges, xy, _ = made()
    keep = np.ones(len(ranges), bool)
    keep[[1, 5, 20]] = False
    keep[24:45] = False
    found = planar_poses(ranges.where(keep), HEIGHT)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(found.yaw)), [1])
    np.testing.assert_allclose(found.xy[[0, 2]], xy[[0, 2]], atol=1e-6)


def test_four_headings_find_minima_that_one_misses(monkeypatch):
    ranges, _, yaw = made(n=1000, sd=0.1)
    ranges = ranges.where(np.random.default_rng(0).random(len(ranges)) < 0.25)

    def turned_around():
        found = planar_poses(ranges, HEIGHT)
        true = yaw[np.round(found.t * 100).astype(int)]
        return np.count_nonzero(np.abs(wrap_angle(found.yaw - true)) > np.pi / 2)

    of_four = turned_around()
    monkeypatch.setattr("robustnav.benchmark.lias_pose.HEADINGS", np.zeros(1))
    assert 1.3 * of_four < turned_around()


def test_poses_need_lever_arms_and_ranges():
    ranges, _, _ = made(n=1)
    bare = Ranges(ranges.t, ranges.anchor, ranges.tag, ranges.distance, ANCHORS, TAGS)
    for bad, every in ((bare, 1), (ranges.where(np.zeros(24, bool)), 1), (ranges, 0)):
        with pytest.raises(InputError, match="planar pose"):
            planar_poses(bad, HEIGHT, every)


def files(folder, name="slow"):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"UWB_{name}.csv").write_text("x")
    (folder / f"motion_capture_{name}.csv").write_text("x")
    return folder


def test_sets_are_found_by_their_files(tmp_path):
    for place in (tmp_path, tmp_path / "none"):
        with pytest.raises(InputError, match="no LIAS sets"):
            lias_cases(place)
    files(tmp_path / "b", "exp_fast")
    files(tmp_path / "a", "exp_mid")
    assert list(lias_cases(tmp_path)) == ["exp_mid", "exp_fast"]
    assert list(default_methods(tmp_path)) == ["least-squares-raw"]
    (tmp_path / "a" / "motion_capture_exp_mid.csv").unlink()
    with pytest.raises(InputError, match="motion_capture_exp_mid"):
        lias_cases(tmp_path)
    files(tmp_path / "a", "exp_fast")
    (tmp_path / "a" / "UWB_exp_mid.csv").unlink()
    with pytest.raises(InputError, match="set exp_fast twice"):
        lias_cases(tmp_path)


def test_two_sheets_are_refused(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / SHEET).write_text("tag")
    with pytest.raises(InputError, match="2 calibration"):
        default_methods(tmp_path)


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
def test_the_real_set_gives_the_reference_figures():
    results = benchmark_lias(Path(DATA) / "uwb" / "lias_mid")
    row = results["cases"]["dynamic_exp_mid"]
    assert row["published"] == {}
    raw, sheets = row["least-squares-raw"], row["least-squares"]
    assert raw["rmse_2d"] == pytest.approx(0.154, abs=5e-4) and raw["yaw_rmse_deg"] == pytest.approx(5.3, abs=0.1)
    assert sheets["rmse_2d"] == pytest.approx(0.034, abs=5e-4) and sheets["yaw_rmse_deg"] == pytest.approx(4.4, abs=0.1)
    assert sheets["samples"] == 1281 and "failed" not in sheets
    assert "Heading, deg" in text_table(tables(results)[0][1])
