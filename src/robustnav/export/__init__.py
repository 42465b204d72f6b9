"""A self-contained C99 tree from a model and a filter, for firmware: ``export(estimator, "firmware/ahrs")``."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from robustnav.errors import InputError
from robustnav.export.build import Exportable, build
from robustnav.export.emulator import NoEmulator, cost, require_tools
from robustnav.export.scaling import Counts
from robustnav.export.tree import Exported, cmake, readme, sources, write
from robustnav.export.unit import Unit

__all__ = ["Counts", "Exported", "build", "export", "measured"]

CORES = ("m4f", "m0+")


def export(
    estimator: Exportable,
    out: str | os.PathLike[str],
    *,
    name: str | None = None,
    real: str = "float",
    rate_hz: float | None = None,
    counts: Counts | None = None,
    measure: bool = True,
) -> Exported:
    """Write a filter as C99: sources, test vectors recorded from the Python filter, host programs, CMake, README.

    Parameters
    ----------
    estimator : ``H2`` on ``models.attitude``, ``LevelH2`` on ``models.inclination``, or ``EKF`` on any model.
    out : folder to write to; made if missing, files of these names replaced.
    name : prefix of every symbol; None: ``rn_<model>_<filter>``.
    real : ``float``, ``double``, or ``int32`` for the constant gain on raw counts.
    rate_hz : rate of the inputs [Hz]; None: the estimator's own, else 100.
    counts : of the sensors, for ``int32``; None: an MPU-9250's.
    measure : state the cost in the README where the cross compiler and the emulator are installed.

    Returns
    -------
    Exported : folder, name, files and measured cost.

    Raises
    ------
    InputError : no C form of this estimator in this type, an unusable name or rate, or a folder that is a file.
    MissingExtra : SymPy or symengine is not installed, for a covariance filter.
    """
    rate = float(rate_hz if rate_hz is not None else getattr(estimator, "rate_hz", 100.0))
    default = f"rn_{estimator.model.name}_{estimator.name}".replace("-", "_")
    if Path(out).exists() and not Path(out).is_dir():
        raise InputError("export folder", place=str(out), got="a file", expected="a folder, or nothing yet")
    unit, replay = build(estimator, name or default, real, rate, counts)
    files = sources(unit, replay)
    rows = measured(unit, files, CORES) if measure and _can_measure() else []
    files |= {"CMakeLists.txt": cmake(unit), "README.md": readme(unit, rows)}
    folder = write(out, files)
    return Exported(folder, unit.name, tuple(sorted(files)), tuple(rows))


def measured(
    unit: Unit, files: Mapping[str, str], cores: Sequence[str], works: int | None = None
) -> list[dict[str, object]]:
    """Return what each counted work of an exported filter costs on each core, one row a pair.

    Parameters
    ----------
    unit, files : of ``build`` and ``tree.sources``.
    cores : keys of ``boards.BOARDS``.
    works : how many of the unit's counted works, from the first; None: all.

    Raises
    ------
    NoEmulator : the cross compiler or the emulator is not installed.
    """
    rows: list[dict[str, object]] = []
    with tempfile.TemporaryDirectory() as work:
        folder = write(work, files)
        for core in cores:
            for k, counted in enumerate(unit.counted[:works]):
                found = cost(unit, folder, core, k)
                rows.append(
                    {
                        "core": core,
                        "work": counted.label,
                        "instructions": round(found.instructions),
                        "most": found.most,
                        "flash": found.flash,
                        "libraries": found.libraries,
                        "state": found.state,
                        "stack": found.stack,
                        "ram": found.ram,
                    }
                )
    return rows


def _can_measure() -> bool:
    try:
        require_tools()
    except NoEmulator:
        return False
    return True
