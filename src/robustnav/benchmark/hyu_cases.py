"""The cases of the HYU outdoor set in a folder, found by their files, and what their authors printed."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from robustnav.benchmark.uwb_scores import no_recordings
from robustnav.errors import InputError
from robustnav.evaluate.uwb_hyu import Trajectory
from robustnav.logs.files import checked_path, read_text, unusable

EXPECTED = "folders such as LOS/Trajectory_A/Case_1 with A3.csv, ..., trajectory.csv, LS.csv, ESKF.csv"
PRINTED = "RMSD_results.txt"
_ANCHOR = re.compile(r"A\d{1,9}\.csv")
_TRAJECTORY = re.compile(r"trajectory[ _-]?([ab])", re.IGNORECASE)
_SIGHT = re.compile(r"n?los", re.IGNORECASE)
_PRINTED = re.compile(r"(LS|ESKF) RMSE(_2d)?: (\d{1,9}(?:\.\d{1,30})?)(?: m)?", re.ASCII)


@dataclass(frozen=True)
class Case:
    """One case: ``folder`` with its files, and its ``trajectory``, which decides the window of the metric."""

    folder: Path
    trajectory: Trajectory


def hyu_cases(folder: str | os.PathLike[str]) -> dict[str, Case]:
    """Return the cases in a folder by name, in order; the folder may be a case itself, and any nesting will do.

    A case is a folder that holds ``A<number>.csv``.  Its name begins where its path says LOS or NLOS, and somewhere the
    path must say ``Trajectory_A`` or ``Trajectory_B``; of several the nearest counts.

    Raises
    ------
    InputError : no such folder, no case in it, a path that names no trajectory, or two cases of one name.
    """
    top = Path(folder).resolve()
    found = {path.parent for path in top.rglob("A*.csv") if _ANCHOR.fullmatch(path.name)} if top.is_dir() else set()
    if not found:
        raise no_recordings("HYU cases", folder, EXPECTED, is_there=top.is_dir())
    out: dict[str, Case] = {}
    for place in sorted(found):
        name = _name(place)
        if name in out:
            raise InputError(f"case {name} twice", place=str(folder), got=f"{out[name].folder} and {place}")
        out[name] = Case(place, _trajectory(place))
    return out


def printed_figures(folder: Path) -> dict[str, dict[str, float]]:
    """Return what the authors printed for a case, ``rmse_3d`` and ``rmse_2d`` [m] of ``ls`` and ``eskf``.

    Empty where there is no ``RMSD_results.txt``.

    Raises
    ------
    InputError : a file with other lines.
    """
    if not (folder / PRINTED).exists():
        return {}
    path = checked_path(folder / PRINTED, "four lines such as 'LS RMSE_2d: 1.03'")
    lines = [line.strip() for line in read_text(path, "text").splitlines() if line.strip()]
    out: dict[str, dict[str, float]] = {}
    for number, line in enumerate(lines, start=1):
        hit = _PRINTED.fullmatch(line)
        if not hit:
            raise unusable(path, repr(line[:40]), "a line such as 'LS RMSE_2d: 1.03'", place=f"line {number}")
        out.setdefault(hit[1].lower(), {})["rmse_2d" if hit[2] else "rmse_3d"] = float(hit[3])
    return out


def _trajectory(place: Path) -> Trajectory:
    for part in reversed(place.parts):
        hit = _TRAJECTORY.search(part)
        if hit:
            return cast(Trajectory, hit[1].upper())
    expected = "Trajectory_A or Trajectory_B in its path: the metric's window depends on it"
    raise InputError("HYU case", place=str(place), got="no trajectory named", expected=expected, do="rename its folder")


def _name(place: Path) -> str:
    parts = place.parts
    sights = [k for k, part in enumerate(parts) if _SIGHT.fullmatch(part)]
    return "/".join(parts[sights[-1] if sights else -2 :])
