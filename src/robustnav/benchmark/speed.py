"""The speed benchmark: time of a step for our filters and for every peer that is installed, side by side."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from robustnav.benchmark.peer import load, version_of
from robustnav.benchmark.timing import Work, time_rounds
from robustnav.benchmark.works import WORKS
from robustnav.errors import InputError
from robustnav.frames import Array

SECONDS, ROUNDS, SAMPLES = 1.0, 15, 12_000
CLOCK = "processor time, one thread, garbage collection off; ns is the median over rounds"
RATIO = "median over rounds of the row's time over the baseline's in the same round"


def steps_of(repeats: int = ROUNDS, works: Sequence[Work] = WORKS) -> int:
    """Return how often ``benchmark_speed`` calls ``progress``."""
    return repeats * len(works)


def benchmark_speed(
    *,
    seconds: float = SECONDS,
    repeats: int = ROUNDS,
    samples: int = SAMPLES,
    works: Sequence[Work] = WORKS,
    progress: Callable[[], None] = lambda: None,
) -> dict[str, Any]:
    """Time every row of every work.

    Parameters
    ----------
    seconds : about how long each row is timed, over all rounds [s].
    repeats : rounds in which the rows of a work take turns.
    samples : of the inputs, for the fastest rows; slower ones take the first of them, see ``steps``.
    works : what is timed.
    progress : called ``steps_of(repeats, works)`` times.

    Returns
    -------
    ``rows`` : each with ``work``, ``name``, ``ns`` a step, ``least_ns`` of any round, ``steps`` a pass, ``ratio`` by
        baseline of the same work, and ``baseline``: whether it is one.
    ``missing`` : by row name the module that it needs.
    ``machine``, ``works`` (what a step is and what it is fed), ``clock``, ``ratio``.

    Raises
    ------
    InputError : a number is not positive, or too few samples.
    EstimatorError : a row's filter does not estimate.
    """
    if not (0 < seconds < np.inf and repeats >= 1 and samples >= 2):
        got = f"seconds {seconds}, repeats {repeats}, samples {samples}"
        raise InputError("speed benchmark", got=got, expected="seconds above zero, repeats from 1, samples from 2")
    rows: list[dict[str, Any]] = []
    missing: dict[str, str] = {}
    for work in works:
        absent = {name: e.needs for name, e in work.entries.items() if e.needs and load(e.needs) is None}
        missing |= absent
        contenders = {name: e.make(samples) for name, e in work.entries.items() if name not in absent}
        times = time_rounds(contenders, seconds, repeats, progress)
        rows += [
            {**_row(work, name, times), "steps": contenders[name].steps, "baseline": work.entries[name].baseline}
            for name in contenders
        ]
    return {
        "machine": machine(),
        "clock": CLOCK,
        "ratio": RATIO,
        "works": {work.name: {"step": work.step, "inputs": work.inputs} for work in works},
        "rows": rows,
        "missing": missing,
    }


def tables(results: dict[str, Any]) -> list[tuple[str, list[dict[str, object]]]]:
    """Return one titled table a work; ``x of NAME`` columns are ratios to that baseline, three digits each."""
    out: list[tuple[str, list[dict[str, object]]]] = []
    for name, about in results["works"].items():
        shown: list[dict[str, object]] = [
            {"name": row["name"], "ns": row["ns"], "least_ns": row["least_ns"]}
            | {f"x of {baseline}": f"{ratio:.3g}" for baseline, ratio in row["ratio"].items()}
            for row in results["rows"]
            if row["work"] == name
        ]
        out.append((f"{name}: {about['step']}", shown))
    return out


def machine() -> dict[str, str]:
    """Return what the figures were measured on: processor, system and the versions that matter."""
    out = {
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "robustnav": version_of("robustnav"),
    }
    return out | {name: version_of(name) for name in ("vqf", "imufusion", "filterpy") if load(name) is not None}


def _processor() -> str:
    listed = Path("/proc/cpuinfo")
    if listed.is_file():
        for line in listed.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown"


def _row(work: Work, name: str, times: dict[str, Array]) -> dict[str, Any]:
    own = times[name]
    ratio = {other: float(np.median(own / t)) for other, t in times.items() if work.entries[other].baseline}
    return {
        "work": work.name,
        "name": name,
        "ns": float(np.median(own)),
        "least_ns": float(own.min()),
        "ratio": ratio,
    }
