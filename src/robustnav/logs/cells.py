"""Text tables: a header, rows of cells, and numbers on demand, every fault named by column and line."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robustnav.logs.files import unusable
from robustnav.logs.unit_check import not_unit
from robustnav.records import Array, BoolArray


@dataclass(frozen=True)
class Cells:
    """A table as text: ``names`` of its columns, its ``rows`` and the ``lines`` of the file they stand on."""

    path: Path
    names: tuple[str, ...]
    rows: Sequence[Sequence[str]]
    lines: Sequence[int]

    def text(self, name: str) -> list[str]:
        """Return one column's cells without blanks around them; raise ``InputError`` if there is no such column."""
        if name not in self.names:
            raise unusable(self.path, f"columns {', '.join(self.names)}", f"a column {name!r}", place="header")
        k = self.names.index(name)
        return [row[k].strip() for row in self.rows]

    def numbers(self, name: str) -> tuple[Array, BoolArray]:
        """Return one column as numbers (n,) and which cells are filled; an empty cell is NaN."""
        cells = self.text(name)
        out = np.full(len(cells), np.nan)
        for row, cell in enumerate(cells):
            if cell:
                out[row] = self._number(cell, name, row)
        return out, np.array([bool(cell) for cell in cells], dtype=bool)

    def _number(self, cell: str, name: str, row: int) -> float:
        try:
            value = float(cell)
        except ValueError:
            value = np.inf
        if np.isinf(value) or "_" in cell:
            do = "write numbers with a decimal point, leave missing ones empty"
            raise unusable(self.path, repr(cell[:40]), "a finite number", place=self.place(name, row), do=do)
        return value

    def place(self, name: str, row: int) -> str:
        """Return the words for one cell's place in the file."""
        return f"column {name!r} line {self.lines[row]}"


def split(path: Path, text: str, *, delimiter: str = ",", skip_lines: int = 0) -> Cells:
    """Return the cells of a table whose header stands after ``skip_lines`` lines; a ``#`` before it is dropped.

    Raises
    ------
    InputError : no header, no rows, a column named twice, or a row with another number of cells.
    """
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        for row in reader:
            if row and reader.line_num > skip_lines:
                rows.append(row)
                lines.append(reader.line_num)
    except csv.Error as why:
        place = f"line {reader.line_num}"
        raise unusable(path, str(why), "comma-separated text", place=place, do="save it as plain CSV") from why
    if len(rows) < 2:
        raise unusable(path, f"{len(rows)} filled lines", "a header and at least one row", do="copy it again")
    names = tuple(name.strip() for name in rows[0])
    names = (names[0].lstrip("# "), *names[1:])
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise unusable(path, f"column {twice!r} twice", "every column named once", place="header")
    for row, line in zip(rows[1:], lines[1:], strict=True):
        if len(row) != len(names):
            do = "check the delimiter; the file may be cut"
            raise unusable(path, f"{len(row)} cells", f"{len(names)} cells", place=f"line {line}", do=do)
    return Cells(path, names, rows[1:], lines[1:])


def block(cells: Cells, names: Sequence[str]) -> tuple[Array, BoolArray]:
    """Return columns as (k, m) numbers of the rows where one of them is filled, and those rows as a mask (n,)."""
    columns = [cells.numbers(name) for name in names]
    there = np.any([filled for _, filled in columns], axis=0)
    return np.stack([values for values, _ in columns], axis=1)[there], there


def check_order(cells: Cells, name: str, t: Array) -> None:
    """Raise ``InputError`` naming the line where a time column is empty or goes backwards."""
    empty = np.flatnonzero(np.isnan(t))
    if empty.size:
        raise unusable(cells.path, "no time", "a time in every row", place=cells.place(name, int(empty[0])))
    back = np.flatnonzero(np.diff(t) < 0)
    if back.size:
        row = int(back[0]) + 1
        got, do = f"{t[row]:.9g} after {t[row - 1]:.9g}", "sort or cut the recording"
        raise unusable(cells.path, got, "times that never decrease", place=cells.place(name, row), do=do)


def check_unit(cells: Cells, q: Array, there: BoolArray, name: str) -> None:
    """Raise ``InputError`` naming the line where ``q`` (k, 4), the rows ``there`` (n,), is no unit quaternion."""
    bad = not_unit(q)
    if bad:
        place = cells.place(name, int(np.flatnonzero(there)[bad[0]]))
        raise unusable(cells.path, f"norm {bad[1]:.3g}", "a unit quaternion, or NaN", place=place)
