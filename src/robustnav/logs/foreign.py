"""A foreign CSV table, read through a mapping that says what every column means."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustnav.frames import (
    Q_FRD_FLU,
    frd_from_flu,
    quat_conjugate,
    quat_multiply,
    quat_ned_from_enu,
    quat_normalize,
)
from robustnav.logs.cells import Cells, block, check_order, check_unit, split
from robustnav.logs.files import read_text, unusable
from robustnav.logs.gnss import CONVENTION, FIX_3D, Fixes, gnss_streams
from robustnav.logs.layout import SENSOR_FRAMES, SENSOR_UNITS
from robustnav.logs.mapping import (
    FACTORS,
    HEIGHT_FACTORS,
    PLACE_FACTORS,
    AttitudeColumns,
    LevelColumns,
    Mapping,
    PlaceColumns,
    SensorColumns,
    TimeColumn,
    load_mapping,
)
from robustnav.records import Array, Log, Stream, Truth

LONGEST = 9e9  # s, what 64 bits of nanoseconds hold
NANOSECONDS = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}


def read_foreign(path: Path, mapping_path: Path) -> Log:
    """Return a foreign table in our units and frames, as the mapping says.

    Raises
    ------
    InputError : a mistake in the mapping, a column it names that is not there, cells that are no numbers, or time that
        goes backwards.
    """
    mapping = load_mapping(mapping_path)
    text = read_text(path, "a table of text")
    cells = split(path, text, delimiter=mapping.delimiter, skip_lines=mapping.skip_lines)
    t, origin = _time(cells, mapping.time)
    streams = [_stream(cells, t, name, sensor) for name, sensor in mapping.sensors().items()]
    streams += [_level(cells, t, name, part) for name, part in mapping.levels().items()]
    skipped = [f"column {name!r}: not in the mapping" for name in cells.names if name not in _used(mapping)]
    place, where = _place(cells, t, mapping.gnss_place, skipped)
    streams += place
    if not streams:
        raise unusable(mapping_path, "no sensor", "[gyro], [accel], [mag], [velocity] or [gnss_...]")
    attitude = mapping.attitude
    states = _attitude(cells, t, attitude) if attitude else None
    return Log(
        streams={s.name: s for s in streams},
        source=path.name,
        conventions=_conventions(mapping),
        origin_ns=origin,
        truth=states if attitude and attitude.role == "truth" else None,
        estimate=states if attitude and attitude.role == "estimate" else None,
        skipped=tuple(skipped),
        info={"format": "table with mapping", **where},
    )


def _time(cells: Cells, time: TimeColumn) -> tuple[Array, int]:
    """Return seconds since the first row and the first stamp [ns]; whole-number stamps are subtracted exactly."""
    if time.column is None or time.unit is None:
        return np.arange(len(cells.rows)) / float(time.rate_hz or np.nan), 0
    values, _ = cells.numbers(time.column)
    check_order(cells, time.column, values)
    scale = NANOSECONDS[time.unit]
    wild = np.flatnonzero(np.abs(values) > LONGEST / (scale * 1e-9))
    if wild.size:
        place = cells.place(time.column, int(wild[0]))
        raise unusable(cells.path, f"{values[wild[0]]:g} {time.unit}", "a time within centuries of zero", place=place)
    try:
        stamps = np.array([int(cell) for cell in cells.text(time.column)], dtype=np.int64)
        origin = int(stamps[0]) * scale
        return (stamps - stamps[0]) * (scale * 1e-9), origin
    except (ValueError, OverflowError):  # decimals, or beyond 64 bits: then as they were read
        return (values - values[0]) * (scale * 1e-9), round(values[0] * scale)


def _stream(cells: Cells, t: Array, name: str, sensor: SensorColumns) -> Stream:
    values, there = block(cells, sensor.columns)
    values = values * (sensor.sign * FACTORS[name][sensor.unit])
    return Stream(name, t[there], frd_from_flu(values) if sensor.frame == "FLU" else values, SENSOR_UNITS[name])


def _level(cells: Cells, t: Array, name: str, part: LevelColumns) -> Stream:
    values, there = block(cells, part.columns)
    values = values * FACTORS[name][part.unit]
    if part.frame == "ENU":
        values = values[:, [1, 0, 2][: values.shape[1]]] * [1, 1, -1][: values.shape[1]]
    return Stream(name, t[there], values, SENSOR_UNITS[name], SENSOR_FRAMES[name])


def _place(
    cells: Cells, t: Array, place: PlaceColumns | None, skipped: list[str]
) -> tuple[list[Stream], dict[str, str | float]]:
    if place is None:
        return [], {}
    values, there = block(cells, place.columns)
    scale = PLACE_FACTORS[place.unit]
    fixed = np.ones(len(values), bool)
    if place.fix_column is not None:
        fixed = cells.numbers(place.fix_column)[0][there] >= FIX_3D
    degrees = values * [scale, scale, HEIGHT_FACTORS[place.height_unit]]
    streams, where = gnss_streams(Fixes(t[there], fixed, degrees, None), skipped)
    latitude = {"latitude_deg": where["origin_latitude_deg"]} if where else {}
    return streams, {**where, **latitude}


def _attitude(cells: Cells, t: Array, attitude: AttitudeColumns) -> Truth:
    q, there = block(cells, attitude.columns)
    check_unit(cells, q, there, attitude.columns[0])
    q = quat_normalize(np.roll(q, 1, axis=1) if attitude.order == "xyzw" else q)
    q = quat_conjugate(q) if attitude.direction == "world_to_body" else q
    q = quat_ned_from_enu(q) if attitude.world == "ENU" else q
    q = quat_multiply(q, Q_FRD_FLU) if attitude.body == "FLU" else q
    return Truth(t[there], q, attitude.kind, attitude.north)


def _conventions(mapping: Mapping) -> tuple[str, ...]:
    lines = [f"{name}: {s.frame}, {s.unit}, sign {s.sign:+d}" for name, s in mapping.sensors().items()]
    lines += [f"{name}: {part.frame}, {part.unit}" for name, part in mapping.levels().items()]
    if p := mapping.gnss_place:
        lines += [f"gnss_place: {p.unit}, {p.height_unit}", CONVENTION]
    if a := mapping.attitude:
        lines.append(f"attitude: {a.body} to {a.world}, {a.order}, {a.direction}, {a.north} north")
    return tuple(lines)


def _used(mapping: Mapping) -> set[str]:
    parts = [*mapping.sensors().values(), *mapping.levels().values(), mapping.gnss_place, mapping.attitude]
    used = {name for part in parts if part for name in part.columns}
    fix = mapping.gnss_place.fix_column if mapping.gnss_place else None
    return used | {name for name in (fix, mapping.time.column) if name}
