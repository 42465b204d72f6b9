"""All the numbers of one recording, each group from its own file; words come later."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robustnav.doctor.heading import Heading, heading_at_rest
from robustnav.doctor.motion import Motion, motion
from robustnav.doctor.readings import Readings, readings
from robustnav.doctor.timing import Timing, timing
from robustnav.doctor.turning import Turning, turning
from robustnav.doctor.vectors import VectorMatch, match_vectors
from robustnav.doctor.world import Mean, Place, declination_deg, dip_deg, place, tilt_deg, world_mean
from robustnav.frames import quat_conjugate, quat_multiply, rotvec_from_quat
from robustnav.records import Log, Stream, Truth
from robustnav.units import DEG

STANDING = 1.0  # deg, a reference that turns less is constant


@dataclass(frozen=True)
class World:
    """Mean specific force and field in the world of the attitude, tilt from upright and implied declination [deg].

    ``north`` is the one the attitude refers to.
    """

    force_n: Mean | None
    tilt_deg: float
    field_n: Mean | None
    declination_deg: float
    north: str


@dataclass(frozen=True)
class Numbers:
    """What was measured; None where the recording has not what it takes.  ``turned_deg``: range of the truth."""

    timing: Mapping[str, Timing]
    readings: Mapping[str, Readings]
    motion: Motion | None
    place: Place | None
    dip: tuple[float, float] | None
    world: World | None
    turning: Turning | None
    by_gravity: VectorMatch | None
    by_field: VectorMatch | None
    vectors: VectorMatch | None
    heading: Heading | None
    turned_deg: float | None


def measure(log: Log) -> Numbers:
    """Return the numbers of a recording; its truth serves as attitude if that turns, else the log's estimate."""
    gyro, accel, mag = (_sensor(log, name) for name in ("gyro", "accel", "mag"))
    turned = _turned_deg(log.truth) if log.truth else None
    attitude = log.truth if log.estimate is None or (turned or 0.0) > STANDING else log.estimate
    vectors = [s for s in (accel, mag) if s is not None]
    return Numbers(
        timing={name: timing(s) for name, s in log.streams.items()},
        readings={name: readings(s) for name, s in log.streams.items()},
        motion=motion(gyro) if gyro else None,
        place=place(log),
        dip=dip_deg(accel, mag) if accel and mag else None,
        world=_world(accel, mag, attitude) if attitude else None,
        turning=turning(gyro, attitude) if gyro and attitude else None,
        by_gravity=match_vectors(gyro, [accel]) if gyro and accel else None,
        by_field=match_vectors(gyro, [mag]) if gyro and mag else None,
        vectors=match_vectors(gyro, vectors) if gyro else None,
        heading=heading_at_rest(gyro, log.estimate) if gyro and log.estimate else None,
        turned_deg=turned,
    )


def _sensor(log: Log, name: str) -> Stream | None:
    """Return a three-axis stream with at least one whole row, or None."""
    stream = log.streams.get(name)
    if stream is None or stream.values.shape[1] != 3 or not np.isfinite(stream.values).all(axis=1).any():
        return None
    return stream


def _world(accel: Stream | None, mag: Stream | None, attitude: Truth) -> World:
    force = world_mean(accel, attitude) if accel else None
    field = world_mean(mag, attitude) if mag else None
    return World(
        force,
        tilt_deg(force.vector_n) if force else float("nan"),
        field,
        declination_deg(field.vector_n) if field else float("nan"),
        attitude.north,
    )


def _turned_deg(truth: Truth) -> float | None:
    """Return the largest angle [deg] of an attitude from its first, or None without one."""
    if truth.q_nb is None:
        return None
    q = truth.q_nb[np.isfinite(truth.q_nb).all(axis=1)]
    if not len(q):
        return None
    return float(np.linalg.norm(rotvec_from_quat(quat_multiply(quat_conjugate(q[0]), q)), axis=1).max()) / DEG
