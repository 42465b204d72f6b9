"""Planar sets of the LIAS group: the pose of a trolley with three tags against motion capture."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

from robustnav.benchmark.lias_methods import followed_poses
from robustnav.benchmark.lias_pose import planar_poses
from robustnav.benchmark.uwb_scores import PUBLISHED, Figures, Results, no_recordings, scored, table
from robustnav.calibrate import BiasCurve, RangeCalibration, RangeLine
from robustnav.errors import InputError
from robustnav.evaluate.uwb_planar import PlanarPose, PoseReference, planar_figures
from robustnav.logs import read_uwb_lias, read_uwb_lias_sheet
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.records import Ranges
from robustnav.units import DEG

HEIGHT = -0.97  # m, z of the trolley in frame a; anchors and tags are too level to observe it
EVERY = 10  # rows; at 100 Hz neighbours say the same
TURNED = -7 * DEG  # of the tags about z down; the authors add 7 deg about z up in every set
CLOCK = -0.04  # s, where ranges agree best with motion capture
METRIC = (
    "planar position in metres and heading in degrees against motion capture, no alignment; the tags' axes are turned "
    f"by the authors' 7 deg, motion capture is taken {-CLOCK:g} s earlier; one row in {EVERY}, "
    "of least squares each by itself"
)
SHEET = "calibration.csv"
EXPECTED = "UWB_<name>.csv beside motion_capture_<name>.csv, and perhaps calibration.csv somewhere"
COLUMNS = {
    "2D_m": "rmse_2d",
    "95 % of 2D_m": "p95_2d",
    "worst 2D_m": "max_2d",
    "heading_deg": "yaw_rmse_deg",
    "mean heading_deg": "yaw_mean_deg",
    "samples": "samples",
}
PoseMethod = Callable[[RangeRecording], PlanarPose]
_RANGES = re.compile(r"UWB_(.+)\.csv")


class Case(NamedTuple):
    """Files of one recording: ``ranges`` and ``motion_capture``."""

    ranges: Path
    motion_capture: Path


def lias_cases(folder: str | os.PathLike[str]) -> dict[str, Case]:
    """Return the recordings in a folder by name, in order: ranges and motion capture side by side.

    Raises
    ------
    InputError : no such folder, none in it, ranges without motion capture, or a name twice.
    """
    top = Path(folder)
    out: dict[str, Case] = {}
    for path in sorted(top.rglob("UWB_*.csv")):
        hit = _RANGES.fullmatch(path.name)
        name = hit[1] if hit else path.stem
        beside = path.with_name(f"motion_capture_{name}.csv")
        if not beside.is_file():
            raise InputError("LIAS set", place=str(path), got="no motion capture beside it", expected=beside.name)
        if name in out:
            raise InputError(f"set {name} twice", place=str(folder), got=f"{out[name].ranges} and {path}")
        out[name] = Case(path, beside)
    if not out:
        raise no_recordings("LIAS sets", folder, EXPECTED, is_there=top.is_dir())
    return out


def default_methods(folder: str | os.PathLike[str]) -> dict[str, PoseMethod]:
    """Return our methods by name: ``least-squares-raw``, and on calibrated ranges, where a sheet is found, more.

    These are ``least-squares``, the causal filter ``ekf`` and its smoother ``rts``.

    Raises
    ------
    InputError : several sheets, or one that is none.
    """
    out: dict[str, PoseMethod] = {"least-squares-raw": lambda recording: _poses(recording.ranges)}
    sheets = sorted(Path(folder).rglob(SHEET))
    if len(sheets) > 1:
        raise InputError("calibration sheets", place=str(folder), got=f"{len(sheets)} {SHEET}", expected="one or none")
    if sheets:
        calibration = _calibration(sheets[0])
        out["least-squares"] = lambda recording: _poses(calibration.apply(recording.ranges))
        out["ekf"] = lambda recording: followed_poses(calibration.apply(recording.ranges), HEIGHT, EVERY)
        out["rts"] = lambda recording: followed_poses(calibration.apply(recording.ranges), HEIGHT, EVERY, smooth=True)
    return out


def benchmark_lias(
    folder: str | os.PathLike[str],
    methods: Mapping[str, PoseMethod] | None = None,
    *,
    progress: Callable[[], None] = lambda: None,
) -> Results:
    """Score our methods on every planar set in a folder; the authors publish plots only.

    Parameters
    ----------
    folder : with sets, see ``lias_cases``.
    methods : from a recording to poses, by name; None takes ``default_methods``.
    progress : called after every method of every set.

    Returns
    -------
    ``cases`` : by name ``published``, empty, and our methods with the figures of ``planar_figures``; one that failed
        has ``failed``, why.
    ``metric``.

    Raises
    ------
    InputError : as ``lias_cases``, ``default_methods`` and ``read_uwb_lias``.
    """
    chosen = default_methods(folder) if methods is None else methods
    cases: dict[str, Figures] = {}
    for name, case in lias_cases(folder).items():
        recording = read_uwb_lias(case.ranges, case.motion_capture)
        reference = PoseReference(recording.reference["position"], recording.reference["attitude"], CLOCK, TURNED)
        row = cases[name] = {PUBLISHED: {}}
        for method, pose in chosen.items():
            row[method] = scored(partial(_figures, recording, pose, reference))
            progress()
    return {"metric": METRIC, "cases": cases}


def tables(results: Results) -> list[tuple[str, list[dict[str, object]]]]:
    """Return the titled table of the results."""
    return [("Planar pose", table(results["cases"], COLUMNS))]


def _figures(recording: RangeRecording, method: PoseMethod, reference: PoseReference) -> Figures:
    return planar_figures(method(recording), reference)


def _poses(ranges: Ranges) -> PlanarPose:
    return planar_poses(ranges, HEIGHT, EVERY)


def _calibration(path: Path) -> RangeCalibration:
    sheet = read_uwb_lias_sheet(path)
    links = zip(sheet.anchor, sheet.tag, sheet.slope, sheet.bias, sheet.sd, strict=True)
    lines: dict[tuple[str, ...], RangeLine | BiasCurve] = {
        (anchor, tag): RangeLine(1 + slope, bias, sd**2) for anchor, tag, slope, bias, sd in links
    }
    return RangeCalibration("link", lines, path.name)
