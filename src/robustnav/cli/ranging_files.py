"""What the ranging verbs read: ranges with their true distances, ranges between anchors, ranges to a moving tag."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robustnav.errors import InputError
from robustnav.logs.cells import Cells, check_order
from robustnav.logs.files import unusable
from robustnav.logs.uwb_cells import required, table
from robustnav.records import Array, BoolArray, IntArray

if TYPE_CHECKING:
    from robustnav.calibrate import Pairs
    from robustnav.survey import Measured

TRUE_EXPECTED = "a table of ranges with their true distances: distance_m, distance_true_m, and anchor, tag if told"
SURVEY_EXPECTED = "a table of ranges: from, to, distance_m between anchors, or t_s, anchor, distance_m to a tag"
TRUE_COLUMNS = {"t_s", "anchor", "tag", "distance_m", "distance_true_m"}
LINK_COLUMNS = {"from", "to", "distance_m", "sd_m"}
TAG_COLUMNS = {"t_s", "anchor", "distance_m", "sd_m"}


@dataclass(frozen=True)
class Found:
    """Pairs of all files together, the files' names by number, and notes on what was left out."""

    pairs: Pairs
    files: tuple[str, ...]
    notes: tuple[str, ...]


def read_true_ranges(paths: Sequence[Path]) -> Found:
    """Return ranges with their true distances from folders of the HYU static set and from tables of one's own.

    Every table, and every file of a folder, counts as recorded in one go.

    Raises
    ------
    InputError : a file that is neither, a cell that is no number, or anchors told in one file and not in another.
    """
    from robustnav.calibrate import Pairs

    parts: list[tuple[Pairs, int]] = []
    files: list[str] = []
    notes: list[str] = []
    for path in paths:
        part, names, left_out = _static_folder(path) if path.is_dir() else _true_table(path)
        parts.append((part, len(files)))
        files += names
        notes += left_out
    columns: dict[str, object] = {}
    for name in ("anchor", "tag"):
        told = [getattr(part, name) is not None for part, _ in parts]
        if any(told) and not all(told):
            place = files[parts[told.index(False)][1]]
            raise InputError(f"no {name} told", place=place, expected=f"{name} in all files, or in none")
        columns[name] = np.concatenate([getattr(part, name) for part, _ in parts]) if all(told) else None
    numbers = [np.zeros(len(part), np.int64) if part.file is None else part.file for part, _ in parts]
    pairs = Pairs(
        np.concatenate([part.distance_true for part, _ in parts]),
        np.concatenate([part.measured for part, _ in parts]),
        file=np.concatenate([number + first for number, (_, first) in zip(numbers, parts, strict=True)])
        if len(files) > 1
        else None,
        **columns,  # type: ignore[arg-type]
    )
    return Found(pairs, tuple(files), tuple(notes))


def _static_folder(folder: Path) -> tuple[Pairs, list[str], list[str]]:
    from robustnav.calibrate import Pairs
    from robustnav.logs import read_uwb_hyu_static

    found = read_uwb_hyu_static(folder)
    pairs = Pairs(found.distance_true, found.measured, anchor=np.array(found.anchor), file=found.file)
    counted = f"{folder.name}: left out in {len(found.skipped)} files: {found.skipped[0]} ..." if found.skipped else ""
    return pairs, list(found.files), [counted] if counted else []


def _true_table(path: Path) -> tuple[Pairs, list[str], list[str]]:
    from robustnav.calibrate import Pairs

    cells = _table(path, TRUE_COLUMNS, TRUE_EXPECTED)
    distance, there = _measured(cells)
    true = required(cells, ("distance_true_m",))[:, 0]
    if (true < 0).any():
        row = int(np.argmax(true < 0))
        place = cells.place("distance_true_m", row)
        raise unusable(path, str(true[row]), "a true distance of 0 m or more", place=place)
    labels = {name: np.array(_ids(cells, name))[there] for name in ("anchor", "tag") if name in cells.names}
    return Pairs(true[there], distance[there], **labels), [path.name], _failed(cells, there)


