"""Static ranges of the HYU outdoor set: ``height_<cm>cm/<metres>m.csv``, one true distance a file.

"Comprehensive outdoor UWB dataset: Static and dynamic measurements in LOS/NLOS environments", Hanyang University,
Scientific Data 2025, doi 10.1038/s41597-025-05887-9.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from robustnav.errors import InputError
from robustnav.logs.cells import Cells, split
from robustnav.logs.files import checked_path, read_text, unusable
from robustnav.logs.uwb_cells import required
from robustnav.logs.uwb_recording import StaticRanges
from robustnav.records import Array

EXPECTED = "a static file of the HYU set: timestamp, Distance, RSSI(dBm), RSSI_fp(dBm), anchor_id"
TAG_HEIGHT = 1.0  # m
_FOLDER = re.compile(r"height_(\d{1,4}(?:\.\d+)?)cm")
_FILE = re.compile(r"(\d{1,4}(?:\.\d+)?)m\.csv")
_SUMMARY = re.compile(r'"?(Distance|RSSI\(dBm\)|RSSI_fp\(dBm\)) (Mean|Std)\b')
_ANCHOR = re.compile(r"(\d{1,9})(?:\.0)?(?:anchor_id: \1)?")  # a lost line end left the label once more behind it
_Readings = tuple[Array, list[str], str]  # columns (n, 4), anchor ids, what was left out


def read_uwb_hyu_static(folder: str | os.PathLike[str]) -> StaticRanges:
    """Return the static ranges below a folder of ``height_<cm>cm`` folders, or of one of these.

    The true distance is the slant one, from an anchor at the folder's height to the tag at 1 m, the file's name away.
    Files end with six lines of means, which are counted and left out; files without data are named in ``skipped``.

    Raises
    ------
    InputError : no such files, a file that is no table of this set, or a cell that is no number.
    """
    top = Path(folder)
    paths = [path for path in sorted(top.glob("height_*cm/*m.csv")) or sorted(top.glob("*m.csv")) if _distance(path)]
    if not paths:
        do = "give the folder that holds height_50.0cm and its like"
        raise InputError("no static ranges", place=top.name, expected="files height_<cm>cm/<metres>m.csv", do=do)
    found = [
        (path, _distance(path), _read(path)) for path in sorted(paths, key=lambda p: (p.parent.name, _distance(p)))
    ]
    kept = [(path, distance, readings) for path, distance, readings in found if len(readings[1])]
    if not kept:
        raise InputError("no static ranges", place=top.name, got="files without data", expected="rows of ranges")
    numbers = np.vstack([readings[0] for _, _, readings in kept])
    sizes = [len(readings[1]) for _, _, readings in kept]
    origin = int(numbers[:, 0].min())
    return StaticRanges(
        t=numbers[:, 0] - origin,
        distance_true=np.repeat([distance for _, distance, _ in kept], sizes),
        measured=numbers[:, 1],
        anchor=tuple(anchor for _, _, readings in kept for anchor in readings[1]),
        file=np.repeat(np.arange(len(kept)), sizes),
        files=tuple(f"{path.parent.name}/{path.name}" for path, _, _ in kept),
        rssi_dbm=numbers[:, 2],
        rssi_first_path_dbm=numbers[:, 3],
        origin_ns=origin * 10**9,
        skipped=tuple(f"{path.parent.name}/{path.name}: {readings[2]}" for path, _, readings in found if readings[2]),
    )


def _distance(path: Path) -> float:
    """Return the slant distance [m] the names say, or 0 for names that say none."""
    folder, file = _FOLDER.fullmatch(path.parent.name), _FILE.fullmatch(path.name)
    return float(np.hypot(float(file[1]), float(folder[1]) / 100 - TAG_HEIGHT)) if folder and file else 0.0


def _read(path: Path) -> _Readings:
    lines = read_text(checked_path(path, EXPECTED), EXPECTED).splitlines()
    summary = [k for k, line in enumerate(lines) if _SUMMARY.match(line)]
    blank = [k for k, line in enumerate(lines) if not line.strip(", \t")]
    for k in (*summary, *blank):
        lines[k] = ""  # the lines after keep their numbers
    notes = [f"{len(found)} {what}" for found, what in ((summary, "lines of means"), (blank, "empty lines")) if found]
    if not any(lines[1:]):
        return np.zeros((0, 4)), [], "no data"
    cells = split(path, "\n".join(lines))
    times = required(cells, ("timestamp", "Distance"))
    if not ((times[:, 0] >= 0) & (times[:, 0] < 4e9) & np.r_[True, np.diff(times[:, 0]) >= 0]).all():
        raise unusable(path, "other numbers", "seconds since 1970 that never decrease", place="column 'timestamp'")
    return (
        np.column_stack([times, _power(cells, "RSSI(dBm)"), _power(cells, "RSSI_fp(dBm)")]),
        _anchors(cells),
        ", ".join(notes),
    )


def _power(cells: Cells, name: str) -> Array:
    """Return a column of powers [dBm] (n,): NaN where the cell is empty or minus infinity, that is, no power at all."""
    known = [("" if cell.lower() in ("-inf", "-infinity") else cell,) for cell in cells.text(name)]
    return Cells(cells.path, (name,), known, cells.lines).numbers(name)[0]


def _anchors(cells: Cells) -> list[str]:
    ids = []
    for row, cell in enumerate(cells.text("anchor_id")):
        found = _ANCHOR.fullmatch(cell)
        if not found:
            place = cells.place("anchor_id", row)
            raise unusable(cells.path, repr(cell[:40]), "the number of an anchor", place=place)
        ids.append(found[1])
    return ids
