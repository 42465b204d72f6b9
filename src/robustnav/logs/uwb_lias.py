"""Planar sets of the LIAS group: eight anchors, three tags on a trolley, motion capture, calibration sheets.

H. Jiang, W. Wang, Y. Shen, X. Li, X. Ren, B. Mu, J. Wu, Efficient Planar Pose Estimation via UWB Measurements,
ICRA 2023, arXiv 2209.06779.  Anchors and tags stand in the authors' text, not in the files.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from robustnav.frames import Q_FRD_FLU, frd_from_flu, quat_multiply, quat_normalize
from robustnav.logs.cells import Cells, check_unit, split
from robustnav.logs.files import checked_path, read_text, unusable
from robustnav.logs.uwb_cells import headless, in_order, required, table
from robustnav.logs.uwb_recording import RangeRecording, seconds
from robustnav.records import Anchors, Array, BoolArray, IntArray, Log, Ranges, Stream

ANCHORS = Anchors(
    tuple(f"a{k}" for k in range(8)),
    frd_from_flu(
        [
            [-3.4203, 3.0053, 1.0442],
            [0.0016, 3.0110, 1.0446],
            [3.6056, 2.9795, 1.0463],
            [3.6011, -0.0008, 1.0422],
            [3.5674, -3.0087, 1.0443],
            [-0.0072, -2.9652, 1.0444],
            [-3.4673, -2.9587, 1.0445],
            [-3.4858, -0.0098, 1.0457],
        ]
    ),
)
TAGS = ("t0", "t1", "t2")
LEVER_B = frd_from_flu([[-0.0689, -0.1423, 0.0011], [-0.0750, 0.1402, 0.0016], [0.2034, 0.1451, -0.0008]])
CONVENTIONS = (
    "source z up; frame a is (x, -y, -z) of it, tags (x, -y, -z) of the trolley's axes",
    "the motion-capture body is already z down",
    "the authors turn the tags by another 7 deg about the source's z, -7 deg about ours: not applied",
    "stamps are local time without a zone, read as UTC; ranges agree best with motion capture 0.04 s earlier",
)
EXPECTED = "rows of local time and 24 ranges [m], anchor by anchor, no header"
_LINKS = tuple(f"{a}-{t}" for a in ANCHORS.ids for t in TAGS)
_TIME = re.compile(r"(20\d\d)-(\d\d?)-(\d\d?) (\d\d?):(\d\d):(\d\d)\.(\d{3})", re.ASCII)


@dataclass(frozen=True)
class LinkSheet:
    """The authors' calibration, range = (1 + slope) d + bias: per link ids, slope [1], bias and sd at rest [m]."""

    anchor: tuple[str, ...]
    tag: tuple[str, ...]
    slope: Array
    bias: Array
    sd: Array


def read_uwb_lias(
    ranges: str | os.PathLike[str], motion_capture: str | os.PathLike[str] | None = None
) -> RangeRecording:
    """Return a planar recording: 24 links, and the trolley's position and attitude ``q_ab`` where given.

    Each row of 24 ranges becomes rows of one stamp; empty cells are left out and counted.

    Raises
    ------
    InputError : rows that are no times and ranges, time that goes backwards, or quaternions that are none.
    """
    path = checked_path(ranges, EXPECTED)
    cells = headless(path, read_text(path, EXPECTED), ("time", *_LINKS), EXPECTED)
    stamps = _stamps(cells, "time")
    origin = int(stamps[0])
    distance = np.column_stack([cells.numbers(name)[0] for name in _LINKS])
    there = ~np.isnan(distance)
    row, link = np.nonzero(there)
    anchor, tag = np.divmod(link, len(TAGS))
    table_of_ranges = Ranges(seconds(stamps, origin)[row], anchor, tag, distance[there], ANCHORS, TAGS, LEVER_B)
    empty = int((~there).sum())
    skipped = (f"{empty} empty cells of ranges",) if empty else ()
    log = Log({}, path.name, CONVENTIONS, origin, skipped=skipped, info={"format": "LIAS"})
    return RangeRecording(table_of_ranges, log, _capture(Path(motion_capture), origin) if motion_capture else {})


def read_uwb_lias_sheet(path: str | os.PathLike[str]) -> LinkSheet:
    """Return the calibration sheets joined as ``tag,anchor,slope,bias_m,sigma_m``, indices from 0.

    Raises
    ------
    InputError : another table, an index that names no anchor or tag, or a link that stands twice.
    """
    cells = table(Path(path), "tag,anchor,slope,bias_m,sigma_m")
    rows = required(cells, ("tag", "anchor", "slope", "bias_m", "sigma_m"))
    links = [(int(tag), int(anchor)) for tag, anchor in rows[:, :2] if tag in range(3) and anchor in range(8)]
    if len(set(links)) < len(rows) or (rows[:, 2] <= -1).any() or (rows[:, 4] <= 0).any():
        expected = "every link once, tags 0 to 2, anchors 0 to 7, slopes > -1, sigma > 0"
        raise unusable(cells.path, "other rows", expected)
    anchors, tags = (tuple(names) for names in zip(*((ANCHORS.ids[a], TAGS[t]) for t, a in links), strict=True))
    return LinkSheet(anchors, tags, rows[:, 2], rows[:, 3], rows[:, 4])


def _stamps(cells: Cells, name: str) -> IntArray:
    """Return local times as ns since 1970 (n,), never decreasing."""
    return in_order(
        cells, name, np.array([_stamp(cells, k, cell) for k, cell in enumerate(cells.text(name))], np.int64)
    )


def _stamp(cells: Cells, row: int, cell: str) -> int:
    found = _TIME.fullmatch(cell)
    year, month, day, hour, minute, second, milli = map(int, found.groups()) if found else (0,) * 7
    try:
        whole = datetime(year, month, day, hour, minute, second, tzinfo=UTC)  # refuses a month 13, and the year 0
    except ValueError as why:
        expected = "a time like 2022-08-15 9:37:27.039"
        raise unusable(cells.path, repr(cell[:40]), expected, place=cells.place("time", row)) from why
    return int(whole.timestamp()) * 10**9 + milli * 10**6


def _capture(path: Path, origin: int) -> dict[str, Stream]:
    """Return motion capture: five names stand over eight columns, time, x, y, z and w, x, y, z of the quaternion."""
    expected = "motion capture: time, x, y, z and a quaternion in eight columns"
    text = read_text(checked_path(path, expected), expected)
    head, _, rows = text.partition("\n")
    if [name.strip() for name in head.split(",")] != ["time", "x", "y", "z", "rotation", "", "", ""]:
        raise unusable(path, repr(head[:60]), expected, place="header")
    cells = split(path, "time,x,y,z,qw,qx,qy,qz\n" + rows)
    t = seconds(_stamps(cells, "time"), origin)
    q = required(cells, ("qw", "qx", "qy", "qz"))
    everywhere: BoolArray = np.ones(len(q), bool)
    check_unit(cells, q, everywhere, "qw")
    q_ab = quat_multiply(Q_FRD_FLU, quat_normalize(q))  # half a turn about x takes the source's axes to frame a
    position = Stream("position", t, frd_from_flu(required(cells, ("x", "y", "z"))), "m", "a")
    return {"position": position, "attitude": Stream("attitude", t, q_ab, "1", "a")}
