"""The one door: missing, empty, foreign and damaged files end in ``InputError``, whatever bytes they hold."""

import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from robustnav.errors import InputError
from robustnav.logs import read, write_table
from robustnav.records import Log, Stream, Truth

DATA = os.environ.get("ROBUSTNAV_DATA")
FUZZ = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
HEADS = [
    b"",
    b"ULog\x01\x12\x35\x01" + bytes(8),
    b"MATLAB 5.0 MAT-file" + b" " * 105 + b"\x00\x01IM",
    b"t_s,gyro_x_rad_s\n",
]
REPLAY = "1000,imu,0,0,-9.8,0.1,0.2,0.3\n1000,mag,0.2,0,0.4\n5000,imu,0,0,-9.7,0.1,0.2,0.3\n5000,baro,488\n"
REPLAY += "9000,gps,488000,85000000,474000000,0,0,0\n9000,imu,0,0,-9.7,0.1,0.2,0.3\n"


def attempt(path):
    """Read a file of any content: a log may come back, of all errors only ``InputError``."""
    try:
        log = read(path)
    except InputError as why:
        assert why.thing
        assert why.got
        assert why.expected
        return None
    assert isinstance(log, Log)
    return log


@pytest.fixture(scope="module")
def samples(tmp_path_factory, ulog_bytes):
    """Return one small good file of each format, as bytes by suffix."""
    folder = tmp_path_factory.mktemp("samples")
    rng = np.random.default_rng(1)
    fields = {n: rng.standard_normal((12, 3)) for n in ("imu_gyr", "imu_acc", "imu_mag", "opt_pos")}
    fields |= {"opt_quat": np.tile([1.0, 0, 0, 0], (12, 1)), "movement": np.ones((12, 1), np.uint8)}
    for compressed in (False, True):
        savemat(folder / f"{compressed}.mat", fields | {"sampling_rate": 285.7}, do_compression=compressed)
    t = np.arange(8) * 0.1
    streams = {"gyro": Stream("gyro", t, rng.standard_normal((8, 3)), "rad/s")}
    write_table(Log(streams, "x", truth=Truth(t, np.tile([1.0, 0, 0, 0], (8, 1)))), folder / "t.csv")
    return {
        ".ulg": ulog_bytes,
        "plain.mat": (folder / "False.mat").read_bytes(),
        "packed.mat": (folder / "True.mat").read_bytes(),
        ".csv": (folder / "t.csv").read_bytes(),
        "replay.csv": REPLAY.encode(),
    }


FORMATS = [".ulg", "plain.mat", "packed.mat", ".csv", "replay.csv"]


@pytest.mark.parametrize("name", FORMATS)
def test_the_good_samples_are_read(tmp_path, samples, name):
    path = tmp_path / f"a{name}"
    path.write_bytes(samples[name])
    assert len(attempt(path).streams["gyro"]) > 2


@pytest.mark.parametrize("suffix", [".ulg", ".mat", ".csv", ".bag"])
@FUZZ
@given(head=st.sampled_from(HEADS), body=st.binary(max_size=300))
def test_random_bytes(tmp_path, suffix, head, body):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(head + body)
    attempt(path)


@pytest.mark.parametrize("name", FORMATS)
@FUZZ
@given(data=st.data())
def test_cut_files(tmp_path, samples, name, data):
    whole = samples[name]
    path = tmp_path / f"a{name}"
    path.write_bytes(whole[: data.draw(st.integers(0, len(whole) - 1))])
    attempt(path)


@pytest.mark.parametrize("name", FORMATS)
@FUZZ
@given(data=st.data())
def test_changed_bytes(tmp_path, samples, name, data):
    content = bytearray(samples[name])
    for _ in range(data.draw(st.integers(1, 4))):
        where = data.draw(st.integers(0, len(content) - 1))
        piece = data.draw(st.binary(min_size=1, max_size=8))
        content[where : where + len(piece)] = piece
    path = tmp_path / f"a{name}"
    path.write_bytes(bytes(content))
    attempt(path)


@FUZZ
@given(text=st.text(max_size=200))
def test_random_mappings(tmp_path, text):
    (tmp_path / "a.csv").write_text("t,x\n0,1\n", encoding="utf-8")
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError):
        read(tmp_path / "a.csv", tmp_path / "a.toml")


