"""A log into our own CSV table, whole or not at all; every number comes back bit for bit."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from robustnav.errors import InputError
from robustnav.files import write_whole
from robustnav.logs.layout import (
    MOVING,
    RESERVED,
    ROLES,
    SENSOR_FRAMES,
    SENSOR_UNITS,
    TIME,
    TITLE,
    UNITS,
    column_names,
    parse_column,
    state_columns,
)
from robustnav.records import Array, Log, Stream, Truth


@dataclass(frozen=True)
class _Block:
    """Columns that share their stamps ``t`` (n,): names and ``values`` (n, m)."""

    names: list[str]
    t: Array
    values: Array


def write_table(log: Log, path: str | os.PathLike[str]) -> None:
    """Write a log as a table that ``read`` takes back; an existing file is replaced only by a complete one.

    Raises
    ------
    InputError : a stream whose name or unit the layout cannot hold, nothing to write, or a path that cannot be written.
    """
    blocks = [_stream_block(stream) for stream in log.streams.values()]
    blocks += [_truth_block(truth, role) for role, truth in _roles(log) if truth is not None]
    file = Path(path)
    if not blocks:
        raise InputError("nothing to write", place=file.name, got="a log without streams", expected="a stream at least")
    write_whole(file, chain([f"{TITLE}\n# {_notes(log)}\n"], _lines(blocks)))


def _roles(log: Log) -> list[tuple[str, Truth | None]]:
    return [(role, getattr(log, role)) for role in ROLES]


def _stream_block(stream: Stream) -> _Block:
    width = stream.values.shape[1]
    names = column_names(stream.name, stream.unit, width) if stream.unit in UNITS else []
    columns = [parse_column(name) for name in names]
    named = len(names) == width and all(c is not None and c.stream == stream.name for c in columns)
    told = (SENSOR_UNITS.get(stream.name, stream.unit), SENSOR_FRAMES.get(stream.name, stream.frame))
    if RESERVED.fullmatch(stream.name) or not named or told != (stream.unit, stream.frame):
        raise InputError(
            f"a table cannot hold stream {stream.name!r}",
            got=f"{width} columns in {stream.unit!r}, frame {stream.frame!r}",
            expected=f"a name in small letters, not reserved, that fits unit and frame; a unit of {', '.join(UNITS)}",
            do="rename or convert the stream, or leave it out",
        )
    return _Block(names, stream.t, stream.values)


def _truth_block(truth: Truth, role: str) -> _Block:
    names: list[str] = []
    values: list[Array] = []
    for state, columns in state_columns(role).items():
        value = getattr(truth, state)
        if value is not None:
            names.extend(columns)
            values.append(value)
    if truth.moving is not None:
        names.append(ROLES[role] + MOVING)
        values.append(truth.moving[:, None].astype(float))
    return _Block(names, truth.t, np.concatenate(values, axis=1) if values else np.zeros((len(truth.t), 0)))


def _notes(log: Log) -> str:
    notes: dict[str, object] = {
        "origin_ns": log.origin_ns,
        "conventions": list(log.conventions),
        "skipped": list(log.skipped),
        "info": dict(log.info),
        "frames": {name: stream.frame for name, stream in log.streams.items() if stream.frame != "b"},
    }
    for role, truth in _roles(log):
        if truth is not None:
            notes[role] = {"kind": truth.kind, "north": truth.north, "accuracy": truth.accuracy}
    return json.dumps(notes)


def _lines(blocks: list[_Block]) -> list[str]:
    """Return header and rows: one row for each stamp, as many as the block that repeats it most often."""
    keys = [np.column_stack([b.t, _occurrence(b.t)]) for b in blocks]
    merged, row_of = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    names = [name for b in blocks for name in b.names]
    rows = [[repr(t)] + [""] * len(names) for t in merged[:, 0].tolist()]
    taken, column = 0, 1
    for b in blocks:
        for row, values in zip(row_of.ravel()[taken : taken + len(b.t)].tolist(), b.values.tolist(), strict=True):
            rows[row][column : column + len(values)] = map(repr, values)
        taken, column = taken + len(b.t), column + len(b.names)
    return [",".join(row) + "\n" for row in [[TIME, *names], *rows]]


def _occurrence(t: Array) -> Array:
    """Return how often each stamp (n,) came before: 0, 0, 1, 2, 0 ... for times in order."""
    index = np.arange(len(t), dtype=float)
    first = np.concatenate([[True], np.diff(t) != 0]) if len(t) else np.zeros(0, bool)
    return index - np.maximum.accumulate(np.where(first, index, 0.0)) if len(t) else index
