"""A moving case of the HYU outdoor set: four anchors on a rig, a tag around it, GNSS and the authors' estimates.

"Comprehensive outdoor UWB dataset: Static and dynamic measurements in LOS/NLOS environments", Hanyang University,
Scientific Data 2025, doi 10.1038/s41597-025-05887-9.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from robustnav.earth import ECCENTRICITY_SQUARED, SEMI_MAJOR
from robustnav.errors import InputError
from robustnav.frames import frd_from_flu
from robustnav.logs.cells import Cells
from robustnav.logs.files import unusable
from robustnav.logs.uwb_cells import required, stamps, table
from robustnav.logs.uwb_recording import RangeRecording, seconds
from robustnav.records import Anchors, Array, Log, Ranges, Stream
from robustnav.units import DEG

EXPECTED = "a file of a moving HYU case: A<number>.csv, trajectory.csv, gnss.csv, LS.csv, ESKF.csv"
CONVENTIONS = (
    "source x, y level and z up; frame a is (x, -y, -z) of it; x does not point north",
    "reference z counts from the start; the tag is about 1 m above it",
    "reference is the GNSS track moved 0.185 m forward along the course: up to 0.2 m off along the track",
    "ranges appear 0.165 to 0.195 s late against the reference; stamps are as recorded",
)
_ANCHOR = re.compile(r"A(\d{1,9})\.csv")
_OPTIONAL = ("gnss.csv", "LS.csv", "ESKF.csv")


def read_uwb_hyu(folder: str | os.PathLike[str]) -> RangeRecording:
    """Return one moving case: ranges of every ``A<id>.csv``, the reference, GNSS and the published estimates.

    ``log.streams`` has ``gnss`` (n, 3) [m], NED from the first fix, ``gnss_sd`` (n, 3) [m] and ``gnss_status`` (n, 1),
    2 where the fix is RTK.  ``estimates`` has ``LS`` and ``ESKF``.  Signal powers are left out.

    Raises
    ------
    InputError : no anchor file or no trajectory, a damaged table, or an anchor that moves.
    """
    top = Path(folder)
    paths = {found[1]: path for path in sorted(top.glob("A*.csv")) if (found := _ANCHOR.fullmatch(path.name))}
    if not paths:
        raise InputError("no ranges", place=top.name, expected="files A<number>.csv", do="give the folder of one case")
    tables = {name: table(paths[name], EXPECTED) for name in sorted(paths, key=int)}
    ranges, origin = _ranges(tables)
    missing = [name for name in _OPTIONAL if not (top / name).is_file()]
    track = table(top / "trajectory.csv", EXPECTED)
    course = Stream(
        "course", _time(track, "timestamp", origin), -DEG * required(track, ("heading_degrees",)), "rad", "a"
    )
    gnss, info = ({}, {}) if "gnss.csv" in missing else _gnss(table(top / "gnss.csv", EXPECTED), origin)
    estimates = {
        name: _position(table(top / f"{name}.csv", EXPECTED), name, origin)
        for name in ("LS", "ESKF")
        if f"{name}.csv" not in missing
    }
    skipped = tuple(f"{name}: not there" for name in missing)
    log = Log(
        gnss, f"{top.parent.name}/{top.name}", CONVENTIONS, origin, skipped=skipped, info={"format": "HYU", **info}
    )
    return RangeRecording(ranges, log, {"position": _position(track, "position", origin), "course": course}, estimates)


def _ranges(tables: dict[str, Cells]) -> tuple[Ranges, int]:
    """Return the ranges of all anchors in time order, and the first stamp [ns]."""
    at = {name: stamps(cells, "field.stamp") for name, cells in tables.items()}
    origin = min(int(one[0]) for one in at.values())
    places = np.array([_place(cells, name) for name, cells in tables.items()])
    distance = np.concatenate([required(cells, ("field.distanceFromTag",))[:, 0] for cells in tables.values()])
    stamp = np.concatenate(list(at.values()))
    order = np.argsort(stamp, kind="stable")
    anchor = np.repeat(np.arange(len(tables)), [len(one) for one in at.values()])
    anchors = Anchors(tuple(tables), frd_from_flu(places))
    tag = np.zeros(len(order), np.int64)
    return Ranges(seconds(stamp[order], origin), anchor[order], tag, distance[order], anchors), origin


def _place(cells: Cells, name: str) -> Array:
    """Return where an anchor stands (3,) [m], source axes; its id and place must be the same in every row."""
    rows = required(cells, ("field.id", "field.x", "field.y", "field.z"))
    other = np.flatnonzero((rows != [int(name), *rows[0, 1:]]).any(axis=1))
    if other.size:
        place = cells.place("field.id", int(other[0]))
        raise unusable(cells.path, "another id or position", f"anchor {name} at one place", place=place)
    return rows[0, 1:]


def _time(cells: Cells, name: str, origin: int) -> Array:
    return seconds(stamps(cells, name), origin)


def _position(cells: Cells, name: str, origin: int) -> Stream:
    return Stream(name, _time(cells, "timestamp", origin), frd_from_flu(required(cells, ("x", "y", "z"))), "m", "a")


def _gnss(cells: Cells, origin: int) -> tuple[dict[str, Stream], dict[str, float]]:
    """Return the fixes in NED from the first one, their standard deviations and status, and where the first one is."""
    t = _time(cells, "field.header.stamp", origin)
    fix = required(cells, ("field.latitude", "field.longitude", "field.altitude"))
    if not ((np.abs(fix[:, 0]) <= 90) & (np.abs(fix[:, 1]) <= 180) & (np.abs(fix[:, 2]) < 1e5)).all():
        raise unusable(cells.path, "other numbers", "degrees and metres on the Earth", place="latitude to altitude")
    east_north_up = required(cells, tuple(f"field.position_covariance{k}" for k in (0, 4, 8)))
    if (east_north_up < 0).any():
        raise unusable(cells.path, "a negative variance", "variances [m^2]", place="position_covariance")
    streams = (
        Stream("gnss", t, _ned(fix), "m", "n"),
        Stream("gnss_sd", t, np.sqrt(east_north_up[:, [1, 0, 2]]), "m", "n"),
        Stream("gnss_status", t, required(cells, ("field.status.status",)), "1", "n"),
    )
    names = ("latitude_deg", "longitude_deg", "height_m")
    return {s.name: s for s in streams}, dict(zip(names, fix[0].tolist(), strict=True))


def _ned(fix: Array) -> Array:
    """Return fixes (n, 3) [deg, deg, m] in NED from the first, by the ellipsoid's radii there: 1e-5 of the distance."""
    latitude = fix[0, 0] * DEG
    w2 = 1 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2
    east = SEMI_MAJOR / np.sqrt(w2)
    north = east * (1 - ECCENTRICITY_SQUARED) / w2
    height = fix[0, 2]
    scale = np.array([DEG * (north + height), DEG * (east + height) * np.cos(latitude), -1.0])
    out: Array = (fix - fix[0]) * scale
    return out
