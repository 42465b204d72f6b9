"""Tables of ranging recordings: whole nanosecond stamps, and numbers that must be there."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustnav.logs.cells import Cells, split
from robustnav.logs.files import checked_path, read_text, unusable
from robustnav.records import Array, IntArray

LAST_STAMP = 4 * 10**18  # ns since 1970: the year 2096; differences of two stamps stay within 64 bits


def table(path: Path, expected: str) -> Cells:
    """Return the cells of a CSV file with a header; raise ``InputError`` if it is none."""
    return split(path, read_text(checked_path(path, expected), expected))


def headless(path: Path, text: str, names: tuple[str, ...], expected: str) -> Cells:
    """Return the cells of comma-separated ``text`` that begins with its first row, under the given names."""
    found = [(line, row.split(",")) for line, row in enumerate(text.splitlines(), start=1) if row.strip()]
    wrong = next(((line, len(row)) for line, row in found if len(row) != len(names)), None)
    if wrong or not found:
        place, got = (f"line {wrong[0]}", f"{wrong[1]} cells") if wrong else ("", "no rows")
        raise unusable(path, got, expected, place=place)
    return Cells(path, names, [row for _, row in found], [line for line, _ in found])


def required(cells: Cells, names: tuple[str, ...]) -> Array:
    """Return columns as numbers (n, m); raise ``InputError`` naming the first cell that is empty or no number."""
    out = np.column_stack([cells.numbers(name)[0] for name in names])
    missing = np.argwhere(np.isnan(out))
    if missing.size:
        row, column = missing[0].tolist()
        raise unusable(cells.path, "no number", "a number in every row", place=cells.place(names[column], row))
    return out


def stamps(cells: Cells, name: str) -> IntArray:
    """Return a column of stamps [ns] (n,), written as whole numbers or as floats, never decreasing.

    Floats such as 1.7345014855003267e+18 are taken as the number they stand for; near 2024 they are 256 ns apart.
    """
    found = [_stamp(cells, cell, cells.place(name, row)) for row, cell in enumerate(cells.text(name))]
    return in_order(cells, name, np.array(found, np.int64))


def in_order(cells: Cells, name: str, found: IntArray) -> IntArray:
    """Return the stamps [ns] (n,) found in a column, or raise ``InputError`` naming the line where they go back."""
    back = np.flatnonzero(np.diff(found) < 0)
    if back.size:
        row = int(back[0]) + 1
        got, do = f"{found[row]} ns after {found[row - 1]} ns", "sort or cut the recording"
        raise unusable(cells.path, got, "times that never decrease", place=cells.place(name, row), do=do)
    return found


def _stamp(cells: Cells, cell: str, place: str) -> int:
    try:
        value = int(cell) if cell.isdigit() else int(float(cell))
    except (ValueError, OverflowError):  # no number; infinite, or more digits than Python turns into a number
        value = -1
    if "_" in cell or not 0 <= value <= LAST_STAMP:
        raise unusable(cells.path, repr(cell[:40]), "nanoseconds since 1970", place=place)
    return value
