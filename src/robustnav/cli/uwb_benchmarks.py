"""``benchmark uwb-hyu``, ``uwb-isas``, ``uwb-lias``: positions from ranges on public recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from robustnav.cli.options import Flag
from robustnav.cli.show import note, progress, say_json, say_table


def uwb_hyu(folder: Path, *, json: Flag = False, quiet: Flag = False) -> None:
    """Score positions on the moving cases of the HYU outdoor set with its authors' metric.

    Parameters
    ----------
    folder
        Folder with any number of cases, LOS/Trajectory_A/Case_1 and so on, or one of them.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    from robustnav.benchmark import uwb_hyu as bench
    from robustnav.benchmark.hyu_cases import hyu_cases
    from robustnav.benchmark.hyu_methods import hyu_methods

    methods = hyu_methods()
    with progress("HYU", len(hyu_cases(folder)) * len(methods), quiet=quiet) as step:
        results = bench.benchmark_hyu(folder, methods, progress=step)
    _say(results, bench.tables(results), json=json)


def uwb_isas(folder: Path, *, json: Flag = False, quiet: Flag = False) -> None:
    """Score positions on walks of the ISAS group by the trajectory error after alignment.

    Parameters
    ----------
    folder
        Folder with bags, or one bag.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    from robustnav.benchmark import uwb_isas as bench
    from robustnav.benchmark.isas_methods import isas_methods

    methods = isas_methods()
    with progress("ISAS", len(bench.isas_bags(folder)) * len(methods), quiet=quiet) as step:
        results = bench.benchmark_isas(folder, methods, progress=step)
    _say(results, bench.tables(results), json=json)
    for case, anchors in results["without_offset"].items():
        if anchors and not json:
            note(f"{case}: no range offset is known for anchors {', '.join(anchors)}")


def uwb_lias(folder: Path, *, json: Flag = False, quiet: Flag = False) -> None:
    """Score planar poses on the sets of the LIAS group.

    Parameters
    ----------
    folder
        Folder with UWB_<name>.csv and motion_capture_<name>.csv, and the calibration sheet if there is one.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    from robustnav.benchmark import uwb_lias as bench

    methods = bench.default_methods(folder)
    with progress("LIAS", len(bench.lias_cases(folder)) * len(methods), quiet=quiet) as step:
        results = bench.benchmark_lias(folder, methods, progress=step)
    _say(results, bench.tables(results), json=json)


COMMANDS = (uwb_hyu, uwb_isas, uwb_lias)


def _say(results: dict[str, Any], tables: list[tuple[str, list[dict[str, object]]]], *, json: bool) -> None:
    if json:
        say_json(results)
        return
    for title, rows in tables:
        say_table(title, rows)
    note(results["metric"])
