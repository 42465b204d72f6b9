"""The ranging verbs: exit codes, one JSON document, files that other verbs read, errors without tracebacks."""

import json
import os
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robustnav.calibrate import read_calibration
from robustnav.cli import main
from robustnav.cli.ranging_files import numbers_by_name, read_survey_ranges, read_true_ranges
from robustnav.errors import InputError
from robustnav.logs.uwb_survey import read_survey

DATA = os.environ.get("ROBUSTNAV_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="ROBUSTNAV_DATA does not name a folder with recordings")
HALL = np.array([[0, 0, 0], [8, 0, 0], [7, 6, 0], [1, 5, -2.5], [4, 3, -3], [0, 6, -0.5]], float)
ROOM = 'z = "up"\n' + "".join(
    f'[[anchor]]\nid = "A{k}"\nx_m = {x}\ny_m = {y}\nz_m = {z}\n'
    for k, (x, y, z) in enumerate([(0, 0, 2.5), (10, 0, 2.4), (10, 8, 2.5), (0, 8, 2.5), (5, 0, 0.3)])
)


def links_csv(p, sd=0.01, fault=None):
    rng = np.random.default_rng(2)
    rows = ["from,to,distance_m"]
    for k, (i, j) in enumerate(combinations(range(len(p)), 2)):
        d = np.linalg.norm(p[i] - p[j]) + sd * rng.standard_normal() + (0.5 if k == fault else 0.0)
        rows.append(f"{'ABCDEF'[i]},{'ABCDEF'[j]},{d}")
    return "\n".join([*rows, "A,B,"]) + "\n"


def true_csv(slope=1.01, offset=0.05, seed=0, anchors=("a", "b")):
    rng = np.random.default_rng(seed)
    rows = ["anchor,distance_true_m,distance_m"]
    for n, anchor in enumerate(anchors):
        d = np.linspace(2 + seed, 30 + seed, 25)
        r = slope * d + offset + 0.1 * n + 0.02 * rng.standard_normal(d.size)
        rows += [f"{anchor},{true},{measured}" for true, measured in zip(d, r, strict=True)]
    return "\n".join(rows) + "\n"


def run(arguments, capsys, code=0):
    assert main([str(a) for a in arguments]) == code
    shown = capsys.readouterr()
    assert "Traceback" not in shown.err
    return shown


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "room.toml").write_text(ROOM)
    (tmp_path / "links.csv").write_text(links_csv(HALL))
    for k in range(4):
        (tmp_path / f"true_{k}.csv").write_text(true_csv(seed=k))
    return tmp_path


def test_calibrate_writes_what_a_run_takes(folder, capsys):
    files = [folder / f"true_{k}.csv" for k in range(4)]
    out = folder / "c.toml"
    told = json.loads(run(["calibrate", "uwb", *files, "--per", "anchor", "--out", out, "--json"], capsys).out)
    rows = {row["for"]: row for row in told["corrections"]}
    assert set(rows) == {"a", "b"}
    for name, offset in (("a", 0.05), ("b", 0.15)):
        assert rows[name]["slope_interval"][0] < 1.01 < rows[name]["slope_interval"][1]
        assert rows[name]["offset_m"] == pytest.approx(offset, abs=0.02)
        assert rows[name]["held_out_rms_m"] == pytest.approx(0.02, rel=0.2)
        assert rows[name]["raw_rms_m"] > 0.1
        assert rows[name]["distance_variance_m2"] == pytest.approx(rows[name]["range_variance_m2"] / 1.01**2, rel=1e-2)
    back = read_calibration(out)
    assert back.by == "anchor" and back.corrections[("a",)].slope == rows["a"]["slope"]


def test_calibrate_by_least_squares_and_by_curve(folder, capsys):
    files = [folder / f"true_{k}.csv" for k in range(4)]
    table = run(["calibrate", "uwb", *files, "--ols"], capsys)
    assert "Slope a" in table.out and "R m²" in table.out and "next:" in table.err
    assert json.loads(run(["calibrate", "uwb", *files, "--ols", "--json"], capsys).out)["loss"] == "least_squares"
    curve = json.loads(run(["calibrate", "uwb", *files, "--curve", "--json"], capsys).out)["corrections"][0]
    assert len(curve["knots_m"]) == len(curve["bias_m"]) >= 2


