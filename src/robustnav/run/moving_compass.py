"""What a compass tells of a carrier that moves: one heading, at the start, as far off as it lastingly is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robustnav.frames import Array, euler_from_quat, rotate, wrap_angle
from robustnav.records import Log, Stream
from robustnav.run.feed import feed_of
from robustnav.run.loop import Start
from robustnav.run.moving_setting import GnssAiding
from robustnav.run.task import Task

_STEEP = 0.1  # horizontal share of a field by one of the starts, below which it may be all tilt error


def with_compass(
    task: Task, log: Log, aiding: GnssAiding, begin: tuple[int, Sequence[Start]]
) -> tuple[Task, list[str]]:
    """Return a task with the first whole heading after a row alone, and what was done in words.

    A compass errs by the same again and again: a hundred readings of it tell what one tells.  Where there is no stream
    ``heading`` and a declination is known, it is the first whole reading of ``mag``, levelled by the tilt of that start
    whose own heading it fits best.
    """
    row, starts = begin
    if aiding.heading_sd is None:
        return task, []
    t = task.feed.t[row]
    if "heading" in task.log.streams:
        one = task.log.streams["heading"]
        later = np.flatnonzero((one.t > t) & np.isfinite(one.values[:, 0]))[:1]
        heading = replace(one, t=one.t[later], values=one.values[later])
        return _fused(task, heading), [f"1 of {len(one)} heading readings fused: a compass errs lastingly"]
    if aiding.declination is None:
        return task, []
    if "mag" not in log.streams:
        return task, ["no mag stream: no compass"]
    mag = log.streams["mag"]
    later = np.flatnonzero((mag.t >= t) & np.isfinite(mag.values).all(axis=1))[:1]
    if not later.size:
        return task, ["no mag reading after the start: no compass"]
    attitude = task.estimator.model.state_slices["q_nb"]
    yaw = _levelled(mag.values[later[0]], np.array([one.x[attitude] for one in starts]), aiding.declination)
    if yaw is None:
        return task, ["the magnetic field is too steep at the start, or the tilt too vague: no compass"]
    at = max(float(mag.t[later[0]]), float(np.nextafter(t, np.inf)))  # a reading at the start counts as used by it
    heading = Stream("heading", np.array([at]), np.array([[yaw]]), "rad", "n")
    return _fused(task, heading), [f"1 of {len(mag)} mag readings fused as a heading: a compass errs lastingly"]


def _levelled(field_b: Array, q_nb: Array, declination: float) -> float | None:
    """Return the heading [rad] that a field (3,) tells where one of the attitudes (k, 4) has nearly that heading."""
    north, east, _ = rotate(q_nb, np.tile(field_b, (len(q_nb), 1))).T
    off = wrap_angle(declination - np.arctan2(east, north))
    if not np.hypot(north, east).min() > _STEEP * np.linalg.norm(field_b):
        return None
    k = int(np.argmin(np.abs(off)))
    return float(wrap_angle(euler_from_quat(q_nb[k])[2] + off[k]))


def _fused(task: Task, heading: Stream) -> Task:
    model, log = task.estimator.model, replace(task.log, streams={**task.log.streams, "heading": heading})
    news = {**task.news, model.sensor_index("heading"): np.ones(len(heading))}
    return replace(task, log=log, feed=feed_of(model, log), news=news)
