"""Our own CSV table back into a log; the layout is described in ``logs.layout``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from robustnav.logs.cells import Cells, block, check_order, check_unit, split
from robustnav.logs.files import read_text, unusable
from robustnav.logs.layout import (
    MOVING,
    ROLES,
    SENSOR_FRAMES,
    SENSOR_UNITS,
    TIME,
    TITLE,
    column_names,
    parse_column,
    state_columns,
)
from robustnav.records import Array, Log, Stream, Truth

EXPECTED = "a table with t_s first and the unit in every column name, such as gyro_x_rad_s or velocity_north_m_s"
NO_MAPPING = "give a mapping in TOML that names columns, units and frames; nothing is guessed"


def read_table(path: Path) -> Log:
    """Return a table in our own layout.

    Raises
    ------
    InputError : no UTF-8 text, columns that do not follow the layout, cells that are no numbers, time that goes
        backwards, or an attitude without its kind and north.
    """
    text = read_text(path, EXPECTED)
    notes, skip = _notes(path, text)
    cells = split(path, text, skip_lines=skip)
    if cells.names[0] != TIME:
        got = f"first column {cells.names[0][:40]!r}"
        raise unusable(path, got, EXPECTED, place="header", do=NO_MAPPING)
    t, _ = cells.numbers(TIME)
    check_order(cells, TIME, t)
    frames = _part(path, notes, "frames")
    return Log(
        streams={s.name: s for s in _streams(cells, t, frames)},
        source=path.name,
        conventions=_lines(path, notes, "conventions"),
        origin_ns=_origin(path, notes),
        truth=_states(cells, t, notes, "truth"),
        estimate=_states(cells, t, notes, "estimate"),
        skipped=_lines(path, notes, "skipped"),
        info={k: v for k, v in _part(path, notes, "info").items() if isinstance(v, str | int | float)},
    )


def _notes(path: Path, text: str) -> tuple[Mapping[str, object], int]:
    """Return the JSON notes before the header and how many lines they take."""
    first, _, rest = text.partition("\n")
    if first.strip() != TITLE:
        return {}, 0
    line = rest.partition("\n")[0].strip()
    if not line.startswith("# {"):
        return {}, 1
    try:
        notes = json.loads(line[2:])
    except (ValueError, RecursionError) as why:
        raise unusable(path, str(why), "one line of JSON after '# '", place="line 2") from why
    return notes, 2


def _part(path: Path, notes: Mapping[str, object], key: str) -> Mapping[str, object]:
    part = notes.get(key, {})
    if not isinstance(part, dict):
        raise unusable(path, f"{key} = {str(part)[:40]}", f"{key} as a JSON object", place="line 2")
    return part


def _lines(path: Path, notes: Mapping[str, object], key: str) -> tuple[str, ...]:
    part = notes.get(key, [])
    if not isinstance(part, list) or not all(isinstance(line, str) for line in part):
        raise unusable(path, f"{key} = {str(part)[:40]}", f"{key} as a list of texts", place="line 2")
    return tuple(part)


def _origin(path: Path, notes: Mapping[str, object]) -> int:
    origin = notes.get("origin_ns", 0)
    if not isinstance(origin, int) or abs(origin) >= 2**63:
        raise unusable(path, f"origin_ns = {str(origin)[:40]}", "whole nanoseconds", place="line 2")
    return origin


def _streams(cells: Cells, t: Array, frames: Mapping[str, object]) -> list[Stream]:
    """Return the streams the header names, in its order."""
    known = {TIME} | {ROLES[role] + MOVING for role in ROLES}
    known |= {name for role in ROLES for names in state_columns(role).values() for name in names}
    widths: dict[tuple[str, str], int] = {}
    for name in cells.names:
        if name in known:
            continue
        column = parse_column(name)
        if column is None or SENSOR_UNITS.get(column.stream, column.unit) != column.unit:
            raise unusable(cells.path, f"column {name[:40]!r}", EXPECTED, place="header", do=NO_MAPPING)
        widths[column.stream, column.unit] = widths.get((column.stream, column.unit), 0) + 1
    if len({stream for stream, _ in widths}) < len(widths):
        raise unusable(cells.path, "one stream in two units", "one unit for each stream", place="header")
    streams = []
    for (stream, unit), width in widths.items():
        values, there = block(cells, column_names(stream, unit, width))
        frame = frames.get(stream, SENSOR_FRAMES.get(stream, "b"))
        streams.append(Stream(stream, t[there], values, unit, str(frame)))
    return streams


def _states(cells: Cells, t: Array, notes: Mapping[str, object], role: str) -> Truth | None:
    """Return the reference or estimate in the table, or None without its columns."""
    states = {s: names for s, names in state_columns(role).items() if any(name in cells.names for name in names)}
    if not states:
        return None
    labels = _part(cells.path, notes, role)
    kind, north, accuracy = (labels.get(key, "") for key in ("kind", "north", "accuracy"))
    if not (isinstance(kind, str) and kind and north in ("magnetic", "true") and isinstance(accuracy, str)):
        example = f'"{role}": {{"kind": "optical", "north": "magnetic"}}'
        got = f"kind {str(kind)[:20]!r}, north {str(north)[:20]!r}"
        do = f"write {TITLE!r} and the line # {{{example}}} before the header"
        raise unusable(cells.path, got, f"kind and north of the {role}", place="line 2", do=do)
    flag = ROLES[role] + MOVING
    names = [name for group in states.values() for name in group] + ([flag] if flag in cells.names else [])
    values, there = block(cells, names)
    columns = {state: values[:, [names.index(n) for n in group]] for state, group in states.items()}
    if "q_nb" in columns:
        check_unit(cells, columns["q_nb"], there, states["q_nb"][0])
    moving = values[:, -1] if flag in cells.names else None
    if moving is not None and not np.isin(moving, (0, 1)).all():
        raise unusable(cells.path, "other numbers", f"0 or 1 in every row of the {role}", place=f"column {flag!r}")
    return Truth(
        t[there],
        q_nb=columns.get("q_nb"),
        kind=kind,
        north=str(north),
        p_n=columns.get("p_n"),
        v_n=columns.get("v_n"),
        moving=None if moving is None else moving.astype(bool),
        accuracy=accuracy,
    )
