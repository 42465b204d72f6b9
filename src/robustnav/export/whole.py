"""From an estimator to a folder of C, with the measured cost where the tools are installed."""

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

CORES = ("m4f", "m0+")


def export_tree(
    estimator: Exportable,
    out: str | os.PathLike[str],
    *,
    name: str | None,
    real: str,
    rate_hz: float | None,
    counts: Counts | None,
    measure: bool,
) -> Exported:
    """Write a filter as C99; see ``robustnav.export.export``."""
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