def read_survey_ranges(paths: Sequence[Path], known: Sequence[str], sd: float) -> tuple[Measured, tuple[str, ...]]:
    """Return ranges between anchors and to a tag, and notes; ids are those ``known``, then as they appear.

    Parameters
    ----------
    paths : tables with columns ``from``, ``to``, ``distance_m`` or ``t_s``, ``anchor``, ``distance_m``; ``sd_m`` in
        either.  One table with ``t_s`` at most.
    known : ids of anchors whose positions are known.
    sd : of a range [m] where the table has no ``sd_m``.

    Raises
    ------
    InputError : other columns, a cell that is no number, or two tables with ``t_s``.
    """
    from robustnav.survey import Links, Measured, TagRanges

    tables = [_table(path, _columns_of(path), SURVEY_EXPECTED) for path in paths]
    ids = list(known)
    links = [cells for cells in tables if "from" in cells.names]
    tags = [cells for cells in tables if "t_s" in cells.names]
    if len(tags) > 1:
        raise InputError("survey", got=f"{len(tags)} tables with t_s", expected="one tag, in one table")
    notes: list[str] = []
    parts = []
    for cells in links:
        distance, there = _measured(cells)
        ends = [_rows(_ids(cells, name), ids)[there] for name in ("from", "to")]
        parts.append((*ends, distance[there], _sds(cells, sd)[there]))
        notes += _failed(cells, there)
    between = Links(*(np.concatenate(column) for column in zip(*parts, strict=True))) if parts else None
    tag = None
    for cells in tags:
        distance, there = _measured(cells)
        t = required(cells, ("t_s",))[:, 0]
        check_order(cells, "t_s", t)
        rows = _rows(_ids(cells, "anchor"), ids)
        tag = TagRanges((t - t[0])[there], rows[there], distance[there], _sds(cells, sd)[there])
        notes += _failed(cells, there)
    return Measured(tuple(ids), between, tag), tuple(notes)


def _columns_of(path: Path) -> set[str]:
    return LINK_COLUMNS if "from" in table(path, SURVEY_EXPECTED).names else TAG_COLUMNS


def _table(path: Path, columns: set[str], expected: str) -> Cells:
    cells = table(path, expected)
    unknown = sorted(set(cells.names) - columns)
    if unknown:
        raise unusable(path, f"column {unknown[0][:40]!r}", expected, place="header")
    return cells


def _measured(cells: Cells) -> tuple[Array, BoolArray]:
    """Return measured distances (n,) and which rows have one."""
    distance = cells.numbers("distance_m")[0]
    there = np.isfinite(distance)
    if not there.any():
        raise unusable(cells.path, "no distance", "a distance in one row at least", place="column 'distance_m'")
    return distance, there


def _ids(cells: Cells, name: str) -> list[str]:
    found = cells.text(name)
    empty = next((row for row, cell in enumerate(found) if not cell), None)
    if empty is not None:
        raise unusable(cells.path, "no name", "a name in every row", place=cells.place(name, empty))
    return found


def _rows(names: Sequence[str], ids: list[str]) -> IntArray:
    """Return the row of each name among ``ids``, to which new ones are added."""
    at = {name: k for k, name in enumerate(ids)}
    for name in names:
        if name not in at:
            at[name] = len(ids)
            ids.append(name)
    return np.array([at[name] for name in names], np.int64)


def _sds(cells: Cells, sd: float) -> Array:
    return required(cells, ("sd_m",))[:, 0] if "sd_m" in cells.names else np.full(len(cells.rows), sd)


def _failed(cells: Cells, there: BoolArray) -> list[str]:
    failed = int(np.count_nonzero(~there))
    return [f"{cells.path.name}: {failed} rows without a distance left out"] if failed else []


def numbers_by_name(text: str, option: str, parse: Callable[[str], float] = float) -> dict[str, float]:
    """Return numbers given as ``A=2.0,B=1.5``.

    Raises
    ------
    InputError : anything else.
    """
    out: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = part.partition("=")
        try:
            out[name.strip()] = parse(value)
        except ValueError:
            equals = ""
        if not equals or not name.strip() or not np.isfinite(out[name.strip()]):
            raise InputError(option, got=repr(part), expected="names and numbers as in A=2.0,B=1.5")
    return out
