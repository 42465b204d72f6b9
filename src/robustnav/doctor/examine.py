"""``examine``: the checks in their order, then the words."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from robustnav.doctor import judge_axes, judge_log, judge_sensors
from robustnav.doctor.measure import Numbers, measure
from robustnav.doctor.record import Diagnosis, Finding
from robustnav.records import Log

CHECKS = (
    judge_sensors.judge_force,
    judge_sensors.judge_field,
    judge_axes.judge_gravity,
    judge_axes.judge_dip,
    judge_axes.judge_attitude,
    judge_axes.judge_vectors,
    judge_axes.judge_scale,
    judge_axes.judge_lag,
    judge_axes.judge_rotation,
    judge_log.judge_heading,
    judge_log.judge_reference,
    judge_log.judge_motion,
    judge_log.judge_notes,
)


def examine(log: Log) -> Diagnosis:
    """Return what is in a recording and what is suspicious about its time, units, signs, axes and reference.

    Nothing is changed and no setting is needed.  Axes, signs of the gyro, scale and lag are judged only where the
    vehicle turned enough.  Time that goes backwards never gets here: ``Stream`` refuses it.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # absurd sizes are found, not stumbled over
        return _examine(log)


def _examine(log: Log) -> Diagnosis:
    numbers = measure(log)
    findings: list[Finding] = [*judge_sensors.judge_time(numbers), *judge_sensors.judge_readings(numbers)]
    for check in CHECKS:
        findings.extend(check(log, numbers))
    return Diagnosis(log.source, tuple(findings), facts(log, numbers))


def facts(log: Log, numbers: Numbers) -> dict[str, object]:
    """Return the numbers behind the findings as nested dictionaries, with what the file says of itself."""
    return {"info": dict(log.info), "conventions": list(log.conventions), **asdict(numbers)}
