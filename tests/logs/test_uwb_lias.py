"""The trolley of the LIAS group: columns by anchor, sheets by tag, a body that is already z down."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.frames import euler_from_quat
from robustnav.logs import read_uwb_lias, read_uwb_lias_sheet

DATA = os.environ.get("ROBUSTNAV_DATA")
LIAS = Path(DATA or ".") / "uwb" / "lias_mid"
ROW = "2022-08-15 9:37:27.039," + ",".join(f"{k // 3}.{k % 3}1" for k in range(24)) + "\n"
ROWS = ROW + ROW.replace("27.039", "27.049").replace(",7.01,7.11,7.21", ",,,")
CAPTURE = "time,x,y,z,rotation,,,\n2022-08-15 9:37:26.039,1,2,0.96,0,0.8,0.6,0\n"
SHEET = "tag,anchor,slope,bias_m,sigma_m\n0,0,0.01,0.1,0.015\n1,7,0.0,0.2,0.02\n"


def write(folder, text, name="ranges.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_columns_go_anchor_by_anchor(tmp_path):
    found = read_uwb_lias(write(tmp_path, ROWS), write(tmp_path, CAPTURE, "mocap.csv"))
    ranges = found.ranges
    assert len(ranges) == 24 + 21
    np.testing.assert_allclose(ranges.distance, ranges.anchor + 0.1 * ranges.tag + 0.01)
    np.testing.assert_allclose(ranges.t, np.repeat([0, 0.01], [24, 21]))
    assert found.log.skipped == ("3 empty cells of ranges",)
    assert found.log.origin_ns == 1660556247_039000000
    np.testing.assert_allclose(ranges.anchors.p_a[3], [3.6011, 0.0008, -1.0422])
    np.testing.assert_allclose(ranges.lever_b[0], [-0.0689, 0.1423, -0.0011])
    position, attitude = found.reference["position"], found.reference["attitude"]
    np.testing.assert_allclose(position.values, [[1, -2, -0.96]])
    np.testing.assert_allclose(position.t, -1.0)
    heading = euler_from_quat(attitude.values)[0]
    np.testing.assert_allclose(heading, [0, 0, -2 * np.arctan2(0.6, 0.8)], atol=1e-12)


def test_without_motion_capture_there_is_no_reference(tmp_path):
    assert read_uwb_lias(write(tmp_path, ROWS)).reference == {}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (ROWS.replace(",7.21", "", 1), "line 1(.|\n)*24 cells"),
        (ROWS.replace("2022-08", "2022-13"), "'time' line 1"),
        (ROWS.replace("9:37:27.049", "9:37:26.049"), "line 2"),
        (ROWS.replace("0.11", "0,11", 1), "26 cells"),
        (ROWS.replace("0.11", "x", 1), "'a0-t1' line 1"),
        (ROWS.replace("0.11", "inf", 1), "finite"),
        ("\n\n", "no rows"),
        (b"\xff\xfe", "UTF-8"),
    ],
)
def test_tables_that_are_none_are_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        read_uwb_lias(write(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (CAPTURE.replace("rotation,,,", "qw,qx,qy,qz"), "header"),
        (CAPTURE.replace("0.8", "0.9"), "unit quaternion"),
        (CAPTURE.replace(",2,", ",,"), "'y' line 2"),
        (CAPTURE.replace(",2,", ","), "line 2"),
    ],
)
def test_motion_capture_that_is_none_is_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        read_uwb_lias(write(tmp_path, ROWS), write(tmp_path, text, "mocap.csv"))


def test_sheets_name_their_links(tmp_path):
    sheet = read_uwb_lias_sheet(write(tmp_path, SHEET))
    assert (sheet.anchor, sheet.tag) == (("a0", "a7"), ("t0", "t1"))
    np.testing.assert_array_equal(sheet.bias, [0.1, 0.2])


@pytest.mark.parametrize(
    "text",
    [
        SHEET + "0,0,0.01,0.1,0.015\n",
        SHEET.replace("1,7", "3,7"),
        SHEET.replace("1,7", "1,8"),
        SHEET.replace("1,7", "0.5,7"),
        SHEET.replace("0.02\n", "0\n"),
        SHEET.replace("0.0,", "-1,"),
        SHEET.replace("0.2", ""),
        SHEET.replace("slope", "gain"),
    ],
)
def test_sheets_that_are_none_are_refused(tmp_path, text):
    with pytest.raises(InputError):
        read_uwb_lias_sheet(write(tmp_path, text))


@given(st.data())
def test_damaged_tables_are_read_or_refused(tmp_path_factory, data):
    folder = tmp_path_factory.getbasetemp()
    whole = {"ranges.csv": ROWS, "mocap.csv": CAPTURE, "sheet.csv": SHEET}
    name = data.draw(st.sampled_from(sorted(whole)))
    raw = whole[name].encode()
    at, size = data.draw(st.integers(0, len(raw))), data.draw(st.integers(0, 12))
    middle = data.draw(st.binary(max_size=6) | st.sampled_from([b"1e999", b"nan", b"\n", b'"', b"9999", b"0000"]))
    for one, text in whole.items():
        write(folder, raw[:at] + middle + raw[at + size :] if one == name else text, one)
    try:
        assert len(read_uwb_lias(folder / "ranges.csv", folder / "mocap.csv").ranges) > 0
        assert len(read_uwb_lias_sheet(folder / "sheet.csv").slope) > 0
    except InputError as why:
        assert why.got or why.expected


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
def test_the_real_trolley():
    found = read_uwb_lias(LIAS / "UWB_dynamic_exp_mid.csv", LIAS / "motion_capture_dynamic_exp_mid.csv")
    assert len(found.ranges) == 12908 * 24 - 6
    position, attitude = found.reference["position"], found.reference["attitude"]
    assert len(position) == 16069
    np.testing.assert_allclose([position.values[:, 2].min(), position.values[:, 2].max()], [-0.987, -0.951], atol=1e-3)
    tilt = euler_from_quat(attitude.values)[:, :2]
    assert np.abs(tilt).max() < np.radians(5)  # upright in frame a only if both turns are right
    sheet = read_uwb_lias_sheet(LIAS / "calibration" / "calibration.csv")
    assert len(set(zip(sheet.anchor, sheet.tag, strict=True))) == 24
    assert sheet.slope[[a == "a3" and t == "t2" for a, t in zip(sheet.anchor, sheet.tag, strict=True)]] == 0
