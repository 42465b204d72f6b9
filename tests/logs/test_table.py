"""Our own tables: what is written comes back bit for bit, and what is no table is refused by name and line."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robustnav.errors import InputError
from robustnav.logs import read, write_table
from robustnav.records import Log, Stream, Truth

FINITE = st.floats(-1e300, 1e300)
READING = FINITE | st.just(float("nan"))


@st.composite
def streams(draw, name, unit, width):
    n = draw(st.integers(0, 6))
    t = np.sort(draw(arrays(float, n, elements=st.floats(-5, 5).map(lambda x: round(x, 1) + 0.0))))
    return Stream(name, t, draw(arrays(float, (n, width), elements=READING)), unit)


@st.composite
def logs(draw):
    parts = [draw(streams("gyro", "rad/s", 3)), draw(streams("accel", "m/s^2", 3)), draw(streams("range", "m", 2))]
    n = draw(st.integers(1, 5))
    q = np.tile([0.6, 0, 0.8, 0], (n, 1))
    q[draw(arrays(bool, n))] = np.nan
    truth = Truth(np.arange(n) * 0.3, q, "optical", "true", p_n=draw(arrays(float, (n, 3), elements=READING)))
    truth = replace(truth, moving=draw(arrays(bool, n)), accuracy="1 deg, “checked”")
    estimate = Truth(np.arange(n) * 0.2, v_n=draw(arrays(float, (n, 3), elements=READING)), kind="estimate")
    info = {"year": 2024.5, "place": draw(st.text(max_size=5))}
    return Log(
        {s.name: s for s in parts if len(s)},
        "made",
        ("first, with a comma", "second"),
        draw(st.integers(-(2**62), 2**62)),
        draw(st.sampled_from([truth, None])),
        estimate,
        ("left out",),
        info,
    )


def same(a, b, names):
    for name in names:
        x, y = getattr(a, name), getattr(b, name)
        if isinstance(x, np.ndarray):
            np.testing.assert_array_equal(x, y)
        else:
            assert x == y, name


@settings(max_examples=60, deadline=None, derandomize=True)
@given(log=logs())
def test_round_trip_is_exact(tmp_path_factory, log):
    path = tmp_path_factory.mktemp("table") / "log.csv"
    write_table(log, path)
    back = read(path)
    same(log, back, ("conventions", "origin_ns", "skipped"))
    assert dict(log.info) == dict(back.info)
    assert set(back.streams) == set(log.streams)
    for name, stream in log.streams.items():
        same(stream, back.streams[name], ("name", "t", "values", "unit", "frame"))
    for role in ("truth", "estimate"):
        a, b = getattr(log, role), getattr(back, role)
        assert (a is None) == (b is None)
        if a is not None:
            same(a, b, ("t", "q_nb", "kind", "north", "p_n", "v_n", "moving", "accuracy"))


def table(tmp_path, *lines, name="log.csv"):
    path = tmp_path / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_several_rates_by_empty_cells(tmp_path):
    path = table(
        tmp_path,
        "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,mag_x_t,mag_y_t,mag_z_t",
        "0,1,2,3,,,",
        "0.1,1,nan,3,2e-5,0,4e-5",
        "0.2,,2,,,,",
    )
    log = read(path)
    np.testing.assert_array_equal(log.streams["gyro"].t, [0, 0.1, 0.2])
    np.testing.assert_array_equal(log.streams["gyro"].values[1:], [[1, np.nan, 3], [np.nan, 2, np.nan]])
    np.testing.assert_array_equal(log.streams["mag"].t, [0.1])
    assert log.streams["mag"].unit == "T"


HEAD = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s"


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([HEAD, "0,1,2,3", "0.1,1,2"], "line 3"),
        ([HEAD, "0,1,2,3", "0.1,1,x,3"], "'gyro_y_rad_s' line 3"),
        ([HEAD, "0,1,2,3", "0.1,1,1_0,3"], "'gyro_y_rad_s' line 3"),
        ([HEAD, "0,1,2,3", "0.1,1,inf,3"], "'gyro_y_rad_s' line 3"),
        ([HEAD, "0.2,1,2,3", "0.1,1,2,3"], "'t_s' line 3(.|\n)*0.1 after 0.2"),
        ([HEAD, ",1,2,3"], "'t_s' line 2"),
        ([HEAD], "1 filled lines"),
        (["t_s,gyro_x,gyro_y,gyro_z", "0,1,2,3"], "'gyro_x'(.|\n)*mapping"),
        (["t_s,gyro_x_deg_s", "0,1"], "gyro_x_deg_s(.|\n)*mapping"),
        (["t_s,gyro_x_m,gyro_y_m,gyro_z_m", "0,1,2,3"], "gyro_x_m(.|\n)*mapping"),
        (["t_s,gyro_x_rad_s,gyro_z_rad_s", "0,1,2"], "gyro_0_rad_s"),
        (["time,ax", "0,1"], "first column 'time'(.|\n)*mapping"),
        (["t_s,gyro_x_rad_s,gyro_x_rad_s", "0,1,2"], "twice"),
        (["t_s,range_0_m,range_0_m_s", "0,1,2"], "two units"),
        (["t_s,q_nb_w,q_nb_x,q_nb_y,q_nb_z", "0,1,0,0,0"], "kind and north"),
        (["# robustnav table 1", "# {bad", HEAD, "0,1,2,3"], "line 2"),
        (["# robustnav table 1", '# {"origin_ns": 1.5}', HEAD, "0,1,2,3"], "origin_ns"),
        (["# robustnav table 1", '# {"info": []}', HEAD, "0,1,2,3"], "info"),
        (["# robustnav table 1", '# {"skipped": [1]}', HEAD, "0,1,2,3"], "skipped"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path, lines, words):
    with pytest.raises(InputError, match=words):
        read(table(tmp_path, *lines))


def test_an_attitude_that_is_none_is_refused(tmp_path):
    notes = ["# robustnav table 1", '# {"truth": {"kind": "optical", "north": "true"}}']
    head = "t_s,q_nb_w,q_nb_x,q_nb_y,q_nb_z"
    assert read(table(tmp_path, *notes, head, "0,1,0,0,0")).truth.north == "true"
    with pytest.raises(InputError, match="'q_nb_w' line 5"):
        read(table(tmp_path, *notes, head, "0,1,0,0,0", "1,1,1,0,0"))
    with pytest.raises(InputError, match="'moving'"):
        read(table(tmp_path, *notes, head + ",moving", "0,1,0,0,0,2"))


def one_stream(**changes):
    stream = Stream(**({"name": "gyro", "t": np.arange(2.0), "values": np.ones((2, 3)), "unit": "rad/s"} | changes))
    return Log({"s": stream}, "made")


@pytest.mark.parametrize("changes", [{"name": "p_n"}, {"name": "Gyro"}, {"name": "estimate_x"}, {"unit": "deg/s"}])
def test_what_the_layout_cannot_hold_is_not_written(tmp_path, changes):
    with pytest.raises(InputError, match="cannot hold"):
        write_table(one_stream(**changes), tmp_path / "log.csv")
    assert not list(tmp_path.iterdir())


def test_writing_is_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "log.csv"
    write_table(one_stream(), path)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.replace", full)
    with pytest.raises(InputError, match="No space left"):
        write_table(one_stream(name="accel", unit="m/s^2"), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["log.csv"]
    with pytest.raises(InputError, match="cannot write"):
        write_table(one_stream(), tmp_path / "nowhere" / "log.csv")
    with pytest.raises(InputError, match="nothing to write"):
        write_table(Log({}, "empty"), path)
