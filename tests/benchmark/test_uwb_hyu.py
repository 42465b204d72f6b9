"""The HYU benchmark on made cases: finding them, every method, failures beside successes, the printed figures."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from cyclopts import App
from hypothesis import given
from hypothesis import strategies as st

from robustnav.benchmark.hyu_cases import PRINTED, hyu_cases, printed_figures
from robustnav.benchmark.uwb_hyu import METRIC, benchmark_hyu, tables
from robustnav.cli.uwb_benchmarks import COMMANDS
from robustnav.errors import EstimatorError, InputError
from robustnav.evaluate.tables import plain, text_table

DATA = os.environ.get("ROBUSTNAV_DATA")
HYU = Path(DATA or ".") / "uwb" / "hyu"
START = 1734501485_000000000
ANCHORS = {3: (2.5, 0.8, 1.9), 5: (2.5, -0.8, 2.0), 9: (-2.5, -0.8, 0.5), 12: (0.6, 0.8, 0.4)}
ANCHOR_HEAD = "%time,field.stamp,field.id,field.x,field.y,field.z,field.distanceFromTag,field.rssi,field.rssi_fp\n"
RATE_HZ = 4


def table(head, stamps, values):
    rows = (",".join([str(s), *map(repr, row)]) for s, row in zip(stamps.tolist(), values.tolist(), strict=True))
    return head + "\n".join(rows) + "\n"


def made_case(folder, *, ls=0.5, skip=()):
    """A run on trajectory A in 20 s; LS is off by ``ls`` north and up, ESKF by 1 m in x."""
    folder.mkdir(parents=True)
    t = np.arange(20 * RATE_HZ) / RATE_HZ
    share = t / 10
    xyz = np.column_stack([np.interp(share, [0, 1, 2], [-2, 55, -2]), np.where(share < 1, -4.0, 5.0), 0 * t])
    stamps = START + (t * 1e9).astype(np.int64)
    tag = xyz + np.array([0, 0, 1.0])
    files = {
        "trajectory.csv": table("timestamp,x,y,z,heading_degrees\n", stamps, np.column_stack([xyz, 0 * t])),
        "LS.csv": table("timestamp,x,y,z\n", stamps, tag + np.array([0, ls, ls])),
        "ESKF.csv": table("timestamp,x,y,z\n", stamps + 1000, tag + np.array([1.0, 0, 0])),
    }
    for number, anchor in ANCHORS.items():
        d = np.linalg.norm(tag - anchor, axis=1).tolist()
        place = ",".join(map(str, anchor))
        rows = [f"0,{s},{number},{place},{one!r},-80,-81" for s, one in zip(stamps.tolist(), d, strict=True)]
        files[f"A{number}.csv"] = ANCHOR_HEAD + "\n".join(rows) + "\n"
    for name in set(files) - set(skip):
        (folder / name).write_text(files[name])
    return folder


def perfect(recording, t):
    position = recording.reference["position"]
    return np.column_stack([np.interp(t, position.t, c) for c in position.values.T]) + np.array([0, 0, -1.0])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    top = tmp_path_factory.mktemp("hyu")
    made_case(top / "deep" / "LOS" / "Trajectory_A" / "Case_1")
    made_case(top / "NLOS" / "trajectory-a" / "Case_2", ls=1.5)
    return top


@pytest.mark.parametrize("below", ["", "deep/LOS", "deep/LOS/Trajectory_A", "deep/LOS/Trajectory_A/Case_1"])
def test_cases_are_found_wherever_the_folder_begins(folder, below):
    found = hyu_cases(folder / below)
    assert set(found) == {"LOS/Trajectory_A/Case_1"} | (set() if below else {"NLOS/trajectory-a/Case_2"})
    assert {case.trajectory for case in found.values()} == {"A"}


def test_a_case_in_the_working_folder_is_found(folder, monkeypatch):
    monkeypatch.chdir(folder / "deep/LOS/Trajectory_A/Case_1")
    assert list(hyu_cases(".")) == ["LOS/Trajectory_A/Case_1"]


def test_the_nearest_trajectory_counts(tmp_path):
    made_case(tmp_path / "Trajectory_A" / "Trajectory_B_copy" / "Case_3")
    (case,) = hyu_cases(tmp_path).values()
    assert case.trajectory == "B"


def test_folders_that_hold_no_case_are_refused(tmp_path):
    with pytest.raises(InputError, match="no HYU cases") as error:
        hyu_cases(tmp_path / "nowhere")
    assert "no such" in str(error.value) and "Case_1" in str(error.value)
    (tmp_path / "10m.csv").write_text("static")
    with pytest.raises(InputError, match="none in it"):
        hyu_cases(tmp_path)
    made_case(tmp_path / "first" / "Case_1")
    with pytest.raises(InputError, match="Trajectory_A or Trajectory_B"):
        hyu_cases(tmp_path)


def test_a_case_given_twice_is_refused(tmp_path):
    for copy in ("one", "two"):
        made_case(tmp_path / copy / "LOS" / "Trajectory_A" / "Case_1")
    with pytest.raises(InputError, match=r"LOS/Trajectory_A/Case_1 twice"):
        hyu_cases(tmp_path)


def test_what_a_case_needs_is_named(tmp_path):
    place = made_case(tmp_path / "Trajectory_A" / "Case_1", skip=["ESKF.csv"])
    with pytest.raises(InputError, match=r"no ESKF\.csv"):
        benchmark_hyu(tmp_path, {})
    (place / "trajectory.csv").unlink()
    with pytest.raises(InputError, match=r"trajectory\.csv"):
        benchmark_hyu(tmp_path, {})


def test_published_and_ours_stand_side_by_side(folder):
    steps = []
    results = benchmark_hyu(folder, {"perfect": perfect, "same": perfect}, progress=lambda: steps.append(1))
    assert len(steps) == 4
    assert list(results["cases"]) == ["NLOS/trajectory-a/Case_2", "LOS/Trajectory_A/Case_1"]
    row = results["cases"]["LOS/Trajectory_A/Case_1"]
    assert list(row) == ["published", "perfect", "same"]
    ls, eskf = row["published"]["ls"], row["published"]["eskf"]
    assert ls["rmse_2d"] == pytest.approx(0.5, abs=1e-4)
    assert ls["rmse_3d"] == ls["full_rmse_3d"] == pytest.approx(np.sqrt(0.5), abs=1e-4)
    assert (eskf["rmse_2d"], eskf["full_samples"]) == (pytest.approx(1.0, abs=1e-4), 79)  # one is after the reference
    assert 20 < eskf["samples"] < 60 and row["perfect"]["rmse_3d"] < 1e-4
    assert isinstance(eskf["samples"], int)
    assert results["means"]["published ls"]["rmse_2d"] == pytest.approx(1.0, abs=1e-4)
    assert results["means"]["perfect"]["cases"] == 2
    shown = "\n".join(text_table(rows) for _, rows in tables(results))
    assert "published eskf" in shown and "perfect" in shown and "Full 3D, m" in shown
    assert json.loads(json.dumps(plain(results), allow_nan=False))["trajectories"]["NLOS/trajectory-a/Case_2"] == "A"


def fails(recording, t):
    raise EstimatorError("the filter broke")


def forgets(recording, t):
    out = perfect(recording, t)
    out[:3] = np.nan
    out[40] = np.nan
    return out


@pytest.mark.parametrize(
    ("method", "words"),
    [
        (fails, "the filter broke"),
        (forgets, "1 estimates are NaN"),
        (lambda recording, t: np.full((len(t), 3), np.nan), "no estimate to score"),
        (lambda recording, t: np.zeros((2, 3)), "positions of a method"),
    ],
)
def test_a_method_that_fails_is_reported_and_spoils_its_mean(folder, method, words):
    results = benchmark_hyu(folder, {"bad": method, "good": perfect})
    row = results["cases"]["LOS/Trajectory_A/Case_1"]
    assert words in row["bad"]["failed"] and "failed" not in row["good"]
    assert np.isnan(results["means"]["bad"]["full_rmse_3d"]) and results["means"]["bad"]["failed"] == 2
    assert np.isfinite(results["means"]["good"]["full_rmse_3d"])
    assert words in text_table(tables(results)[0][1])


def test_starting_late_is_counted_and_no_failure(folder):
    def late(recording, t):
        return np.where(np.arange(len(t))[:, None] < 3, np.nan, perfect(recording, t))

    row = benchmark_hyu(folder, {"late": late})["cases"]["LOS/Trajectory_A/Case_1"]["late"]
    assert (row["full_unstarted"], row["full_samples"], row["unstarted"]) == (3, 76, 0)
    assert "failed" not in row


def test_the_printed_figures_are_checked(tmp_path):
    place = made_case(tmp_path / "Trajectory_A" / "Case_1")
    assert printed_figures(place) == {}
    (place / PRINTED).write_text("LS RMSE: 0.75 m\nLS RMSE_2d: 0.5\n\nESKF RMSE: 1.0 m\n")
    printed = benchmark_hyu(tmp_path, {})["printed"]["Trajectory_A/Case_1"]
    assert printed["ls"] == {"rmse_3d": 0.75, "rmse_2d": 0.5} and printed["eskf"] == {"rmse_3d": 1.0}
    assert printed["difference_m"] == pytest.approx(0.75 - np.sqrt(0.5), abs=1e-3)
    for text in ("LS RMSE: much\n", "\xff", "LS RMSE: nan", ""):
        (place / PRINTED).write_bytes(text.encode("latin-1"))
        with pytest.raises(InputError, match="RMSD_results"):
            printed_figures(place)


@given(st.text(max_size=60) | st.from_regex(r"(LS|ESKF) RMSE(_2d)?: [0-9.e_]{1,20}( m)?", fullmatch=True))
def test_any_text_is_read_or_refused(tmp_path_factory, text):
    place = tmp_path_factory.getbasetemp() / "printed"
    place.mkdir(exist_ok=True)
    (place / PRINTED).write_text(text, encoding="utf-8", errors="replace")
    try:
        assert all(np.isfinite(v) for row in printed_figures(place).values() for v in row.values())
    except InputError as why:
        assert why.expected


def command(capsys, *arguments):
    app = App(result_action="return_value")
    for one in COMMANDS:
        app.command(one)
    app(list(arguments))
    return capsys.readouterr()


def test_the_command_prints_tables_or_one_document(folder, capsys, monkeypatch):
    monkeypatch.setattr("robustnav.benchmark.hyu_methods.hyu_methods", lambda: {"perfect": perfect})
    shown = command(capsys, "uwb-hyu", str(folder))
    assert "published ls" in shown.out and "perfect" in shown.out and "authors' metric" in shown.err
    told = json.loads(command(capsys, "uwb-hyu", str(folder), "--json", "--quiet").out)
    figures = told["cases"]["LOS/Trajectory_A/Case_1"]["perfect"]
    assert {"rmse_2d", "rmse_3d", "full_rmse_2d", "full_rmse_3d", "samples", "full_samples"} <= figures.keys()
    with pytest.raises(InputError, match="no HYU cases"):
        command(capsys, "uwb-hyu", str(folder / "nowhere"))


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
def test_the_real_cases_agree_with_what_their_authors_printed():
    results = benchmark_hyu(HYU, {"perfect": perfect})
    assert results["trajectories"] == {"LOS/Trajectory_A/Case_1": "A", "LOS/Trajectory_B/Case_3": "B"}
    assert max(row["difference_m"] for row in results["printed"].values()) < 1e-12
    for row in results["cases"].values():
        assert "failed" not in row["perfect"] and row["perfect"]["full_rmse_3d"] < 0.02
    mean = results["means"]["published eskf"]
    assert mean["rmse_3d"] == pytest.approx((1.3352360382795463 + 0.7942606204304918) / 2, abs=1e-12)
    assert results["metric"] == METRIC
