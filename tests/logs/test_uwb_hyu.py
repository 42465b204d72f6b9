"""The HYU outdoor set: static files and moving cases, their traps, and every way a file can be no such file."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.logs import read_uwb_hyu, read_uwb_hyu_static

DATA = os.environ.get("ROBUSTNAV_DATA")
HYU = Path(DATA or ".") / "uwb" / "hyu"
START = 1734501485_315057992  # ns

STATIC_HEAD = "timestamp,Transmission #,Distance,RSSI(dBm),RSSI_fp(dBm),anchor_id\n"
STATIC_ROWS = "1723710245.5,6653,10.17,-79.68,-80.71,12.0\n1723710245.75,6654,10.15,-inf,,12.0\n"
SUMMARY = "Distance Mean,10.1\nDistance Std,0.03\nRSSI(dBm) Mean,-79.9\n"


def static(folder, text=STATIC_HEAD + STATIC_ROWS + SUMMARY, name="height_150.0cm/10m.csv"):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return folder


def test_static_files_give_slant_distances_and_leave_the_means_out(tmp_path):
    static(tmp_path, STATIC_HEAD + STATIC_ROWS.replace("12.0\n", "12anchor_id: 12\n"), "height_50.0cm/2m.csv")
    static(tmp_path, STATIC_HEAD, "height_50.0cm/54m.csv")
    static(tmp_path, STATIC_HEAD + ",,,,,\n", "height_50.0cm/56m.csv")
    found = read_uwb_hyu_static(static(tmp_path))
    assert found.files == ("height_150.0cm/10m.csv", "height_50.0cm/2m.csv")
    np.testing.assert_allclose(found.distance_true, np.sqrt([100.25, 100.25, 4.25, 4.25]), rtol=1e-15)
    np.testing.assert_array_equal(found.measured, [10.17, 10.15, 10.17, 10.15])
    np.testing.assert_array_equal(found.file, [0, 0, 1, 1])
    np.testing.assert_array_equal(found.rssi_dbm, [-79.68, np.nan] * 2)
    np.testing.assert_array_equal(found.rssi_first_path_dbm, [-80.71, np.nan] * 2)
    assert set(found.anchor) == {"12"}
    assert found.origin_ns == 1723710245 * 10**9
    np.testing.assert_array_equal(found.t, [0.5, 0.75] * 2)
    assert found.skipped == (
        "height_150.0cm/10m.csv: 3 lines of means",
        "height_50.0cm/54m.csv: no data",
        "height_50.0cm/56m.csv: no data",
    )
    assert read_uwb_hyu_static(tmp_path / "height_150.0cm").files == ("height_150.0cm/10m.csv",)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (STATIC_HEAD + STATIC_ROWS + "Distance Median,1\n", "2 cells"),
        (STATIC_HEAD + STATIC_ROWS.replace("10.15", ""), "'Distance' line 3"),
        (STATIC_HEAD + STATIC_ROWS.replace("10.15", "ten"), "'ten'"),
        (STATIC_HEAD + STATIC_ROWS.replace("1723710245.75", "1723710245.25"), "never decrease"),
        (STATIC_HEAD + STATIC_ROWS.replace("1723710245.5", "-5"), "timestamp"),
        (STATIC_HEAD + STATIC_ROWS.replace(",12.0\n", ",12.5\n"), "'12.5'"),
        (STATIC_HEAD + STATIC_ROWS.replace(",12.0\n", ",12anchor_id: 13\n"), "number of an anchor"),
        (STATIC_HEAD.replace("Distance", "Range") + STATIC_ROWS, "'Distance'"),
        (b"\xff\xfe", "UTF-8"),
        (b"", "empty"),
    ],
)
def test_static_files_that_are_none_are_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        read_uwb_hyu_static(static(tmp_path, text))


def test_folders_without_static_ranges_are_refused(tmp_path):
    for folder in (tmp_path, tmp_path / "none"):
        with pytest.raises(InputError, match="no static ranges"):
            read_uwb_hyu_static(folder)
    with pytest.raises(InputError, match="without data"):
        read_uwb_hyu_static(static(tmp_path, STATIC_HEAD))


HEAD = "%time,field.stamp,field.id,field.x,field.y,field.z,field.distanceFromTag,field.rssi,field.rssi_fp\n"
GNSS_HEAD = (
    "field.header.stamp,field.status.status,field.latitude,field.longitude,field.altitude,"
    "field.position_covariance0,field.position_covariance4,field.position_covariance8\n"
)


def anchor_rows(number, place, start, distances):
    step = 100_000_000
    rows = [f"0,{start + step * k},{number},{place},{d},-80,-81" for k, d in enumerate(distances)]
    return HEAD + "\n".join(rows) + "\n"


CASE = {
    "A12.csv": anchor_rows(12, "0.69,0.87,0.5", START + 3, [6.0, 6.1]),
    "A3.csv": anchor_rows(3, "2.5,-0.87,1.97", START, [7.0, 7.1]),
    "trajectory.csv": "timestamp,x,y,z,heading_degrees\n"
    "1.7345014855003267e+18,1,2,0.5,90\n1.7345014856e+18,1,3,0,450\n",
    "gnss.csv": GNSS_HEAD
    + f"{START},2,37.5,127.0,50,0.0004,0.0001,0.0009\n{START + 5},0,37.5001,127.0002,49,0.0004,0.0001,0.0009\n",
    "LS.csv": f"timestamp,x,y,z\n{START},1,2,3\n",
    "ESKF.csv": f"timestamp,x,y,z\n{START + 7},4,5,6\n",
}


def case(folder, **changes):
    for name, text in {**CASE, **{k.replace("_", "."): v for k, v in changes.items()}}.items():
        if text is not None:
            (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return folder


def test_a_case_is_turned_to_z_down_and_put_in_time_order(tmp_path):
    found = read_uwb_hyu(case(tmp_path))
    ranges = found.ranges
    assert ranges.anchors.ids == ("3", "12")
    np.testing.assert_array_equal(ranges.anchors.p_a, [[2.5, 0.87, -1.97], [0.69, -0.87, -0.5]])
    np.testing.assert_array_equal(ranges.anchor, [0, 1, 0, 1])
    np.testing.assert_array_equal(ranges.distance, [7.0, 6.0, 7.1, 6.1])
    np.testing.assert_allclose(ranges.t, [0, 3e-9, 0.1, 0.1 + 3e-9], atol=1e-17)
    assert found.log.origin_ns == START
    position, course = found.reference["position"], found.reference["course"]
    np.testing.assert_array_equal(position.values, [[1, -2, -0.5], [1, -3, 0]])
    np.testing.assert_array_equal(
        found.log.origin_ns + np.round(position.t * 1e9), [1734501485500326656, 1.7345014856e18]
    )
    np.testing.assert_allclose(course.values[:, 0], [-np.pi / 2, -2.5 * np.pi])
    assert (position.frame, course.unit) == ("a", "rad")
    np.testing.assert_array_equal(found.estimates["ESKF"].values, [[4, -5, -6]])
    np.testing.assert_allclose(found.log.streams["gnss_sd"].values[0], [0.01, 0.02, 0.03])
    np.testing.assert_array_equal(found.log.streams["gnss_status"].values[:, 0], [2, 0])


def test_fixes_are_metres_north_east_down_of_the_first(tmp_path):
    gnss = read_uwb_hyu(case(tmp_path)).log.streams["gnss"].values
    np.testing.assert_array_equal(gnss[0], 0)

    def earth_fixed(latitude, longitude, height):
        f = 1 / 298.257223563
        e2, s, c = f * (2 - f), np.sin(latitude), np.cos(latitude)
        n = 6378137 / np.sqrt(1 - e2 * s * s)
        return np.array(
            [(n + height) * c * np.cos(longitude), (n + height) * c * np.sin(longitude), (n * (1 - e2) + height) * s]
        )

    latitude, longitude = np.radians([37.5, 127.0])
    difference = earth_fixed(*np.radians([37.5001, 127.0002]), 49) - earth_fixed(latitude, longitude, 50)
    north = [-np.sin(latitude) * np.cos(longitude), -np.sin(latitude) * np.sin(longitude), np.cos(latitude)]
    east = [-np.sin(longitude), np.cos(longitude), 0]
    np.testing.assert_allclose(gnss[1], [difference @ north, difference @ east, 1.0], atol=1e-3)


def test_what_may_be_missing_is_named(tmp_path):
    found = read_uwb_hyu(case(tmp_path, gnss_csv=None, ESKF_csv=None))
    assert found.log.skipped == ("gnss.csv: not there", "ESKF.csv: not there")
    assert (dict(found.log.streams), list(found.estimates)) == ({}, ["LS"])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"trajectory_csv": None}, "trajectory"),
        ({"A3_csv": CASE["A3.csv"].replace(",3,", ",4,", 1)}, "'field.id' line 2"),
        ({"A3_csv": CASE["A3.csv"].replace("-0.87", "-0.88", 1)}, "one place"),
        ({"A3_csv": CASE["A3.csv"].replace("7.1", "nan")}, "'field.distanceFromTag' line 3"),
        ({"A3_csv": CASE["A3.csv"].replace(str(START), str(START + 10**9))}, "never decrease"),
        ({"A3_csv": CASE["A3.csv"].replace(str(START), "1e300")}, "1970"),
        ({"A3_csv": CASE["A3.csv"].replace(str(START), "soon")}, "'soon'"),
        ({"A3_csv": HEAD}, "at least one row"),
        ({"A3_csv": b"\xff"}, "UTF-8"),
        ({"trajectory_csv": "timestamp,x,y\n1,2,3\n"}, "heading_degrees"),
        ({"gnss_csv": CASE["gnss.csv"].replace("37.5,", "97.5,")}, "on the Earth"),
        ({"gnss_csv": CASE["gnss.csv"].replace("0.0009", "-1")}, "variance"),
        ({"LS_csv": CASE["LS.csv"].replace(",3\n", ",\n")}, "'z' line 2"),
    ],
)
def test_cases_that_are_none_are_refused(tmp_path, changes, words):
    with pytest.raises(InputError, match=words):
        read_uwb_hyu(case(tmp_path, **changes))


def test_a_folder_without_anchors_is_refused(tmp_path):
    with pytest.raises(InputError, match="no ranges"):
        read_uwb_hyu(tmp_path)


def damaged(data, text):
    raw = text.encode()
    at, size = data.draw(st.integers(0, len(raw))), data.draw(st.integers(0, 20))
    return (
        raw[:at]
        + data.draw(st.binary(max_size=8) | st.sampled_from([b"1e999", b"_", b"\r\n", b'"', b"-inf", b","]))
        + raw[at + size :]
    )


@given(st.data())
def test_damaged_tables_are_read_or_refused(tmp_path_factory, data):
    folder = tmp_path_factory.getbasetemp() / "hyu_case"
    folder.mkdir(exist_ok=True)
    name = data.draw(st.sampled_from(sorted(CASE)))
    try:
        found = read_uwb_hyu(case(folder, **{name.replace(".", "_"): damaged(data, CASE[name])}))
        assert len(found.ranges) >= 1
    except InputError as why:
        assert why.got or why.expected
    folder = static(tmp_path_factory.getbasetemp() / "hyu_static", damaged(data, STATIC_HEAD + STATIC_ROWS + SUMMARY))
    try:
        assert np.isfinite(read_uwb_hyu_static(folder).measured).all()
    except InputError as why:
        assert why.got or why.expected


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
def test_the_real_static_files():
    found = read_uwb_hyu_static(HYU / "static" / "LOS")
    heights = [name.split("/")[0] for name in found.files]
    counts = {h: int(np.isin(found.file, [k for k, one in enumerate(heights) if one == h]).sum()) for h in set(heights)}
    assert counts == {"height_50.0cm": 2689, "height_75.0cm": 2686, "height_100.0cm": 2686, "height_150.0cm": 2509}
    assert [s for s in found.skipped if "no data" in s] == [
        "height_150.0cm/54m.csv: no data",
        "height_150.0cm/56m.csv: no data",
    ]
    steps = np.diff(found.measured[found.file == 0])
    np.testing.assert_allclose(steps / 0.01876, np.round(steps / 0.01876), atol=0.02)  # four ticks of the radio's clock


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
@pytest.mark.parametrize(
    ("name", "count", "azimuth"), [("Trajectory_A/Case_1", 8405, 109.4), ("Trajectory_B/Case_3", 6645, 109.2)]
)
def test_a_real_case_and_its_gnss_agree_on_what_is_down(name, count, azimuth):
    found = read_uwb_hyu(HYU / "dynamic" / "LOS" / name)
    assert len(found.ranges) == count
    truth, gnss = found.reference["position"], found.log.streams["gnss"]
    p = np.column_stack([np.interp(gnss.t, truth.t, truth.values[:, k]) for k in range(3)])
    p, n = p - p.mean(axis=0), gnss.values - gnss.values.mean(axis=0)
    turn = np.degrees(np.arctan2(np.sum(p[:, 0] * n[:, 1] - p[:, 1] * n[:, 0]), np.sum(p[:, :2] * n[:, :2])))
    np.testing.assert_allclose(turn, azimuth, atol=0.3)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    error = n - p @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    assert np.sqrt((error[:, :2] ** 2).sum(axis=1).mean()) < 0.25  # the reference was moved 0.185 m forward
    assert np.abs(error[:, 2]).max() < 0.05
    step = np.diff(truth.values[::8, :2], axis=0)
    moving = np.linalg.norm(step, axis=1) > 0.8
    course = np.interp(truth.t[4::8][: len(step)], truth.t, found.reference["course"].values[:, 0])
    off = np.arctan2(step[:, 1], step[:, 0]) - course
    assert np.median(np.abs(np.angle(np.exp(1j * off[moving])))) < 0.1
