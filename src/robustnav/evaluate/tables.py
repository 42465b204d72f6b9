"""Rows of results as aligned text and as plain data for JSON: one wording of numbers and headings for both."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePath

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Score

Row = Mapping[str, object]
SIGNIFICANT = 3
MAX_DECIMALS = 4
UNITS = {
    "deg": "deg",
    "rad": "rad",
    "s": "s",
    "ms": "ms",
    "us": "µs",
    "m": "m",
    "hz": "Hz",
    "dps": "deg/s",
    "ppm": "ppm",
    "percent": "%",
}

ACRONYMS = ("rms", "nis", "nees", "pcrb", "imu")


def columns_of(rows: Sequence[Row]) -> list[str]:
    """Return the names of all columns in the order of their first appearance."""
    return list(dict.fromkeys(name for row in rows for name in row))


def heading(name: str) -> str:
    """Return a heading of a column name: ``total_rms_deg`` becomes ``Total RMS, deg``."""
    words, _, last = name.rpartition("_")
    words, unit = (words, f", {UNITS[last]}") if words and last in UNITS else (name, "")
    text = " ".join(word.upper() if word in ACRONYMS else word for word in words.split("_"))
    return text[:1].upper() + text[1:] + unit


def is_number(value: object) -> bool:
    """Say whether a cell is a number, not a truth value."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def numeric_columns(rows: Sequence[Row]) -> set[str]:
    """Return the columns that hold nothing but numbers and None, and at least one number."""
    return {
        name
        for name in columns_of(rows)
        if all(row.get(name) is None or is_number(row[name]) for row in rows)
        and any(is_number(row.get(name)) for row in rows)
    }


def cells(rows: Sequence[Row]) -> list[list[str]]:
    """Return every cell as text, the numbers of a column with one number of decimals.

    None is shown as a dash, NaN as ``NaN``: no figure, and a figure that failed.
    """
    columns = [_column([row.get(name) for row in rows]) for name in columns_of(rows)]
    return [list(row) for row in zip(*columns, strict=True)]


def text_table(rows: Sequence[Row]) -> str:
    """Return rows as text, words aligned left and numbers right; the empty string without rows."""
    if not rows:
        return ""
    names = columns_of(rows)
    right = numeric_columns(rows)
    lines = [[heading(name) for name in names], *cells(rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(names))]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(
        "  ".join(
            cell.rjust(width) if name in right else cell.ljust(width)
            for cell, width, name in zip(line, widths, names, strict=True)
        ).rstrip()
        for line in lines
    )


def score_rows(scores: Iterable[Score], names: Sequence[str]) -> list[dict[str, object]]:
    """Return one row a score: estimator, the values ``names`` (None where absent), samples."""
    return [
        {"estimator": score.estimator, **{name: score.values.get(name) for name in names}, "samples": score.samples}
        for score in scores
    ]


def plain(value: object) -> object:
    """Return a value as JSON can hold it: NaN as None, infinities as ``inf`` and ``-inf``, arrays as lists.

    Raises
    ------
    InputError : a type with no plain form; the message names it.
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None if math.isnan(value) else str(value)
    if isinstance(value, PurePath):
        return value.as_posix()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    raise InputError(
        "a result cannot be written as JSON",
        got=f"{type(value).__name__}",
        expected="numbers, text, arrays, lists, tuples, mappings or None",
    )


def json_rows(rows: Iterable[Row]) -> list[dict[str, object]]:
    """Return rows as JSON can hold them; see ``plain``."""
    return [{name: plain(value) for name, value in row.items()} for row in rows]


def _column(values: Sequence[object]) -> list[str]:
    sizes = [abs(float(v)) for v in values if isinstance(v, float | np.floating) and math.isfinite(v) and v != 0]
    return [_cell(value, min(sizes, default=1.0), max(sizes, default=1.0)) for value in values]


def _cell(value: object, smallest: float, largest: float) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if not isinstance(value, float | np.floating):
        return str(value)
    if not math.isfinite(value):
        return "NaN" if math.isnan(value) else str(float(value))
    if largest >= 1e7 or largest < 10.0**-MAX_DECIMALS:
        return f"{value:.{SIGNIFICANT}g}"
    decimals = SIGNIFICANT - 1 - math.floor(math.log10(smallest))
    return f"{value:.{min(max(decimals, 0), MAX_DECIMALS)}f}"
