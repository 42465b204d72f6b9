"""Calibrations on disk: every bit back, whole or not at all, and nothing else taken for one."""

import contextlib
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.calibrate import (
    HUBER,
    BiasCurve,
    Fitted,
    Pairs,
    RangeCalibration,
    RangeLine,
    calibrate_ranges,
    fit_curve,
    read_calibration,
    write_calibration,
)
from robustnav.errors import InputError

NUMBER = st.floats(allow_nan=False, allow_infinity=False)
POSITIVE = st.floats(min_value=5e-324, allow_nan=False, allow_infinity=False)
FITTED = st.builds(
    lambda c, n, x: Fitted(((c[0], c[1]), (c[1], c[2])), n, x, n, n, n, c[0], c[1], HUBER),
    st.tuples(NUMBER, NUMBER, NUMBER),
    st.integers(0, 2**62),
    POSITIVE,
)
LINES = st.builds(RangeLine, POSITIVE, NUMBER, POSITIVE, st.none() | FITTED)
NAMES = st.text(min_size=1, max_size=8).filter(str.isprintable)


def written(pairs):
    return calibrate_ranges(pairs, "anchor", lambda p: fit_curve(p, (1.0, 30.0, 60.0)), 'a hall \u2014 "June" \\ 1')


@pytest.fixture
def calibration():
    rng = np.random.default_rng(1)
    d = rng.uniform(1, 60, 200)
    r = d + 0.1 + 0.05 * rng.standard_normal(200)
    return written(Pairs(d, r, anchor=np.array(["7", "a b"])[rng.integers(0, 2, 200)], file=rng.integers(0, 9, 200)))


def test_a_curve_comes_back_bit_for_bit(tmp_path, calibration):
    path = tmp_path / "c.toml"
    write_calibration(calibration, path)
    assert read_calibration(path) == calibration
    first = path.read_bytes()
    write_calibration(read_calibration(path), path)
    assert path.read_bytes() == first


@given(st.dictionaries(st.tuples(NAMES, NAMES), LINES, min_size=1, max_size=4))
def test_all_lines_come_back_bit_for_bit(tmp_path_factory, lines):
    path = tmp_path_factory.getbasetemp() / "all.toml"
    calibration = RangeCalibration("link", lines)
    write_calibration(calibration, path)
    back = read_calibration(path)
    assert back == calibration
    for key, line in lines.items():
        assert math.copysign(1, back.corrections[key].offset) == math.copysign(1, line.offset)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, calibration, monkeypatch):
    path = tmp_path / "c.toml"
    write_calibration(calibration, path)
    before = path.read_bytes()

    def full(self, target):
        raise OSError(28, "no space left")

    monkeypatch.setattr("pathlib.Path.replace", full)
    with pytest.raises(InputError, match="no space left"):
        write_calibration(RangeCalibration("all", {(): RangeLine(1.0, 0.0, 1.0)}), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["c.toml"]


def test_names_no_file_can_hold_are_refused(tmp_path):
    with pytest.raises(InputError, match="printable"):
        write_calibration(RangeCalibration("anchor", {("a\nb",): RangeLine(1.0, 0.0, 1.0)}), tmp_path / "c.toml")
    with pytest.raises(InputError, match="folder"):
        write_calibration(RangeCalibration("all", {(): RangeLine(1.0, 0.0, 1.0)}), tmp_path)


HEAD = 'calibration = "ranges"\nby = "anchor"\n'
LINE = '[[correction]]\nkey = ["A"]\nslope = 1.0\noffset_m = 0.1\nrange_variance_m2 = 0.01\n'
FIT = (
    "[correction.fitted]\ncovariance = [[1.0, 0.0], [0.0, 1.0]]\ndof = 5\nvariance_dof = 5.0\nsamples = 7\nfiles = 0\n"
    'outliers = 0\ndistance_min_m = 1.0\ndistance_max_m = 2.0\nloss = "huber"\nloss_constant = 1.3\n'
)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[", "TOML|Expected|Invalid|Unclosed|Cannot"),
        ("", "calibration: Field required"),
        (HEAD, "correction: Field required"),
        (HEAD.replace("ranges", "gyro") + LINE, "calibration"),
        (HEAD.replace("anchor", "tag") + LINE, "by 'tag'"),
        (HEAD + LINE + LINE, "twice"),
        (HEAD + LINE.replace('["A"]', '["A", "B"]'), "names"),
        (HEAD + LINE + "colour = 1\n", "colour"),
        (HEAD + LINE.replace("0.01", "-0.01"), "range_variance_m2"),
        (HEAD + LINE.replace("1.0", "0.0"), "slope"),
        (HEAD + LINE.replace("1.0", "nan"), "slope"),
        (HEAD + LINE.replace("1.0", '"1"'), "slope"),
        (HEAD + LINE + FIT.replace("[0.0, 1.0]]", "[0.0]]"), "2 rows of 2"),
        (HEAD + LINE + FIT.replace("huber", "median"), "median"),
        (HEAD + LINE + FIT.replace("dof = 5\n", "dof = -5\n"), "dof"),
        (
            HEAD + '[[correction]]\nkey = ["A"]\nknots_m = [2.0, 1.0]\nbias_m = [0.0, 0.0]\nrange_variance_m2 = 0.1\n',
            "knots",
        ),
        ("a = " + "[" * 5000, "cannot use this calibration"),
    ],
)
def test_what_is_no_calibration_is_refused(tmp_path, text, words):
    path = tmp_path / "c.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read_calibration(path)


def test_the_smallest_file_is_taken(tmp_path):
    path = tmp_path / "c.toml"
    path.write_text(HEAD + LINE + FIT, encoding="utf-8")
    assert read_calibration(path).corrections[("A",)].fitted.loss.constant == 1.3


def test_missing_files_and_other_bytes_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"c\.toml"):
        read_calibration(tmp_path / "c.toml")
    (tmp_path / "c.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="cannot use"):
        read_calibration(tmp_path / "c.toml")


@given(st.data())
def test_damaged_files_are_read_or_refused(tmp_path_factory, data):
    text = (HEAD + LINE + FIT).encode()
    at = data.draw(st.integers(0, len(text) - 1))
    size = data.draw(st.integers(0, 6))
    path = tmp_path_factory.getbasetemp() / "damaged.toml"
    path.write_bytes(text[:at] + data.draw(st.binary(max_size=6)) + text[at + size :])
    with contextlib.suppress(InputError):
        assert read_calibration(path).by in ("all", "anchor", "link")


def test_a_curve_that_was_stated_comes_back(tmp_path):
    stated = RangeCalibration("all", {(): BiasCurve((1.0, 2.0), (0.1, 0.2), 0.01)})
    write_calibration(stated, tmp_path / "c.toml")
    assert read_calibration(tmp_path / "c.toml") == stated
