"""What a run is worth, in one sentence and its reasons."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from robustnav.evaluate.attitude import NOT_AN_ERROR
from robustnav.evaluate.consistency import nis
from robustnav.records import Innovations, Run, Score
from robustnav.report.figures.innovations import refusals
from robustnav.report.page import Level

if TYPE_CHECKING:
    from robustnav.doctor.record import Diagnosis

MAX_REFUSED = 0.10  # share of readings; more means model and sensor do not agree
MAX_NIS_FACTOR = 2.0  # mean NIS over its expectation, up or down; innovations off by a factor of 1.4


@dataclass(frozen=True)
class Verdict:
    """What a run is worth.

    ``level``: ``error`` is not to be used, ``warning`` is to be read with its ``reasons``, ``info`` has no covariance
    that could be tested, ``ok`` passed.
    """

    level: Level
    text: str
    reasons: tuple[str, ...] = ()


def judge(run: Run, score: Score | None, diagnosis: Diagnosis | None = None) -> Verdict:
    """Return the verdict on a run from its numbers, its innovations, its events and the doctor's findings."""
    failures = [
        f"State block {name} holds NaN from {run.t[np.isnan(block).any(axis=1)][0]:.3f} s on."
        for name, block in run.state.items()
        if np.isnan(block).any()
    ]
    doubts = [doubt for sensor, data in run.innovations.items() for doubt in _doubts(sensor, data)]
    if score is not None and np.isnan(score.values.get("total_deg", 0.0)):
        failures.append("The score is NaN: an estimate is missing where there is a reference.")
    if run.events:
        doubts.append(f"Events during the run: {len(run.events)}, listed below.")
    if diagnosis is not None:
        failures += [f"Doctor: {one.thing}: {one.got}." for one in diagnosis.at("error")]
        doubts += [f"Doctor: {one.thing}: {one.got}." for one in diagnosis.at("warning")]
    level: Level = "error" if failures else "warning" if doubts else "ok"
    if level == "ok" and not any(_has_nis(data) for data in run.innovations.values()):
        level, doubts = "info", ["No innovation has a predicted variance: consistency is not tested."]
    return Verdict(level, _sentence(run, score), tuple(failures + doubts))


def innovation_rows(innovations: Mapping[str, Innovations]) -> list[dict[str, object]]:
    """Return one row a sensor: readings, refused, missing, and its NIS where the filter has a covariance."""
    rows: list[dict[str, object]] = []
    for sensor, data in innovations.items():
        refused, missing = refusals(data)
        row: dict[str, object] = {"sensor": sensor, "readings": len(data.t), "refused": refused, "missing": missing}
        test = nis([data]) if _has_nis(data) else None
        row["mean_nis"] = test.mean if test else None
        row["expected"] = test.dof if test else None
        row["inside_95_%"] = 100 * test.inside if test else None
        rows.append(row)
    return rows


def _has_nis(data: Innovations) -> bool:
    return bool((np.isfinite(data.z).all(axis=1) & np.isfinite(data.nis)).any())


def _doubts(sensor: str, data: Innovations) -> list[str]:
    doubts = []
    refused, _ = refusals(data)
    if len(data.t) and refused > MAX_REFUSED * len(data.t):
        doubts.append(f"{sensor}: {100 * refused / len(data.t):.1f} % of the readings refused.")
    if _has_nis(data):
        test = nis([data])
        factor = test.mean / test.dof
        if factor > MAX_NIS_FACTOR:
            doubts.append(f"{sensor}: NIS {factor:.3g} times its expectation; the filter trusts itself too much.")
        elif factor < 1 / MAX_NIS_FACTOR:
            doubts.append(f"{sensor}: NIS {factor:.3g} times its expectation; the filter trusts itself too little.")
    return doubts


def _sentence(run: Run, score: Score | None) -> str:
    if score is None or "total_deg" not in score.values:
        return f"{run.estimator} ran over {len(run.t)} samples; there is no reference to score it against."
    total = score.values["total_deg"]
    if np.isnan(total):
        return f"{run.estimator} has no score."
    what = NOT_AN_ERROR if NOT_AN_ERROR in score.notes else "attitude error"
    return f"{run.estimator}: {total:.3g} deg RMS {what}, over {score.samples} samples."
