"""Walks of the ISAS group: IMU, five anchors, tracker; ROS 1 bag with messages of the Fraunhofer RTLS stick.

K. Li, Z. Cao, U. D. Hanebeck, Continuous-Time Ultra-Wideband-Inertial Fusion, IEEE Robotics and Automation Letters
8(7), 2023, 4338-4345, doi 10.1109/LRA.2023.3281932.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from robustnav.frames import quat_normalize
from robustnav.logs.files import unusable
from robustnav.logs.unit_check import not_unit
from robustnav.logs.uwb_bag import read_bag
from robustnav.logs.uwb_recording import RangeRecording, seconds
from robustnav.records import Anchors, Array, IntArray, Log, Ranges, Stream

RTLS, IMU, TRACKER, VENDOR = "/rtls_flares", "/waveshare_sense_hat_b", "/vive/transform/tracker_1_ref", "/rtls_pose"
TOPICS = {
    RTLS: "fraunhofer_rtls_flare/msg/RTLSStick",
    IMU: "sensor_msgs/msg/Imu",
    TRACKER: "geometry_msgs/msg/TransformStamped",
    VENDOR: "geometry_msgs/msg/PoseStamped",
}
CONVENTIONS = (
    "header stamps; the first range is the start, the reference begins before it",
    "the anchors' frame has z down, 3.4 deg off gravity; taken as frame a without a turn",
    "IMU axes (x, y, z up) to FRD: y and z negated",
    "reference in the tracker's own axes, frame 'vive': neither level nor aligned; align before scoring",
    "ranges are as reported; the authors add an offset for each anchor (toa_offset)",
)


def read_uwb_isas(path: str | os.PathLike[str]) -> RangeRecording:
    """Return a walk: fresh ranges, gyro and accel, the tracker's pose and the vendor's own fix.

    Ranges marked ``ra = 0`` repeat an old one; they are left out and counted.  ``ranges.variance`` is the reported one.
    ``reference`` has ``position`` and ``attitude`` of the tracker in frame ``vive``, w first.
    ``estimates["vendor"]`` jumps by up to 150 m.

    Raises
    ------
    MissingExtra : rosbags is not installed (extra ``ros``).
    InputError : no such bag, a damaged one, an anchor that moves, or time that goes backwards.
    """
    file = Path(path)
    messages = read_bag(file, TOPICS)
    ranges, origin, stale = _ranges(file, messages[RTLS])

    def stream(name: str, topic: str, numbers: Callable[[Any], Sequence[float]], unit: str, frame: str) -> Stream:
        t = seconds(_stamps(file, topic, messages[topic]), origin)
        return Stream(name, t, _finite(file, topic, [numbers(m) for m in messages[topic]]), unit, frame)

    gyro = stream("gyro", IMU, lambda m: _frd(m.angular_velocity), "rad/s", "b")
    accel = stream("accel", IMU, lambda m: _frd(m.linear_acceleration), "m/s^2", "b")
    position = stream("position", TRACKER, lambda m: _xyz(m.transform.translation), "m", "vive")
    attitude = stream("attitude", TRACKER, lambda m: _wxyz(m.transform.rotation), "1", "vive")
    vendor = stream("vendor", VENDOR, lambda m: _xyz(m.pose.position), "m", "a")
    bad = not_unit(attitude.values)
    if bad:
        raise unusable(file, f"norm {bad[1]:.3g}", "unit quaternions", place=f"{TRACKER} message {bad[0]}")
    attitude = Stream("attitude", attitude.t, quat_normalize(attitude.values), "1", "vive")
    skipped = (f"{stale} ranges with ra = 0: an old value once more",) if stale else ()
    log = Log(
        {"gyro": gyro, "accel": accel}, file.name, CONVENTIONS, origin, skipped=skipped, info={"format": "ISAS bag"}
    )
    return RangeRecording(ranges, log, {"position": position, "attitude": attitude}, {"vendor": vendor})


def _ranges(path: Path, messages: Sequence[Any]) -> tuple[Ranges, int, int]:
    """Return the fresh ranges, the first stamp [ns] and how many old ones were left out."""
    stamps = _stamps(path, RTLS, messages)
    rows = [(stamp, m.id, r) for stamp, m in zip(stamps.tolist(), messages, strict=True) for r in m.ranges]
    fresh = [row for row in rows if row[2].ra]
    if not fresh:
        raise unusable(path, f"{len(rows)} ranges, none fresh", "ranges with ra = 1", place=RTLS)
    places: dict[int, tuple[float, ...]] = {}
    for _, _, r in rows:
        if places.setdefault(r.id, _xyz(r.pos)) != _xyz(r.pos):
            raise unusable(path, f"anchor {r.id} at {_xyz(r.pos)}", f"at {places[r.id]} always", place=RTLS)
    ids, tags = sorted(places), sorted({tag for _, tag, _ in fresh})
    numbers = _finite(path, RTLS, [(r.range, r.var) for _, _, r in fresh])
    if (numbers[:, 1] < 0).any():
        raise unusable(path, "a negative variance", "variances [m^2]", place=RTLS)
    ranges = Ranges(
        t=seconds([stamp for stamp, _, _ in fresh], fresh[0][0]),
        anchor=np.array([ids.index(r.id) for _, _, r in fresh]),
        tag=np.array([tags.index(tag) for _, tag, _ in fresh]),
        distance=numbers[:, 0],
        anchors=Anchors(tuple(map(str, ids)), _finite(path, RTLS, [places[k] for k in ids])),
        tags=tuple(map(str, tags)),
        variance=numbers[:, 1],
    )
    return ranges, fresh[0][0], len(rows) - len(fresh)


def _stamps(path: Path, topic: str, messages: Sequence[Any]) -> IntArray:
    """Return the header stamps [ns] (n,), never decreasing."""
    out = np.array([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages], np.int64)
    back = np.flatnonzero(np.diff(out) < 0)
    if back.size:
        place = f"{topic} message {int(back[0]) + 1}"
        raise unusable(path, "an earlier time", "times that never decrease", place=place)
    return out


def _finite(path: Path, topic: str, rows: Sequence[Sequence[float]]) -> Array:
    out = np.array(rows, float)
    if out.ndim != 2 or not np.isfinite(out).all():
        raise unusable(path, "no messages" if out.ndim != 2 else "a number that is not finite", "numbers", place=topic)
    return out


def _xyz(v: Any) -> tuple[float, ...]:
    return (v.x, v.y, v.z)


def _frd(v: Any) -> tuple[float, ...]:
    return (v.x, -v.y, -v.z)


def _wxyz(q: Any) -> tuple[float, ...]:
    return (q.w, q.x, q.y, q.z)
