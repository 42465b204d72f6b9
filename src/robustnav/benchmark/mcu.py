"""The cost of exported filters on Cortex-M cores: instructions, flash, RAM, beside peers compiled from their source."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robustnav.benchmark.mcu_peers import peers_in
from robustnav.errors import InputError
from robustnav.export.boards import BOARDS
from robustnav.export.build import Exportable, build
from robustnav.export.emulator import FAST, cost, count, require_tools
from robustnav.export.tree import sources, write
from robustnav.models import uwb
from robustnav.models.inclination import inclination
from robustnav.run import EKF, H2
from robustnav.run.inclination import LevelH2
from robustnav.studies.attitude_setting import noise, quaternion_model

RATE_HZ = 100.0  # of the attitude study, whose filters are counted
ABOUT = (
    "Instructions executed inside the functions of one update, returns included: exact, under an emulator; not cycles. "
    f"Compiled with {' '.join(FAST)}. Flash: what reset and the update link, libm and libgcc included. RAM: state and "
    "painted stack."
)


@dataclass(frozen=True)
class Filter:
    """One row: how the estimator is made, its number type, which of its counted works."""

    make: Callable[[], Exportable]
    real: str = "float"
    work: str = "update"


def _nine(start: str | None = "steady") -> H2:
    return H2(quaternion_model(noise(RATE_HZ)), RATE_HZ, start_sd=start)


def _six() -> LevelH2:
    return LevelH2(inclination(noise(RATE_HZ)), RATE_HZ, steady=True)


def _mekf() -> EKF:
    return EKF(quaternion_model(noise(RATE_HZ)))


def _ranges() -> EKF:
    return EKF(uwb(range_sd=0.1, acceleration_density=1.0))


FILTERS = {
    "h2-6axis": Filter(_six),
    "h2-9axis": Filter(_nine),
    "h2-9axis-int32": Filter(_nine, "int32"),
    "h2-9axis-schedule": Filter(lambda: _nine(None)),
    "mekf-9axis": Filter(_mekf),
    "uwb-3d-range": Filter(_ranges, work="update_range"),
}


@dataclass(frozen=True)
class Plan:
    """What is counted: filters and cores by name."""

    filters: tuple[str, ...]
    cores: tuple[str, ...]


def plan(filters: Sequence[str] | None = None, cores: Sequence[str] | None = None) -> Plan:
    """Return a plan; None takes all.

    Raises
    ------
    InputError : an unknown filter or core.
    """
    wanted = Plan(tuple(filters or FILTERS), tuple(cores or BOARDS))
    for name, names, kind in ((wanted.filters, FILTERS, "filter"), (wanted.cores, BOARDS, "core")):
        strange = [n for n in name if n not in names]
        if strange:
            raise InputError(f"{kind} {strange[0]!r}", expected=", ".join(names))
    return wanted


def steps_of(wanted: Plan, peer_sources: Sequence[Path] = ()) -> int:
    """Return how often ``benchmark_mcu`` calls ``progress``."""
    return (len(wanted.filters) + len(peers_in(peer_sources))) * len(wanted.cores)


def benchmark_mcu(
    wanted: Plan, *, peer_sources: Sequence[Path] = (), progress: Callable[[], None] = lambda: None
) -> dict[str, Any]:
    """Count every filter, and every peer found in ``peer_sources``, on every core.

    Returns
    -------
    ``rows``: each with ``filter``, ``type``, ``core``, ``instructions`` (mean), ``most``, ``flash``, ``libraries``,
    ``ram``, ``state``, ``stack``; ``about``.

    Raises
    ------
    NoEmulator : the cross compiler or the emulator is not installed.
    InputError : a folder without a known peer's sources.
    """
    require_tools()
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as work:
        for name in wanted.filters:
            chosen = FILTERS[name]
            unit, replay = build(chosen.make(), name.replace("-", "_"), chosen.real, RATE_HZ)
            folder = write(Path(work) / name, sources(unit, replay))
            number = [c.label for c in unit.counted].index(chosen.work)
            for core in wanted.cores:
                label = name.removesuffix("-int32")
                rows.append(_row(label, chosen.real, core, cost(unit, folder, core, number)))
                progress()
        for peer in peers_in(peer_sources):
            program = peer.program(Path(work) / peer.name, RATE_HZ)
            for core in wanted.cores:
                rows.append(_row(peer.name, "float", core, count(program, core, Path(work) / peer.name / core)))
                progress()
    return {"rows": rows, "about": ABOUT}


def shown(results: dict[str, Any]) -> list[dict[str, object]]:
    """Return the rows of a table."""
    columns = ("filter", "type", "core", "instructions", "most", "flash", "ram", "state", "stack")
    return [{c: row[c] for c in columns} for row in results["rows"]]


def _row(name: str, real: str, core: str, found: Any) -> dict[str, Any]:
    return {
        "filter": name,
        "type": real,
        "core": core,
        "instructions": round(found.instructions),
        "most": found.most,
        "flash": found.flash,
        "libraries": found.libraries,
        "ram": found.ram,
        "state": found.state,
        "stack": found.stack,
    }
