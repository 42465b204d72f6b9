"""What a compass tells of a carrier that moves: one heading, at the start, as far off as it lastingly is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robustnav.frames import Array, euler_from_quat, quat_from_matrix, wrap_angle
from robustnav.records import Log, Stream
from robustnav.run.feed import feed_of
from robustnav.run.moving_setting import GnssAiding
from robustnav.run.moving_start import Window, tilted
from robustnav.run.task import Task

_STEEP = 0.25  # horizontal share of a field, below which 4 deg of tilt turn its direction by 15 deg and more


def with_compass(task: Task, log: Log, aiding: GnssAiding, begin: tuple[int, Window]) -> tuple[Task, list[str]]:
    """Return a task with the first whole heading after a row alone, and what was done in words.

    A compass errs by the same again and again: a hundred readings of it tell what one tells.  Where there is no stream
    ``heading`` and a declination is known, it is the first whole reading of ``mag``, levelled by the window's tilt.
    """
    row, window = begin
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
    yaw = _levelled(mag.values[later[0]], tilted(window), aiding.declination)
    if yaw is None:
        return task, ["the magnetic field is too steep at the start: no compass"]
    at = max(float(mag.t[later[0]]), float(np.nextafter(t, np.inf)))  # a reading at the start counts as used by it
    heading = Stream("heading", np.array([at]), np.array([[yaw]]), "rad", "n")
    return _fused(task, heading), [f"1 of {len(mag)} mag readings fused as a heading: a compass errs lastingly"]


def _levelled(field_b: Array, C_nb: Array, declination: float) -> float | None:
    """Return the heading [rad] at which a field (3,) points to magnetic north, given any attitude of the right tilt."""
    north, east, _ = C_nb @ field_b
    if not np.hypot(north, east) > _STEEP * np.linalg.norm(field_b):
        return None
    yaw = euler_from_quat(quat_from_matrix(C_nb))[2]
    return float(wrap_angle(yaw + declination - np.arctan2(east, north)))


def _fused(task: Task, heading: Stream) -> Task:
    model, log = task.estimator.model, replace(task.log, streams={**task.log.streams, "heading": heading})
    news = {**task.news, model.sensor_index("heading"): np.ones(len(heading))}
    return replace(task, log=log, feed=feed_of(model, log), news=news)