def test_one_table_has_independent_readings_and_says_so(folder, capsys):
    shown = run(["calibrate", "uwb", folder / "true_0.csv"], capsys)
    assert "independent readings" in shown.err
    told = json.loads(run(["calibrate", "uwb", folder / "true_0.csv", "--json"], capsys).out)
    assert told["corrections"][0]["held_out_rms_m"] is None


def test_gdop_judges_a_room(folder, capsys):
    told = json.loads(run(["gdop", folder / "room.toml", "--height", "1", "--grid", "1", "--json"], capsys).out)
    assert told["verdict"]["level"] == "ok" and told["height_m"] == 1.0
    rows = {row["map"]: row for row in told["maps"]}
    assert rows["GDOP"]["median"] == pytest.approx(2.12, abs=0.05)
    assert rows["GDOP, worst anchor missing"]["worst"] > rows["GDOP"]["worst"]
    known = json.loads(
        run(["gdop", folder / "room.toml", "--height", "1", "--grid", "1", "--known-height", "--json"], capsys).out
    )
    assert "VDOP" not in {row["map"] for row in known["maps"]}
    assert "One more anchor" in run(["gdop", folder / "room.toml", "--height", "1", "--grid", "1"], capsys).out


def test_gdop_of_a_blind_map_is_still_json(folder, capsys):
    flat = ROOM.replace("z_m = 2.4", "z_m = 2.5").rsplit("[[anchor]]", 1)[0]
    (folder / "flat.toml").write_text(flat)
    told = json.loads(run(["gdop", folder / "flat.toml", "--height", "2.5", "--grid", "2", "--json"], capsys).out)
    assert told["verdict"]["level"] == "error" and told["maps"][0]["worst"] is None
    assert told["maps"][0]["blind_percent"] == 100


def test_survey_writes_anchors_that_are_read_back(folder, capsys):
    out = folder / "anchors.toml"
    asked = ["survey", folder / "links.csv", "--sd", "0.01", "--side", "E:-z", "--out", out]
    shown = run(asked, capsys)
    assert shown.out.startswith("unique") and "1 rows without a distance" in shown.err
    anchors = read_survey(out)[0]
    assert anchors.ids == tuple("ABCDEF")
    np.testing.assert_allclose(anchors.p_a, HALL, atol=0.15)
    told = json.loads(run([*asked, "--json"], capsys).out)
    assert told["verdict"] == "unique" and told["weakest"]["sd_m"] < 0.1
    known = run(["survey", folder / "links.csv", "--sd", "0.01", "--known", out, "--json"], capsys)
    assert json.loads(known.out)["verdict"] == "unique"


def test_survey_of_mirror_images_gives_both_and_writes_nothing(folder, capsys):
    out = folder / "anchors.toml"
    shown = run(["survey", folder / "links.csv", "--sd", "0.01", "--out", out], capsys, code=3)
    assert shown.out.startswith("ambiguous") and "Or 1 x, m" in shown.out
    assert not out.exists() and "no anchors written" in shown.err


def test_survey_with_heights_and_a_wrong_range(folder, capsys):
    flat = HALL * [1, 1, 0] + [0, 0, -2.0]
    (folder / "flat.csv").write_text(links_csv(flat, fault=7))
    told = run(["survey", folder / "flat.csv", "--sd", "0.01", "--heights", "2.0", "--json"], capsys, code=3)
    found = json.loads(told.out)
    assert found["verdict"] == "inconsistent" and found["suspects"][0]["ends"] == "B - E"
    one_by_one = ",".join(f"{name}=2.0" for name in "ABCDEF")
    again = run(["survey", folder / "flat.csv", "--sd", "0.01", "--heights", one_by_one, "--json"], capsys, code=3)
    assert json.loads(again.out) == found


