"""The BROAD benchmark: every estimator over every trial in a folder, scored by the benchmark's own metric.

D. Laidig, M. Caruso, A. Cereatti, T. Seel, BROAD - A Benchmark for Robust Inertial Orientation Estimation, Data 6(7),
2021, section 4.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from robustnav import datasheet
from robustnav.benchmark.peer import version_of
from robustnav.benchmark.peers import PEERS, installed_peers, missing_peers
from robustnav.errors import InputError
from robustnav.evaluate.broad import METRICS, group_means, trial_group, trial_metric
from robustnav.logs.reading import read
from robustnav.records import Log
from robustnav.run.recorded import ESTIMATORS, Sensors, run_recorded

Results = dict[str, Any]
METRIC = "rms over samples in motion with a reference, no alignment; group figures are means over trials"


def default_estimators() -> list[str]:
    """Return the estimators compared when none are named: ``h2``, ``mekf`` and every peer that is installed."""
    return ["h2", "mekf", *installed_peers()]


def trial_files(folder: str | os.PathLike[str]) -> list[Path]:
    """Return the trials in a folder, in order: its files ``NN_*.mat``.

    Raises
    ------
    InputError : no such folder, no .mat file in it, a name without a trial number, or two files of one number.
    """
    place = Path(folder)
    files = sorted(place.glob("*.mat")) if place.is_dir() else []
    if not files:
        raise InputError(
            "no BROAD trials",
            place=str(place),
            got="no .mat file" if place.is_dir() else "not a folder",
            expected="a folder with trials such as 07_undisturbed_fast_rotation_B.mat",
        )
    first: dict[str, Path] = {}
    for file in files:
        trial_group(file.name)
        other = first.setdefault(file.name[:2], file)
        if other is not file:
            raise InputError(f"trial {file.name[:2]} twice", place=str(place), got=f"{other.name} and {file.name}")
    return files


def benchmark_broad(
    folder: str | os.PathLike[str],
    estimators: Sequence[str] | None = None,
    *,
    sensors: Sensors,
    progress: Callable[[], None] = lambda: None,
) -> Results:
    """Run and score estimators over the trials in a folder.

    Parameters
    ----------
    folder : with the trials, see ``trial_files``.
    estimators : names of ours (``robustnav.run.recorded.ESTIMATORS``) and of peers (``PEERS``); None takes
        ``default_estimators()``.  A peer that is not installed is left out.
    sensors : data-sheet presets that tell our filters their noise; the peers have settings of their own.
    progress : called after every run.

    Returns
    -------
    ``trials`` : by number and estimator ``total_deg``, ``heading_deg``, ``inclination_deg``, ``samples`` and
        ``nan_estimates``; an estimator that failed has NaN figures and ``failed``, why.
    ``estimators`` : by name and group (``undisturbed``, ``disturbed``, ``all``; a group without trials is left out) the
        means over trials and the number of ``trials``; NaN means and their number as ``failed`` where any failed.
    ``missing_peers``, ``smoothers``, ``settings``, ``metric``.

    Raises
    ------
    InputError : unknown estimator or preset, or as ``trial_files`` and ``robustnav.logs.read``, naming the file.
    """
    files = trial_files(folder)
    missing = missing_peers()
    names = [name for name in _known(estimators) if name not in missing]
    datasheet.imu(sensors.imu)  # a misspelt preset is an error, not a failed trial
    datasheet.magnetometer(sensors.magnetometer)
    trials: dict[str, dict[str, dict[str, Any]]] = {}
    for file in files:
        log = read(file)
        row = trials[file.name[:2]] = {}
        for name in names:
            row[name] = _scored(name, log, sensors)
            progress()
    return {
        "metric": METRIC,
        "settings": _settings(names, sensors),
        "estimators": {name: _groups({number: row[name] for number, row in trials.items()}) for name in names},
        "trials": trials,
        "smoothers": [name for name in names if name in PEERS and PEERS[name].smoother],
        "missing_peers": list(missing),
    }


def trial_rows(results: Results) -> list[dict[str, object]]:
    """Return a table's rows, one a trial and estimator."""
    shown = [(number, name, metric) for number, row in results["trials"].items() for name, metric in row.items()]
    failed = any("failed" in metric for *_, metric in shown)
    return [
        {"trial": number, "group": trial_group(number), "estimator": name}
        | {key: metric[key] for key in (*METRICS, "samples", "nan_estimates")}
        | ({"failed": metric.get("failed", "").replace("\n", "; ")} if failed else {})
        for number, name, metric in shown
    ]


def group_rows(results: Results) -> list[dict[str, object]]:
    """Return a table's rows, one an estimator: mean total by group, all means over all trials."""
    rows: list[dict[str, object]] = []
    for name, groups in results["estimators"].items():
        row: dict[str, object] = {
            "estimator": name,
            "kind": "smoother" if name in results["smoothers"] else "online",
        }
        row |= {f"{group}_total_deg": figures["total_deg"] for group, figures in groups.items()}
        row |= {key: groups["all"][key] for key in ("heading_deg", "inclination_deg", "trials", "failed")}
        rows.append(row)
    return rows


def _known(estimators: Sequence[str] | None) -> list[str]:
    names = list(dict.fromkeys(default_estimators() if estimators is None else estimators))
    for name in names:
        if name not in ESTIMATORS and name not in PEERS:
            raise InputError(f"estimator {name!r}", expected=", ".join((*ESTIMATORS, *PEERS)))
    return names


def _scored(name: str, log: Log, sensors: Sensors) -> dict[str, Any]:
    if log.truth is None:
        raise InputError("no truth to score against", place=log.source)
    try:
        run = PEERS[name].run(log) if name in PEERS else run_recorded(name, log, sensors)
        metric = trial_metric(run, log.truth)
    except (ArithmeticError, ValueError) as why:  # ours are ValueErrors: reported beside the others, never dropped
        return dict.fromkeys(METRICS, float("nan")) | {"samples": 0, "nan_estimates": 0, "failed": str(why)}
    out: dict[str, Any] = {key: metric[key] for key in METRICS}
    out |= {key: int(metric[key]) for key in ("samples", "nan_estimates")}
    if out["nan_estimates"]:
        out["failed"] = f"{out['nan_estimates']} of {out['samples']} scored estimates are NaN"
    return out


def _groups(trials: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    failed = [number for number, metric in trials.items() if "failed" in metric]
    return {
        group: {key: figures[key] for key in METRICS}
        | {"trials": int(figures["trials"])}
        | {"failed": sum(group in ("all", trial_group(number)) for number in failed)}
        for group, figures in group_means(trials).items()
        if figures["trials"]
    }


def _settings(names: Sequence[str], sensors: Sensors) -> dict[str, object]:
    out: dict[str, object] = {"imu": sensors.imu, "magnetometer": sensors.magnetometer}
    for name in names:
        if name in PEERS:
            module = PEERS[name].module
            out[name] = {"library": f"{module} {version_of(module)}", **PEERS[name].settings}
    return out
