"""PX4-ECL replay tables: one sample a row, ``time_us, sensor, values ...``, no header; body FRD, gauss."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustnav.logs.files import read_text, unusable
from robustnav.logs.gnss import CONVENTION, Fixes, gnss_streams
from robustnav.records import Array, Log, Stream
from robustnav.units import GAUSS, US

GPS_UNITS = (1e-7, 1e-7, 1e-3)  # of latitude, longitude and altitude, in degrees and metres
EXPECTED = "rows of time_us, sensor, values as in a PX4-ECL replay table"
WIDTHS = {"imu": 6, "mag": 3, "gps": 6}
LAST_STAMP = 2**53  # us
CONVENTIONS = (
    "body FRD; an imu row holds the accelerometer first, then the gyro",
    "magnetometer gauss to tesla; gps rows hold altitude, longitude, latitude in this order",
    CONVENTION,
)
Rows = dict[str, tuple[list[int], list[list[float]]]]


def read_replay(path: Path) -> Log:
    """Return a replay table: streams gyro, accel, mag, gnss_velocity and gnss_position; every gps row counts as a fix.

    Raises
    ------
    InputError : no text, a row that is no sample, time that goes backwards, or no imu rows.
    """
    rows, other = _rows(path, read_text(path, EXPECTED))
    if not rows["imu"][0]:
        raise unusable(path, "no imu rows", EXPECTED)
    origin = rows["imu"][0][0]
    t, imu = _arrays(rows, "imu", origin)
    streams = [Stream("gyro", t, imu[:, 3:], "rad/s"), Stream("accel", t, imu[:, :3], "m/s^2")]
    if rows["mag"][0]:
        tm, mag = _arrays(rows, "mag", origin)
        streams.append(Stream("mag", tm, mag * GAUSS, "T"))
    info: dict[str, str | float] = {"format": "PX4-ECL replay"}
    skipped = [f"{name}: {count} rows" for name, count in sorted(other.items())]
    if rows["gps"][0]:
        tg, gps = _arrays(rows, "gps", origin)
        place = gps[:, [2, 1, 0]] * GPS_UNITS
        latitude, longitude, _ = np.median(place, axis=0)
        info.update(latitude_deg=float(latitude), longitude_deg=float(longitude))
        gnss, where = gnss_streams(Fixes(tg, np.ones(len(tg), bool), place, gps[:, 3:]), skipped)
        streams += gnss
        info.update(where)
    return Log({s.name: s for s in streams}, path.name, CONVENTIONS, origin * 1000, skipped=tuple(skipped), info=info)


def _arrays(rows: Rows, sensor: str, origin: int) -> tuple[Array, Array]:
    stamps, values = rows[sensor]
    return np.asarray((np.array(stamps, np.int64) - origin) * US, float), np.array(values, float)


def _rows(path: Path, text: str) -> tuple[Rows, dict[str, int]]:
    """Return stamps and values by sensor, and how many rows of other sensors there were."""
    rows: Rows = {name: ([], []) for name in WIDTHS}
    other: dict[str, int] = {}
    last = 0
    for line, content in enumerate(text.splitlines(), start=1):
        if not content.strip():
            continue
        stamp, sensor, values = _sample(path, line, content)
        if stamp < last:
            do = "sort or cut the recording"
            raise unusable(
                path, f"{stamp} us after {last} us", "times that never decrease", place=f"line {line}", do=do
            )
        last = stamp
        if sensor in rows:
            rows[sensor][0].append(stamp)
            rows[sensor][1].append(values)
        else:
            other[sensor] = other.get(sensor, 0) + 1
    return rows, other


def _sample(path: Path, line: int, content: str) -> tuple[int, str, list[float]]:
    head, _, tail = content.partition(",")
    sensor, *cells = (cell.strip() for cell in tail.split(","))
    try:
        stamp, values = int(head), [float(cell) for cell in cells]
    except ValueError as why:
        raise unusable(path, repr(content[:60]), EXPECTED, place=f"line {line}") from why
    if not 0 <= stamp <= LAST_STAMP or not np.isfinite(values).all() or WIDTHS.get(sensor, len(values)) != len(values):
        raise unusable(path, repr(content[:60]), EXPECTED, place=f"line {line}", do="the file may be cut or damaged")
    return stamp, sensor, values
