"""The metric of the BROAD benchmark: Laidig, Caruso, Cereatti, Seel, Data 6(7), 2021, section 4."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.attitude import attitude_errors, rms_deg
from robustnav.records import Run, Truth

FIRST_DISTURBED, LAST = 24, 39
METRICS = ("total_deg", "heading_deg", "inclination_deg")


def trial_metric(run: Run, truth: Truth) -> dict[str, float]:
    """Return the metric of one trial: rms over samples in motion with a valid reference, no alignment of any kind.

    A constant heading offset therefore counts in full, and a NaN estimate makes the metric NaN.

    Returns
    -------
    ``total_deg``, ``heading_deg``, ``inclination_deg``, ``samples`` and ``nan_estimates``.

    Raises
    ------
    InputError : the truth marks no motion, or as ``attitude_errors``.
    """
    errors = attitude_errors(run, truth)
    scored = errors.referenced & errors.moving if errors.moving is not None else np.zeros(len(run.t), bool)
    if not scored.any():
        raise InputError(
            f"no sample in motion to score for {run.estimator}",
            got=f"{int(errors.referenced.sum())} samples with a reference, none of them marked as moving",
            expected="a truth with `moving`, on the clock of the run",
        )
    missing = float(np.isnan(errors.total[scored]).sum())
    return rms_deg(errors, scored) | {"samples": float(scored.sum()), "nan_estimates": missing}


def trial_group(name: str) -> str:
    """Return ``undisturbed`` (trials 01 to 23) or ``disturbed`` (24 to 39) from a trial's name, ``07_...``.

    Raises
    ------
    InputError : the name does not start with a trial number from 01 to 39.
    """
    found = re.match(r"(\d{2})(?!\d)", name, re.ASCII)
    number = int(found[1]) if found else 0
    if not 1 <= number <= LAST:
        raise InputError("trial name", got=repr(name), expected=f"a name that starts with 01 to {LAST}, as in '07_...'")
    return "disturbed" if number >= FIRST_DISTURBED else "undisturbed"


def group_means(trials: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Return the mean over trials of each metric for ``undisturbed``, ``disturbed`` and ``all``.

    Parameters
    ----------
    trials : ``trial_metric`` by trial name, e.g. ``25_disturbed_tapping_B``.

    Returns
    -------
    By group: ``total_deg``, ``heading_deg``, ``inclination_deg`` (NaN for a group without trials) and ``trials``.
    """
    groups: dict[str, list[Mapping[str, float]]] = {"undisturbed": [], "disturbed": [], "all": []}
    for name, metric in trials.items():
        groups[trial_group(name)].append(metric)
        groups["all"].append(metric)
    return {
        group: {m: float(np.mean([row[m] for row in rows])) if rows else float("nan") for m in METRICS}
        | {"trials": float(len(rows))}
        for group, rows in groups.items()
    }
