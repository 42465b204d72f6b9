"""Walks of the ISAS group: every method over every bag in a folder, by the trajectory error after alignment."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from robustnav.benchmark.isas_methods import isas_methods
from robustnav.benchmark.uwb_methods import Method
from robustnav.benchmark.uwb_scores import PUBLISHED, Figures, Results, no_recordings, scored, table
from robustnav.errors import InputError
from robustnav.evaluate.position import position_figures
from robustnav.evaluate.trajectory import SKIP, aligned_errors
from robustnav.logs import read_uwb_isas
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.records import Ranges, Stream
from robustnav.units import DEG

METRIC = (
    f"absolute trajectory error: best rotation and shift, no scale, rmse_* from {SKIP:g} s after the reference's first "
    "stamp, full_* without that rule, in metres; 2D is in the tracker's first two axes, which are not level; "
    "ours at the stamps of the ranges"
)
# The authors' configuration (toa_offset), m, added to the ranges of each anchor.
OFFSETS = {"7475": -0.0700, "9524": 0.1539, "10548": -0.0751, "15155": 0.1409, "20276": -0.0247}
EXPECTED = "a walk such as ISAS-Walk1.bag, or a folder with such bags"
COLUMNS = {
    "2D_m": "rmse_2d",
    "3D_m": "rmse_3d",
    "median 3D_m": "median_3d",
    "95 % of 3D_m": "p95_3d",
    "worst 3D_m": "max_3d",
    "turned_deg": "alignment_deg",
    "samples": "samples",
}


def isas_bags(folder: str | os.PathLike[str]) -> dict[str, Path]:
    """Return the bags in a folder by name, in order; a bag may be given itself.

    Raises
    ------
    InputError : nothing there, or two bags of one name.
    """
    top = Path(folder)
    found = [top] if top.is_file() else sorted(top.rglob("*.bag"))
    if not found:
        raise no_recordings("ISAS walks", folder, EXPECTED, is_there=top.is_dir())
    out = {path.stem: path for path in found}
    if len(out) < len(found):
        raise InputError("a walk twice", place=str(folder), got=", ".join(map(str, found))[:200])
    return out


def benchmark_isas(
    folder: str | os.PathLike[str],
    methods: Mapping[str, Method] | None = None,
    *,
    progress: Callable[[], None] = lambda: None,
) -> Results:
    """Score the vendor's own fix and our methods on every walk in a folder.

    Parameters
    ----------
    folder : with bags, or one bag.
    methods : from a recording to positions, by name; None takes ``isas_methods``.
    progress : called after every method of every walk.

    Returns
    -------
    ``cases`` : by bag ``published`` (``vendor``: the fix that the ranging system gave) and our methods; each has the
        figures of ``position_figures``, ``alignment_deg``, and all of them once more as ``full_...``.
    ``offsets`` : what was added to the ranges [m]; ``without_offset`` : by bag the anchors that have none.
    ``metric``.

    Raises
    ------
    MissingExtra : rosbags is not installed.
    InputError : as ``isas_bags`` and ``read_uwb_isas``.
    """
    chosen = isas_methods() if methods is None else methods
    cases: dict[str, Figures] = {}
    without: dict[str, list[str]] = {}
    for name, path in isas_bags(folder).items():
        recording = read_uwb_isas(path)
        without[name] = [anchor for anchor in recording.ranges.anchors.ids if anchor not in OFFSETS]
        recording = replace(recording, ranges=_calibrated(recording.ranges))
        cases[name] = _case(recording, chosen, progress)
    return {"metric": METRIC, "offsets": OFFSETS, "without_offset": without, "cases": cases}


def tables(results: Results) -> list[tuple[str, list[dict[str, object]]]]:
    """Return the titled table of the results."""
    return [("Trajectory error after alignment", table(results["cases"], COLUMNS))]


def _case(recording: RangeRecording, methods: Mapping[str, Method], progress: Callable[[], None]) -> Figures:
    vendor = partial(_figures, recording.estimates["vendor"], recording.reference["position"])
    out: Figures = {PUBLISHED: {"vendor": scored(vendor)}}
    for name, method in methods.items():
        out[name] = scored(partial(_method_figures, recording, method))
        progress()
    return out


def _method_figures(recording: RangeRecording, method: Method) -> Figures:
    t = np.unique(recording.ranges.t)
    return _figures(Stream("position", t, method(recording, t), "m", "a"), recording.reference["position"])


def _figures(path: Stream, reference: Stream) -> Figures:
    known = np.isfinite(path.values).all(axis=1)
    first = int(np.argmax(known)) if known.any() else 0
    started = Stream(path.name, path.t[first:], path.values[first:], path.unit, path.frame)
    out: Figures = {}
    for prefix, skip in (("", SKIP), ("full_", 0.0)):
        found = aligned_errors(started, reference, skip=skip)
        figures = position_figures(found.errors) | {"alignment_deg": found.alignment.angle / DEG}
        out |= {prefix + name: value for name, value in figures.items()} | {f"{prefix}unstarted": float(first)}
    return out


def _calibrated(ranges: Ranges) -> Ranges:
    offset = np.array([OFFSETS.get(anchor, 0.0) for anchor in ranges.anchors.ids])
    return replace(ranges, distance=ranges.distance + offset[ranges.anchor])
