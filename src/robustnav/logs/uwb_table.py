"""A plain table of ranges beside a survey: one range a row, ``t_s,anchor,distance_m``, and ``tag``, ``variance_m2``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from robustnav.errors import InputError
from robustnav.logs.cells import Cells, check_order
from robustnav.logs.files import unusable
from robustnav.logs.uwb_cells import required, table
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.records import IntArray, Log, Ranges

EXPECTED = "a table of ranges: t_s, anchor, distance_m, and where there are any tag, variance_m2"
COLUMNS = {"t_s", "anchor", "distance_m", "tag", "variance_m2"}
LONGEST = 4e9  # s since 1970, the year 2096


def read_uwb_table(ranges: str | os.PathLike[str], survey: str | os.PathLike[str]) -> RangeRecording:
    """Return ranges from a CSV table, one a row in time order, with the anchors of a survey in TOML.

    Parameters
    ----------
    ranges : columns ``t_s`` [s], ``anchor``, ``distance_m`` and, as far as there are any, ``tag`` and ``variance_m2``.
        An empty distance is a range that failed: left out and counted.
    survey : anchors and tags, see ``logs.uwb_survey``.

    Raises
    ------
    InputError : other columns, a cell that is no number, time that goes backwards, or an anchor or tag the survey
        does not name.
    """
    from robustnav.logs.uwb_survey import read_survey

    anchors, tags, lever_b = read_survey(Path(survey))
    cells = table(Path(ranges), EXPECTED)
    unknown = sorted(set(cells.names) - COLUMNS)
    if unknown:
        raise unusable(cells.path, f"column {unknown[0][:40]!r}", EXPECTED, place="header")
    t = required(cells, ("t_s",))[:, 0]
    if not (np.abs(t) <= LONGEST).all():
        raise unusable(cells.path, "a wild time", "seconds since a start or since 1970", place="column 't_s'")
    check_order(cells, "t_s", t)
    distance, there = cells.numbers("distance_m")
    there &= ~np.isnan(distance)
    if not there.any():
        raise unusable(cells.path, "no distance", "a distance in one row at least", place="column 'distance_m'")
    tag = _index(cells, "tag", tags) if "tag" in cells.names else _only_tag(cells, tags)
    first = t[there][0]
    try:
        table_of_ranges = Ranges(
            t=t[there] - first,
            anchor=_index(cells, "anchor", anchors.ids)[there],
            tag=tag[there],
            distance=distance[there],
            anchors=anchors,
            tags=tags,
            lever_b=lever_b,
            variance=cells.numbers("variance_m2")[0][there] if "variance_m2" in cells.names else None,
        )
    except InputError as why:  # a variance below zero or missing; its row counts the ranges that are there
        raise unusable(cells.path, why.got, why.expected, place=f"{why.thing} {why.place}") from why
    failed = int((~there).sum())
    skipped = (f"{failed} rows without a distance",) if failed else ()
    log = Log({}, cells.path.name, (), round(first * 1e9), skipped=skipped, info={"format": "table of ranges"})
    return RangeRecording(table_of_ranges, log)


def _index(cells: Cells, name: str, known: Sequence[str]) -> IntArray:
    """Return which of the ``known`` names stands in each row (n,)."""
    at = {one: k for k, one in enumerate(known)}
    found = cells.text(name)
    for row, cell in enumerate(found):
        if cell not in at:
            raise unusable(
                cells.path, repr(cell[:40]), f"one of {', '.join(known)[:200]}", place=cells.place(name, row)
            )
    return np.array([at[cell] for cell in found], np.int64)


def _only_tag(cells: Cells, tags: Sequence[str]) -> IntArray:
    if len(tags) > 1:
        raise unusable(cells.path, "no column 'tag'", f"it, for there are {len(tags)} tags", place="header")
    return np.zeros(len(cells.rows), np.int64)
