"""The HYU outdoor set: every method over every case in a folder, beside the authors' own estimates."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from robustnav.benchmark.hyu_cases import Case, hyu_cases, printed_figures
from robustnav.benchmark.uwb_methods import METHODS, Method
from robustnav.benchmark.uwb_scores import PUBLISHED, Figures, Results, mean_table, means, scored, table
from robustnav.errors import InputError
from robustnav.evaluate.position import position_figures
from robustnav.evaluate.uwb_hyu import Window, hyu_errors, hyu_window, in_reference, in_window
from robustnav.logs import read_uwb_hyu
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.records import Array

METRIC = (
    "rmse_*: the authors' metric, inside their window of the path, reference within 0.5 m of its starting height; "
    "full_*: over the whole reference; both in metres, no alignment, tag taken 1 m above the reference; "
    "ours at the stamps of the published ESKF"
)
COLUMNS = {
    "2D_m": "rmse_2d",
    "3D_m": "rmse_3d",
    "95 % of 3D_m": "p95_3d",
    "samples": "samples",
    "full 2D_m": "full_rmse_2d",
    "full 3D_m": "full_rmse_3d",
    "full worst_m": "full_max_3d",
    "full samples": "full_samples",
}
MEANS = ("rmse_2d", "rmse_3d", "full_rmse_2d", "full_rmse_3d")
MEAN_COLUMNS = {heading: key for heading, key in COLUMNS.items() if key in MEANS} | {"cases": "cases"}


def benchmark_hyu(
    folder: str | os.PathLike[str],
    methods: Mapping[str, Method] = METHODS,
    *,
    progress: Callable[[], None] = lambda: None,
) -> Results:
    """Score the published estimates and our methods on every case in a folder.

    Parameters
    ----------
    folder : with cases, see ``hyu_cases``.
    methods : ours, by name.
    progress : called after every method of every case.

    Returns
    -------
    ``cases`` : by name ``published`` (``ls``, ``eskf``) and our methods; each has the figures of ``position_figures``
        inside the metric's window, and over the whole reference as ``full_...``; one that failed has ``failed``, why.
    ``means`` : by method the means over cases.
    ``printed`` : by case what the authors printed, and by how much our reckoning of it differs [m].
    ``trajectories``, ``metric``.

    Raises
    ------
    InputError : as ``hyu_cases`` and ``read_uwb_hyu``; no published estimates; a reference without the window.
    """
    found = hyu_cases(folder)
    cases: dict[str, Figures] = {}
    printed: dict[str, Figures] = {}
    for name, case in found.items():
        cases[name] = _case(case, methods, progress)
        printed[name] = _printed(case, cases[name][PUBLISHED])
    return {
        "metric": METRIC,
        "trajectories": {name: case.trajectory for name, case in found.items()},
        "cases": cases,
        "means": means(cases, MEANS),
        "printed": printed,
    }


def tables(results: Results) -> list[tuple[str, list[dict[str, object]]]]:
    """Return the titled tables of the results."""
    return [
        ("RMSE by case", table(results["cases"], COLUMNS)),
        ("Mean RMSE over cases", mean_table(results["means"], MEAN_COLUMNS)),
    ]


def _case(case: Case, methods: Mapping[str, Method], progress: Callable[[], None]) -> Figures:
    recording = read_uwb_hyu(case.folder)
    missing = {"LS", "ESKF"} - set(recording.estimates)
    if missing:
        got = f"no {' and no '.join(sorted(missing))}.csv"
        expected = "the authors' LS.csv and ESKF.csv: what is compared, and when"
        raise InputError("HYU case", place=recording.log.source, got=got, expected=expected)
    window = hyu_window(recording, case.trajectory)
    out: Figures = {
        PUBLISHED: {
            name.lower(): scored(partial(_figures, recording, window, estimate.t, estimate.values))
            for name, estimate in recording.estimates.items()
        }
    }
    for name, method in methods.items():
        out[name] = scored(partial(_method_figures, recording, window, method))
        progress()
    return out


def _method_figures(recording: RangeRecording, window: Window, method: Method) -> Figures:
    t = recording.estimates["ESKF"].t
    return _figures(recording, window, t, method(recording, t))


def _figures(recording: RangeRecording, window: Window, t: Array, p_a: Array) -> Figures:
    if p_a.shape != (len(t), 3):
        raise InputError("positions of a method", got=f"shape {p_a.shape}", expected=f"shape ({len(t)}, 3)")
    here, there = in_window(recording, t, window), in_reference(recording, t)
    inside = position_figures(hyu_errors(recording, t[here], p_a[here], window))
    full = position_figures(hyu_errors(recording, t[there], p_a[there]))
    return inside | {f"full_{name}": value for name, value in full.items()}


def _printed(case: Case, published: Figures) -> Figures:
    figures = printed_figures(case.folder)
    differences = [abs(published[m][key] - value) for m, row in figures.items() for key, value in row.items()]
    return {**figures, "difference_m": float(np.max(differences))} if differences else {}