BAD = [
    (["calibrate", "uwb", "{tmp}/none.csv"], "check the path"),
    (["calibrate", "uwb", "{tmp}"], "no static ranges"),
    (["calibrate", "uwb", "{tmp}/links.csv"], "column 'from'"),
    (["calibrate", "uwb", "{tmp}/true_0.csv", "--per", "link"], "without tag"),
    (["calibrate", "uwb", "{tmp}/true_0.csv", "--curve"], "files"),
    (["gdop", "{tmp}/room.toml", "--height", "1", "--box", "1,2,3"], "four numbers"),
    (["gdop", "{tmp}/room.toml", "--height", "1", "--box", "1,a,3,4"], "four numbers"),
    (["gdop", "{tmp}/room.toml", "--height", "1", "--grid", "0"], "grid"),
    (["gdop", "{tmp}/links.csv", "--height", "1"], "TOML"),
    (["survey", "{tmp}/links.csv", "--sd", "0"], "--sd"),
    (["survey", "{tmp}/true_0.csv", "--sd", "0.1"], "distance_true_m"),
    (["survey", "{tmp}/links.csv", "--sd", "0.1", "--side", "E:up"], "+z or -z"),
    (["survey", "{tmp}/links.csv", "--sd", "0.1", "--frame", "A,B"], "three anchors"),
    (["survey", "{tmp}/links.csv", "--sd", "0.1", "--heights", "X=1"], "one of A, B"),
    (["survey", "{tmp}/links.csv", "--sd", "0.1", "--heights", "high"], "a number"),
    (["survey", "{tmp}/links.csv", "--sd", "0.1", "--heights", "A=tall"], "names and numbers"),
]


@pytest.mark.parametrize(("arguments", "words"), BAD)
def test_bad_input_is_one_clear_error_and_exit_2(arguments, words, folder, capsys):
    shown = run([a.format(tmp=folder) for a in arguments], capsys, code=2)
    assert words in shown.err and not shown.out


def test_files_must_agree_on_what_they_tell(folder):
    (folder / "bare.csv").write_text("distance_true_m,distance_m\n1,1.1\n2,2.1\n")
    with pytest.raises(InputError, match="no anchor told"):
        read_true_ranges([folder / "true_0.csv", folder / "bare.csv"])
    for name in ("t1.csv", "t2.csv"):
        (folder / name).write_text("t_s,anchor,distance_m\n0,A,1.0\n")
    with pytest.raises(InputError, match="2 tables with t_s"):
        read_survey_ranges([folder / "t1.csv", folder / "t2.csv"], (), 0.1)


def test_links_and_tag_together_keep_the_known_ids_first(folder):
    (folder / "tag.csv").write_text("t_s,anchor,distance_m,sd_m\n5.0,Z,1.0,0.2\n5.5,A,,0.2\n6.0,A,2.0,0.3\n")
    measured, notes = read_survey_ranges([folder / "links.csv", folder / "tag.csv"], ("F", "Q"), 0.1)
    assert measured.ids[:2] == ("F", "Q") and set(measured.ids) == set("FQABCDEZ")
    np.testing.assert_array_equal(measured.tag.t, [0.0, 1.0])
    np.testing.assert_array_equal(measured.tag.sd, [0.2, 0.3])
    np.testing.assert_array_equal(measured.links.sd, 0.1)
    assert len(notes) == 2


@settings(deadline=None, max_examples=120, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_damaged_tables_are_read_or_refused(folder, data):
    which = data.draw(st.sampled_from(["links", "tag", "true"]))
    good = {"links": links_csv(HALL[:4]), "tag": "t_s,anchor,distance_m\n0,A,1.5\n0,B,2.5\n1,A,\n", "true": true_csv()}
    raw = good[which].encode()[:400]
    at, size = data.draw(st.integers(0, len(raw))), data.draw(st.integers(0, 9))
    middle = data.draw(st.binary(max_size=5) | st.sampled_from([b"1e999", b"nan", b"\n", b'"', b"-1", b",,", b"inf"]))
    path = folder / "spoiled.csv"
    path.write_bytes(raw[:at] + middle + raw[at + size :])
    try:
        if which == "true":
            assert np.isfinite(read_true_ranges([path]).pairs.measured).all()
        else:
            read_survey_ranges([path], (), 0.1)
    except InputError as why:
        assert why.got or why.expected


@given(st.text(max_size=20))
def test_numbers_by_name_are_read_or_refused(text):
    try:
        assert all(np.isfinite(v) for v in numbers_by_name(text, "--heights").values())
    except InputError as why:
        assert "A=2.0" in why.expected


@needs_data
def test_the_outdoor_set_gives_the_published_line(capsys):
    folder = Path(DATA) / "uwb" / "hyu" / "static" / "LOS"
    told = json.loads(run(["calibrate", "uwb", folder, "--ols", "--json"], capsys).out)["corrections"][0]
    np.testing.assert_allclose([told["slope"], told["offset_m"]], [1.004464, 0.075158], atol=6e-7)
    np.testing.assert_allclose(told["held_out_rms_m"], 0.067, atol=1e-3)
