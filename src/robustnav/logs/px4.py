"""PX4 ULog: body FRD, navigation NED, quaternion w first body to world, so only gauss and microseconds change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robustnav.frames import quat_normalize
from robustnav.logs.files import unusable
from robustnav.logs.gnss import CONVENTION, gnss_streams
from robustnav.logs.px4_gnss import TOPICS, fixes_of
from robustnav.logs.px4_info import describe
from robustnav.logs.ulog_file import load_ulog
from robustnav.logs.unit_check import not_unit
from robustnav.records import Array, Log, Stream, Truth
from robustnav.units import GAUSS, US

Stamps = NDArray[np.int64]
NO_STAMP = 2147483647  # a relative stamp that says "this sensor gave nothing"
LAST_STAMP = 2**53  # us, 285 years: a larger one is damage
CONVENTIONS = (
    "body FRD, navigation NED, quaternion w first, body to navigation: unchanged",
    "gyro and accelerometer as published: calibrated, board levelling applied, averaged over their interval",
    "magnetometer gauss to tesla, microseconds since boot to seconds since the first IMU sample",
    CONVENTION,
)


@dataclass(frozen=True)
class Topic:
    """One instance of one topic: its columns by field name."""

    name: str
    columns: Mapping[str, NDArray[np.generic]]
    path: Path

    def column(self, field: str) -> Array:
        """Return one field as numbers (n,)."""
        if field not in self.columns:
            raise unusable(self.path, f"fields {', '.join(self.columns)}", f"a field {field!r}", place=self.name)
        with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN
            return np.asarray(self.columns[field], float)

    def vector(self, field: str, size: int) -> Array:
        """Return the fields ``field[0]`` ... as (n, size)."""
        return np.stack([self.column(f"{field}[{k}]") for k in range(size)], axis=1)

    def stamps(self, field: str = "timestamp") -> Stamps:
        """Return a stamp field [us]; raise ``InputError`` where it cannot be one."""
        us: NDArray[Any] | None = self.columns.get(field)
        if us is None or us.dtype.kind not in "iu":
            raise unusable(self.path, f"no whole-number field {field!r}", "stamps in microseconds", place=self.name)
        wild = np.flatnonzero((us < 0) | (us > LAST_STAMP))
        if wild.size:
            place = f"{self.name}.{field} row {wild[0]}"
            raise unusable(self.path, f"{us[wild[0]]} us", "microseconds since boot", place=place, do="copy it again")
        return us.astype(np.int64)

    def useless_stamps(self) -> str:
        """Return why the topic carries no time, or nothing; a single row says nothing either way."""
        us = self.columns.get("timestamp")
        if us is None or len(us) < 2 or (us != us[0]).any():
            return ""
        return "every stamp is zero" if us[0] == 0 else f"every stamp is {us[0]} us"


def read_px4(path: Path) -> Log:
    """Return a PX4 ULog recording.

    Streams ``gyro`` and ``accel`` from ``sensor_combined``, ``mag`` from ``vehicle_magnetometer`` or, in old layouts,
    from ``sensor_combined`` without its repeated samples.  ``estimate`` is ``vehicle_attitude``, ``truth`` the
    ``vehicle_attitude_groundtruth`` of a simulator.  ``gnss_velocity`` and ``gnss_position`` are
    ``vehicle_gps_position`` or ``sensor_gps``, rows without a 3-D fix NaN.

    Raises
    ------
    InputError : no ULog file, no IMU in it, or stamps that carry no time.
    """
    file = load_ulog(path)
    topics = {d.name: Topic(d.name, d.data, path) for d in reversed(file.log.data_list) if d.multi_id == 0}
    imu = topics.get("sensor_combined")
    if imu is None:
        got = f"topics {', '.join(sorted(topics)) or 'none'}"
        raise unusable(path, got, "the topic sensor_combined", do="log it: SDLOG_PROFILE with the default set")
    if reason := imu.useless_stamps():
        raise unusable(path, reason, "stamps that advance", place=imu.name, do="the file carries no usable time")
    skipped = [f"{name}: {reason}" for name, topic in sorted(topics.items()) if (reason := topic.useless_stamps())]
    origin = int(imu.stamps()[0])
    info = describe(file.log, topics)
    if file.incomplete:
        info["incomplete"] = file.incomplete
        skipped.append(file.incomplete)
    streams = _streams(imu, topics, origin, skipped)
    gnss, where = _gnss(topics, origin, skipped)
    info.update(where)
    north = "true" if float(info.get("declination_deg", 0.0)) else "magnetic"
    return Log(
        streams={s.name: s for s in (*streams, *gnss)},
        source=path.name,
        conventions=CONVENTIONS,
        origin_ns=origin * 1000,
        truth=_attitude(topics, "vehicle_attitude_groundtruth", ("simulated", "true"), origin, skipped),
        estimate=_attitude(topics, "vehicle_attitude", ("estimate", north), origin, skipped),
        skipped=tuple(skipped),
        info=info,
    )


def _seconds(us: Stamps, origin: int) -> Array:
    """Return stamps as seconds; the difference is taken in whole microseconds."""
    return np.asarray((us - origin) * US, float)


def _streams(imu: Topic, topics: Mapping[str, Topic], origin: int, skipped: list[str]) -> Sequence[Stream]:
    stamps = imu.stamps()
    streams = [Stream("gyro", _seconds(stamps, origin), imu.vector("gyro_rad", 3), "rad/s")]
    accel = _relative(imu, "accelerometer", "accelerometer_m_s2", skipped)
    if accel is not None:
        streams.append(Stream("accel", _seconds(accel[0], origin), accel[1], "m/s^2"))
    mag = _magnetometer(imu, topics, skipped)
    if mag is not None and len(mag[0]):
        streams.append(Stream("mag", _seconds(mag[0], origin), mag[1] * GAUSS, "T"))
    if f"baro_{RELATIVE}" in imu.columns and (imu.column(f"baro_{RELATIVE}") == NO_STAMP).all():
        skipped.append("barometer: invalid in every row")
    return streams


def _gnss(topics: Mapping[str, Topic], origin: int, skipped: list[str]) -> tuple[list[Stream], dict[str, str | float]]:
    gps = next((topics[name] for name in TOPICS if name in topics), None)
    if gps is None or gps.useless_stamps():
        return [], {}
    fixes = fixes_of(gps, _seconds(_measured(gps), origin))
    if fixes is None:
        skipped.append(f"{gps.name}: it does not say which rows are fixes")
        return [], {}
    return gnss_streams(fixes, skipped)


RELATIVE = "timestamp_relative"


def _relative(topic: Topic, sensor: str, field: str, skipped: list[str]) -> tuple[Stamps, Array] | None:
    """Return stamps and readings (n, 3) of a sensor stamped relative to its topic, fresh samples only."""
    stamps, values = topic.stamps(), topic.vector(field, 3)
    name = f"{sensor}_{RELATIVE}"
    if name in topic.columns:
        relative = topic.column(name)
        valid = relative != NO_STAMP
        if not valid.all():
            skipped.append(f"{sensor}: {int(np.sum(~valid))} of {len(valid)} rows invalid")
        if not valid.any():
            return None
        if not (np.abs(relative[valid]) < LAST_STAMP).all():
            raise unusable(
                topic.path, "a wild number", "microseconds", place=f"{topic.name}.{name}", do="copy it again"
            )
        stamps, values = np.asarray(stamps[valid] + relative[valid].astype(np.int64)), values[valid]
    fresh = np.concatenate([[True], np.diff(stamps) != 0])
    if not fresh.all():
        skipped.append(f"{sensor}: {int(np.sum(~fresh))} of {len(fresh)} rows repeat the sample before")
    return stamps[fresh], values[fresh]


def _magnetometer(imu: Topic, topics: Mapping[str, Topic], skipped: list[str]) -> tuple[Stamps, Array] | None:
    own = topics.get("vehicle_magnetometer")
    if own is None:
        old = "magnetometer_ga[0]" in imu.columns
        return _relative(imu, "magnetometer", "magnetometer_ga", skipped) if old else None
    if own.useless_stamps():
        return None
    return _measured(own), own.vector("magnetometer_ga", 3)


def _measured(topic: Topic) -> Stamps:
    """Return when a topic was measured: ``timestamp_sample`` where it is filled in, else when it was published."""
    sample = topic.columns.get("timestamp_sample")
    return topic.stamps("timestamp_sample" if sample is not None and (sample != 0).all() else "timestamp")


def _attitude(
    topics: Mapping[str, Topic], name: str, labels: tuple[str, str], origin: int, skipped: list[str]
) -> Truth | None:
    """Return an attitude topic labelled with its (kind, north); one that holds no attitude is listed as skipped."""
    topic = topics.get(name)
    if topic is None or topic.useless_stamps():
        return None
    q_nb = topic.vector("q", 4)
    bad = not_unit(q_nb)
    if bad:
        skipped.append(f"{name}: row {bad[0]} is no unit quaternion, its norm is {bad[1]:.3g}")
        return None
    kind, north = labels
    accuracy = "the simulator's own attitude" if kind == "simulated" else "the autopilot's own estimate"
    return Truth(_seconds(_measured(topic), origin), quat_normalize(q_nb), kind, north, accuracy=accuracy)