def test_a_damaged_file_cannot_hold_the_reader_forever(tmp_path, ulog_bytes):
    """An unknown message longer than the rest of the file: pyulog steps back further than it came."""
    path = tmp_path / "a.ulg"
    path.write_bytes(ulog_bytes[:16] + bytes(12_000) + (10_001).to_bytes(2, "little") + b"z" + bytes(60))
    with pytest.raises(InputError, match="without end"):
        read(path)


def test_formats_that_contain_themselves_are_refused(tmp_path, ulog_bytes):
    def message(kind, payload):
        return len(payload).to_bytes(2, "little") + kind + payload

    loop = message(b"F", b"a:a x;") + message(b"A", b"\0\0\0a")
    path = tmp_path / "a.ulg"
    path.write_bytes(ulog_bytes[:16] + loop)
    with pytest.raises(InputError):
        read(path)


def test_a_forged_size_is_refused_before_memory_is_taken(tmp_path, samples):
    content = samples["plain.mat"]
    rows = (12).to_bytes(4, "little")
    path = tmp_path / "a.mat"
    path.write_bytes(content.replace(rows + (3).to_bytes(4, "little"), (2**30).to_bytes(4, "little") + b"\x03\0\0\0"))
    tracemalloc.start()
    with pytest.raises(InputError):
        read(path)
    assert tracemalloc.get_traced_memory()[1] < 50e6
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.ulg", None, "No such file"),
        ("empty.ulg", b"", "empty file"),
        ("text.ulg", b"hello there, this is text", "header(.|\n)*ULog"),
        ("text.mat", b"hello there, this is text", "MATLAB 5"),
        ("wrong.bag", b"#ROSBAG V2.0\n", "suffix '.bag'"),
        ("new.mat", b"MATLAB 7.3 MAT-file" + b" " * 105 + b"\x00\x02IM", "version 7.3"),
        ("binary.csv", b"\xff\xfe\x00", "byte 0"),
    ],
)
def test_wrong_files_are_named(tmp_path, name, content, words):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=words) as caught:
        read(path)
    assert name in caught.value.place
    assert caught.value.do


def test_a_folder_and_a_path_that_cannot_be(tmp_path):
    with pytest.raises(InputError, match="not a regular file"):
        read(tmp_path)
    with pytest.raises(InputError):
        read("a\0b")


def test_content_decides_before_the_suffix(tmp_path, samples):
    path = tmp_path / "flight.bin"
    path.write_bytes(samples[".ulg"])
    assert read(path).info["format"] == "PX4 ULog"


def test_replay_table(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(REPLAY, encoding="utf-8")
    log = read(path)
    np.testing.assert_allclose(log.streams["gyro"].values[0], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(log.streams["accel"].values[0], [0, 0, -9.8])
    np.testing.assert_allclose(log.streams["mag"].values[0], [2e-5, 0, 4e-5])
    np.testing.assert_allclose(log.streams["gyro"].t, [0, 0.004, 0.008])
    assert (log.info["latitude_deg"], log.info["longitude_deg"]) == pytest.approx((47.4, 8.5))
    assert log.skipped == ("baro: 1 rows",)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("8000,imu,1,2,3,4,5,6", "line 7(.|\n)*8000 us after 9000 us"),
        ("10000,imu,1,2,3,4,5", "line 7"),
        ("10000,imu,1,2,3,4,5,nan", "line 7"),
        ("10000,imu,1,2,3,4,5,x", "line 7"),
        ("99999999999999999999,baro,1", "line 7"),
    ],
)
def test_replay_rows_that_are_none(tmp_path, line, words):
    path = tmp_path / "a.csv"
    path.write_text(REPLAY + line + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read(path)


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with px4/ and broad/")
@pytest.mark.parametrize("name", ["px4/sample_log_small.ulg", "broad/34_disturbed_attached_magnet_3cm.mat"])
def test_real_files_cut_and_changed(tmp_path, name):
    whole = (Path(DATA or ".") / name).read_bytes()
    rng = np.random.default_rng(7)
    path = tmp_path / Path(name).name
    for k in range(8):
        content = bytearray(whole[: int(len(whole) * rng.random())] if k % 2 else whole)
        for where in rng.integers(0, len(content), 3 * k):
            content[where] = rng.integers(256)
        path.write_bytes(bytes(content))
        attempt(path)
