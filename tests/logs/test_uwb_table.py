"""A plain table of ranges beside a survey in TOML."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.logs import read_uwb_table

SURVEY = (
    'z = "up"\n[[anchor]]\nid = "A1"\nx_m = 1\ny_m = 2.0\nz_m = 3.0\nsd_m = 0.01\n'
    '[[anchor]]\nid = "B"\nx_m = 0.0\ny_m = 0.0\nz_m = 0.5\nsd_m = 0.02\n'
    '[[tag]]\nid = "T0"\nx_m = 0.1\ny_m = 0.2\nz_m = 0.3\n[[tag]]\nid = "T1"\nx_m = 0.0\ny_m = 0.0\nz_m = 0.0\n'
)
PLAIN = 'z = "down"\n[[anchor]]\nid = "A1"\nx_m = 1.0\ny_m = 2.0\nz_m = 3.0\n'
TABLE = "t_s,anchor,distance_m,tag,variance_m2\n10.5,B,4.5,T1,0.01\n10.5,A1,,T0,\n10.75,A1,5.25,T0,0.04\n"


def read(folder, table=TABLE, survey=SURVEY):
    for name, text in (("ranges.csv", table), ("survey.toml", survey)):
        (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_uwb_table(folder / "ranges.csv", folder / "survey.toml")


def test_ranges_find_their_anchors_and_tags(tmp_path):
    found = read(tmp_path)
    ranges = found.ranges
    np.testing.assert_array_equal(ranges.stream().values, [[4.5, 0, 0, -0.5], [5.25, 1, -2, -3]])
    np.testing.assert_array_equal(ranges.anchors.sd, [[0.01] * 3, [0.02] * 3])
    np.testing.assert_array_equal(ranges.tag, [1, 0])
    np.testing.assert_array_equal(ranges.lever_b, [[0.1, 0.2, 0.3], [0, 0, 0]])
    np.testing.assert_array_equal(ranges.variance, [0.01, 0.04])
    np.testing.assert_array_equal(ranges.t, [0, 0.25])
    assert found.log.origin_ns == 10_500_000_000
    assert found.log.skipped == ("1 rows without a distance",)


def test_the_smallest_pair(tmp_path):
    ranges = read(tmp_path, "t_s,anchor,distance_m\n0,A1,4.5\n", PLAIN).ranges
    np.testing.assert_array_equal(ranges.stream().values, [[4.5, 1, 2, 3]])
    assert (ranges.tags, ranges.lever_b, ranges.variance, ranges.anchors.sd) == (("tag",), None, None, None)
    two = read(
        tmp_path, "t_s,anchor,distance_m,tag\n0,A1,4.5,b\n", PLAIN + '[[tag]]\nid = "a"\n[[tag]]\nid = "b"\n'
    ).ranges
    assert (two.tag.tolist(), two.lever_b) == ([1], None)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (TABLE.replace(",B,", ",C,"), "'anchor' line 2(.|\n)*A1, B"),
        (TABLE.replace("T1", "T2"), "'tag' line 2"),
        (TABLE.replace("10.75", "10.25"), "line 4"),
        (TABLE.replace("10.75", ""), "'t_s' line 4"),
        (TABLE.replace("10.75", "1e10"), "wild"),
        (TABLE.replace("0.04", "-0.04"), "variance"),
        (TABLE.replace("0.04", ""), "variance"),
        (TABLE.replace("5.25", "5,25"), "cells"),
        (TABLE.replace("5.25", "inf"), "finite"),
        (TABLE.replace("variance_m2", "sd_m"), "'sd_m'"),
        (TABLE.replace("distance_m", "tag", 1), "twice"),
        ("t_s,anchor,distance_m\n0,A1,4.5\n", "no column 'tag'"),
        ("t_s,anchor,distance_m,tag\n0,A1,,T0\n", "no distance"),
        ("t_s,distance_m,tag\n0,1,T0\n", "'anchor'"),
        (b"\xff", "UTF-8"),
    ],
)
def test_tables_that_are_none_are_refused(tmp_path, table, words):
    with pytest.raises(InputError, match=words):
        read(tmp_path, table)


@pytest.mark.parametrize(
    ("survey", "words"),
    [
        (SURVEY.replace('z = "up"\n', ""), "z: Field required"),
        (SURVEY.replace('"up"', '"north"'), "z: "),
        ('z = "up"\n', "anchor: Field required"),
        (SURVEY.replace('"B"', '"A1"'), "twice"),
        (SURVEY.replace('"B"', '""'), "printable"),
        (SURVEY.replace("x_m = 1\n", ""), "anchor.0.x_m"),
        (SURVEY.replace("x_m = 1\n", "x_m = nan\n"), "anchor.0.x_m"),
        (SURVEY.replace("x_m = 1\n", 'x_m = "one"\n'), "anchor.0.x_m"),
        (SURVEY.replace("sd_m = 0.02\n", ""), "for every anchor"),
        (SURVEY.replace("sd_m = 0.02", "sd_m = 0"), "sd_m"),
        (SURVEY.replace("z_m = 0.3\n", ""), "or none of them"),
        (SURVEY + '[[tag]]\nid = "T2"\n', "for every tag"),
        (SURVEY + '[[tag]]\nid = "T1"\nx_m = 0\ny_m = 0\nz_m = 0\n', "'T1' twice"),
        (SURVEY + "colour = 1\n", "colour"),
        ("z = ", "TOML"),
        ("a = " + "[" * 5000, "cannot use this file"),
    ],
)
def test_surveys_that_are_none_are_refused(tmp_path, survey, words):
    with pytest.raises(InputError, match=words):
        read(tmp_path, survey=survey)


def test_missing_files_are_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml"):
        read_uwb_table(tmp_path / "none.csv", tmp_path / "none.toml")


@given(st.data())
def test_damaged_files_are_read_or_refused(tmp_path_factory, data):
    which = data.draw(st.booleans())
    raw = (TABLE if which else SURVEY).encode()
    at, size = data.draw(st.integers(0, len(raw))), data.draw(st.integers(0, 12))
    middle = data.draw(st.binary(max_size=6) | st.sampled_from([b"1e999", b"nan", b"\n", b'"', b"-1", b"[[", b"inf"]))
    spoiled = raw[:at] + middle + raw[at + size :]
    try:
        found = read(tmp_path_factory.getbasetemp(), *((spoiled, SURVEY) if which else (TABLE, spoiled)))
        assert np.isfinite(found.ranges.stream().values).all()
    except InputError as why:
        assert why.got or why.expected
