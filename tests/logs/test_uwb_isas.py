"""Walks in ROS 1 bags: fresh ranges only, axes turned, and damaged bags refused.

The messages are laid out here byte by byte as ROS 1 does, little-endian without gaps.
"""

import os
import struct
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.errors import InputError, MissingExtra
from robustnav.logs import read_uwb_isas, uwb_bag
from robustnav.logs.uwb_isas import IMU, RTLS, TOPICS, TRACKER, VENDOR

DATA = os.environ.get("ROBUSTNAV_DATA")
with_rosbags = pytest.mark.skipif(find_spec("rosbags") is None, reason="rosbags is not installed")
START = 1664959676 * 10**9
PLACES = {7475: (0.0, 0.0, 0.0), 20276: (5.5, 0.0, 1.5)}


def header(t_ns):
    return struct.pack("<IIII", 0, t_ns // 10**9, t_ns % 10**9, 0)


def stick(t_ns, *ranges, places=PLACES):
    """Return a message of ranges: (anchor, distance, variance, fresh) each."""
    out = header(t_ns) + struct.pack("<HI9dBBI", 27956, 0, *[0.0] * 9, 0, 0, len(ranges))
    for anchor, distance, variance, fresh in ranges:
        out += struct.pack("<H3d8fBB", anchor, *places[anchor], 1, distance, 0, variance, 0, 0, 0, 0, 3, fresh)
    return out


def imu(t_ns, rate, force):
    return header(t_ns) + struct.pack("<37d", *[0.0] * 13, *rate, *[0.0] * 9, *force, *[0.0] * 9)


def pose(t_ns, place, turn, child=False):
    return header(t_ns) + (struct.pack("<I", 0) if child else b"") + struct.pack("<7d", *place, *turn)


WALK = [
    (RTLS, stick(START, (20276, 4.5, 0.25, 1), (7475, 3.25, 0.5, 1))),
    (RTLS, stick(START + 5, (20276, 4.5, 0.25, 0), (7475, 3.5, 0.5, 1))),
    (IMU, imu(START + 2, (1, 2, 3), (4, 5, 10))),
    (TRACKER, pose(START - 10, (1, 2, 3), (0.6, 0, 0, 0.8), child=True)),
    (VENDOR, pose(START + 4, (7, 8, 9), (0, 0, 0, 1))),
]


def write(path, messages, kinds=TOPICS):
    rosbag1, _, typesys = uwb_bag._rosbags()
    store = uwb_bag._store(typesys)
    path.unlink(missing_ok=True)
    with rosbag1.Writer(path) as bag:
        connections = {topic: bag.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
        for k, (topic, raw) in enumerate(messages):
            bag.write(connections[topic], START + k, raw)
    return path


@with_rosbags
def test_fresh_ranges_axes_and_frames(tmp_path):
    found = read_uwb_isas(write(tmp_path / "x.bag", WALK))
    ranges = found.ranges
    assert (ranges.anchors.ids, ranges.tags) == (("7475", "20276"), ("27956",))
    np.testing.assert_array_equal(ranges.stream().values, [[4.5, 5.5, 0, 1.5], [3.25, 0, 0, 0], [3.5, 0, 0, 0]])
    np.testing.assert_array_equal(ranges.variance, [0.25, 0.5, 0.5])
    np.testing.assert_allclose(ranges.t, [0, 0, 5e-9])
    assert found.log.skipped == ("1 ranges with ra = 0: an old value once more",)
    assert found.log.origin_ns == START
    np.testing.assert_array_equal(found.log.streams["gyro"].values, [[1, -2, -3]])
    np.testing.assert_array_equal(found.log.streams["accel"].values, [[4, -5, -10]])
    np.testing.assert_allclose(found.reference["position"].t, [-1e-8])
    np.testing.assert_array_equal(found.reference["attitude"].values, [[0.8, 0.6, 0, 0]])
    assert (found.reference["position"].frame, found.estimates["vendor"].frame) == ("vive", "a")
    np.testing.assert_array_equal(found.estimates["vendor"].values, [[7, 8, 9]])


def changed(index, raw):
    return [*WALK[:index], (WALK[index][0], raw), *WALK[index + 1 :]]


@with_rosbags
@pytest.mark.parametrize(
    ("messages", "words"),
    [
        (changed(1, stick(START - 1, (7475, 3.0, 0.1, 1))), "message 1(.|\n)*never decrease"),
        (changed(0, stick(START, (7475, np.nan, 0.1, 1))), "finite"),
        (changed(0, stick(START, (7475, 3.0, -0.1, 1))), "variance"),
        (changed(1, stick(START + 5, (7475, 3.0, 0.1, 1), places={7475: (9, 9, 9)})), "anchor 7475"),
        ([m for m in WALK if m[0] != RTLS] + [(RTLS, stick(START, (7475, 3.0, 0.1, 0)))], "none fresh"),
        ([m for m in WALK if m[0] != IMU], "no messages"),
        (changed(3, pose(START, (1, 2, 3), (0.6, 0, 0, 0.9), child=True)), "unit quaternions"),
        (changed(2, imu(START, (1, 2, 3), (4, 5, 10))[:-1]), "ROS 1 bag"),
        (changed(2, imu(START, (1, np.inf, 3), (4, 5, 10))), "finite"),
    ],
)
def test_messages_that_are_none_are_refused(tmp_path, messages, words):
    with pytest.raises(InputError, match=words):
        read_uwb_isas(write(tmp_path / "x.bag", messages))


@with_rosbags
def test_other_topics_and_types_are_refused(tmp_path):
    without = {topic: kind for topic, kind in TOPICS.items() if topic != VENDOR}
    with pytest.raises(InputError, match="the topic /rtls_pose"):
        read_uwb_isas(write(tmp_path / "x.bag", WALK[:4], without))
    with pytest.raises(InputError, match=r"type geometry_msgs/msg/PoseStamped(.|\n)*as we know it"):
        read_uwb_isas(write(tmp_path / "x.bag", WALK[4:], TOPICS | {IMU: TOPICS[VENDOR]}))


@with_rosbags
def test_a_definition_that_differs_is_refused(tmp_path, monkeypatch):
    path = write(tmp_path / "x.bag", WALK)
    other = {name: text.replace("uint8 toc", "uint16 toc") for name, text in uwb_bag.DEFINITIONS.items()}
    monkeypatch.setattr(uwb_bag, "DEFINITIONS", other)
    with pytest.raises(InputError, match="sum"):
        read_uwb_isas(path)


@with_rosbags
@given(st.data())
def test_damaged_bags_are_read_or_refused(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "damaged.bag"
    raw = write(path, WALK).read_bytes()
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(raw) - 1))
        middle = data.draw(st.binary(max_size=4) | st.sampled_from([b"\xff" * 4, b"\0" * 4]))
        size = data.draw(st.sampled_from([len(middle), 0, 7]))
        raw = raw[:at] + middle + raw[at + size :]
    path.write_bytes(raw[: data.draw(st.sampled_from([len(raw), len(raw) // 2]))] or b"#")
    try:
        assert np.isfinite(read_uwb_isas(path).ranges.distance).all()
    except InputError as why:
        assert why.got or why.expected


def test_without_rosbags_the_extra_is_named(tmp_path, monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(uwb_bag, "import_module", missing)
    (tmp_path / "x.bag").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(MissingExtra, match=r"robustnav\[ros\]"):
        read_uwb_isas(tmp_path / "x.bag")


@with_rosbags
@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
def test_the_real_walk():
    found = read_uwb_isas(Path(DATA or ".") / "uwb" / "isas_walk1" / "ISAS-Walk1.bag")
    assert found.log.skipped == ("584 ranges with ra = 0: an old value once more",)
    assert len(found.ranges) == 970 * 5 - 584
    assert found.ranges.anchors.ids == ("7475", "9524", "10548", "15155", "20276")
    assert len(found.log.streams["gyro"]) == 4839
    np.testing.assert_allclose(found.reference["position"].t[0], -3.59, atol=0.01)
    still = found.log.streams["accel"].between(0, 1).values.mean(axis=0)
    assert still[2] < -9.5  # specific force of a level body at rest, z down
