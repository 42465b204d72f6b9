"""A velocity measured from outside: its columns name the frame, in our own tables and through a mapping."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.logs import read, write_table
from robustnav.records import Log, Stream


def velocity(width, frame="n", unit="m/s"):
    return Stream("velocity", np.arange(3.0), np.arange(3.0 * width).reshape(3, width), unit, frame)


@pytest.mark.parametrize("width", [2, 3])
def test_a_velocity_comes_back_in_its_frame_without_a_note(tmp_path, width):
    path = tmp_path / "log.csv"
    write_table(Log({"velocity": velocity(width)}, "made"), path)
    lines = path.read_text().splitlines()
    names = ["velocity_north_m_s", "velocity_east_m_s", "velocity_down_m_s"]
    assert lines[2] == ",".join(["t_s", *names[:width]])
    path.write_text("\n".join(lines[2:]) + "\n")  # as people write tables by hand
    back = read(path).stream("velocity")
    assert (back.frame, back.unit) == ("n", "m/s")
    np.testing.assert_array_equal(back.values, velocity(width).values)


@pytest.mark.parametrize(
    "header",
    [f"velocity_{rest}" for rest in ("x_m_s", "0_m_s", "north_m", "north_kn", "east_m_s")] + ["gyro_north_rad_s"],
)
def test_columns_that_leave_unit_or_frame_open_are_refused(tmp_path, header):
    path = tmp_path / "log.csv"
    path.write_text(f"t_s,{header}\n0,1\n")
    with pytest.raises(InputError, match=r"velocity_north_m_s|gyro_north"):
        read(path)


@pytest.mark.parametrize("stream", [velocity(2, frame="b"), velocity(1), velocity(4), velocity(2, unit="m")])
def test_a_velocity_that_the_names_would_misstate_is_not_written(tmp_path, stream):
    with pytest.raises(InputError, match="cannot hold"):
        write_table(Log({"velocity": stream}, "made"), tmp_path / "log.csv")


MAPPING = """
[time]
column = "t"
unit = "s"
[velocity]
columns = {columns}
unit = "{unit}"
frame = "{frame}"
"""


def through_a_mapping(tmp_path, columns, unit, frame):
    (tmp_path / "log.csv").write_text("t,a,b,c\n0,1,2,3\n1,4,,6\n")
    (tmp_path / "map.toml").write_text(MAPPING.format(columns=columns, unit=unit, frame=frame))
    return read(tmp_path / "log.csv", tmp_path / "map.toml").stream("velocity")


def test_knots_east_first_become_metres_a_second_north_first(tmp_path):
    found = through_a_mapping(tmp_path, ["a", "b"], "kn", "ENU")
    np.testing.assert_allclose(found.values, np.array([[2, 1], [np.nan, 4]]) * 1852 / 3600)
    assert (found.frame, found.unit) == ("n", "m/s")
    found = through_a_mapping(tmp_path, ["a", "b", "c"], "km/h", "ENU")
    np.testing.assert_allclose(found.values[0], np.array([2, 1, -3]) / 3.6)
    np.testing.assert_array_equal(through_a_mapping(tmp_path, ["a", "b", "c"], "m/s", "NED").values[0], [1, 2, 3])


@pytest.mark.parametrize(
    ("columns", "unit", "frame", "words"),
    [(["a"], "kn", "ENU", "at least 2"), (["a", "b"], "mph", "ENU", "velocity.unit"), (["a", "b"], "kn", "FRD", "NED")],
)
def test_a_mapping_that_leaves_the_velocity_open_is_refused(tmp_path, columns, unit, frame, words):
    with pytest.raises(InputError, match=words):
        through_a_mapping(tmp_path, columns, unit, frame)
