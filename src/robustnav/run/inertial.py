"""Attitude and position of a carrier from its inertial unit and ranges, started without a prior, at rest or moving."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Log, Run
from robustnav.run.acquisition import BETTER, REFUSED_NIS, lost_at, places, track_cost
from robustnav.run.estimators import EKF
from robustnav.run.inertial_course import InertialCourse
from robustnav.run.inertial_start import InertialStart, heading_starts
from robustnav.run.tracking_task import RANGING, Readings, Source, TrackingTask
from robustnav.snapshot.window import Minimum


def run_inertial(
    estimator: EKF,
    readings: Readings | Sequence[Readings],
    log: Log,
    settings: InertialStart | None = None,
    *,
    smooth: bool = False,
    backend: str = "auto",
) -> Run:
    """Return attitude and position of a carrier from gyro, accelerometer and ranges or differences, without a prior.

    The tag's place comes from a short window of readings, the tilt from the median specific force.  The heading shows
    only when the carrier accelerates sideways or turns: filters with headings all round are followed, and the best one
    so far is reported with a covariance that reaches to the others.  When most readings of a window are far off and
    another place explains them much better, everything is started again.  The events say when and what.  Nothing looks
    ahead, unless ``smooth`` is asked for.  A start in a steep manoeuvre is linearised many degrees off: its standard
    deviations are then too small by up to a third for some ten seconds.

    Parameters
    ----------
    estimator : on a model of ``models.inertial``.
    readings : ranges, differences or both, of one tag, in the axes of their anchors, z down; their ``lever_b`` is
        where the tag sits on the body.
    log : streams ``gyro`` and ``accel`` of common times; others that the model knows are fused, ``heading`` or
        ``height`` say, from the start on.
    settings : how to start and restart; None: the defaults.
    smooth : smooth over the whole recording; a restart cuts it.
    backend : ``auto``, ``c``, ``float`` or ``numpy``.

    Returns
    -------
    Run : from the first position on, at the times of the inputs; innovations of all readings, with NaN before.

    Raises
    ------
    InputError : another model, readings of several tags, or as ``run``.
    EstimatorError : no window of readings tells a position, or no input comes before it.
    """
    settings = settings or InertialStart()
    task = _task(estimator, Source(readings, log), settings, backend)
    course = InertialCourse(task, settings.found_sd, task.nothing_said())
    row, found = task.first_place()
    _set_out(course, task, settings, (row, found[0]), "started")
    while (lost := _lost(course, task)) is not None:
        _set_out(course, task, settings, lost, "lost and started again")
    return course.report(task.log, {"acquisition window [s]": task.tau}, smooth=smooth)


def _set_out(
    course: InertialCourse, task: TrackingTask, settings: InertialStart, begin: tuple[int, Minimum], word: str
) -> None:
    row, found = begin
    words = f"{word} at {task.feed.t[row]:.2f} s, sd {np.sqrt(np.trace(found.P)):.2f} m"
    course.set_out(row, heading_starts(task, row, found, settings), words)


def _lost(course: InertialCourse, task: TrackingTask) -> tuple[int, Minimum] | None:
    """Return the next row at which the readings tell a place much better than the filter's, or None."""
    leg, events, t, last = course.legs[-1], task.events, task.feed.t, -np.inf
    if not task.settings.restart:
        return None
    names = [s.name for s in task.estimator.model.sensors]
    ranging = [one for name in RANGING if (one := course.seen[names.index(name)]) is not None]
    nis = np.concatenate([one.nis for one in ranging])[task.order]
    off = np.nan_to_num(nis, nan=0.0) > REFUSED_NIS
    for k in lost_at(events, off, t[leg.settled], task.tau):
        row = int(np.searchsorted(t, events.t[k]))
        if events.t[k] - last < task.tau / 2 or row >= len(t) - 1:
            continue
        last = events.t[k]
        rows = events.between(max(last - task.tau, t[leg.row]), t[row])
        x = leg.x[row - leg.row]
        p = task.place(x)
        found = places(events, rows, task.settings, p, compiled=task.backend != "numpy")
        if found and found[0].cost < track_cost(events, rows, p, task.velocity(x)) - BETTER:
            return row, found[0]
    return None


def _task(estimator: EKF, source: Source, settings: InertialStart, backend: str) -> TrackingTask:
    model = estimator.model
    if not {"q_nb", "v_n", "p_n", "gyro_bias", "accel_bias"} <= set(model.state_slices) or source.log is None:
        raise InputError(f"model {model.name!r}", expected="a model of models.inertial", do="use run for other models")
    task = TrackingTask.of(estimator, source, settings.acquisition, backend)
    if "range_bias" in model.state_slices:  # errors that last are in the state, and not in the count of readings
        return replace(task, news={j: np.ones_like(share) for j, share in task.news.items()})
    return task
