"""G, D and the Earth's values: gravity and field in the world of a recorded attitude, and as models have them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.doctor.motion import whole_rows
from robustnav.earth import magnetic_field, normal_gravity
from robustnav.errors import InputError
from robustnav.frames import rotate
from robustnav.records import Array, BoolArray, Log, Stream, Truth
from robustnav.units import DEG


@dataclass(frozen=True)
class Mean:
    """Mean of a sensor's vector (3,) turned into the world of the attitude, over ``rows`` samples."""

    vector_n: Array
    rows: int


@dataclass(frozen=True)
class Place:
    """What the Earth should show where the log was recorded; the field is None without a year."""

    gravity: float
    field_t: float | None = None
    dip_deg: float | None = None
    declination_deg: float | None = None


def attitude_at(truth: Truth, t: Array) -> tuple[Array, BoolArray]:
    """Return ``q_nb`` (n, 4) at times ``t`` (n,) and which of them are known.

    Linear between stamps, which is enough for means; unknown outside the attitude's span and in gaps above ten medians.
    """
    if truth.q_nb is None:
        return np.full((len(t), 4), np.nan), np.zeros(len(t), bool)
    keep = np.isfinite(truth.q_nb).all(axis=1)
    stamps, q = truth.t[keep], truth.q_nb[keep]
    if len(stamps) < 2 or stamps[-1] <= stamps[0]:
        return np.full((len(t), 4), np.nan), np.zeros(len(t), bool)
    # q and -q are one attitude: neighbours must have one sign before anything is drawn between them.
    flips = np.cumprod(np.concatenate([[1.0], np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)]))
    out = np.stack([np.interp(t, stamps, column) for column in (q * flips[:, None]).T], axis=1)
    size = np.linalg.norm(out, axis=1, keepdims=True)
    after = np.clip(np.searchsorted(stamps, t), 1, len(stamps) - 1)
    step = np.diff(stamps)
    near = step[after - 1] <= 10 * np.median(step[step > 0])
    known = (t >= stamps[0]) & (t <= stamps[-1]) & near & (size[:, 0] > 0.5)
    return out / np.where(size > 0, size, 1.0), known


def world_mean(sensor: Stream, truth: Truth) -> Mean | None:
    """Return the mean of ``C_nb v_b`` of a sensor (n, 3), or None where no sample has an attitude."""
    t, v = whole_rows(sensor)
    q_nb, known = attitude_at(truth, t)
    if not known.any():
        return None
    return Mean(rotate(q_nb[known], v[known]).mean(axis=0), int(known.sum()))


def tilt_deg(gravity_n: Array) -> float:
    """Return the angle [deg] of a mean specific force (3,) from straight up, (0, 0, -1) in NED."""
    return float(np.arccos(np.clip(-gravity_n[2] / np.linalg.norm(gravity_n), -1, 1)) / DEG)


def declination_deg(field_n: Array) -> float:
    """Return the angle [deg] of a mean field (3,) from the world's first axis towards its second."""
    return float(np.arctan2(field_n[1], field_n[0]) / DEG)


def dip_deg(accel: Stream, mag: Stream) -> tuple[float, float] | None:
    """Return mean and standard deviation [deg] of the field's angle below the horizon, from the sensors alone."""
    t, f = whole_rows(accel)
    tm, m = whole_rows(mag)
    if not len(t) or not len(tm):
        return None
    inside = (tm >= t[0]) & (tm <= t[-1])
    m = m[inside]
    at = np.stack([np.interp(tm[inside], t, column) for column in f.T], axis=1)
    size = np.linalg.norm(at, axis=1) * np.linalg.norm(m, axis=1)
    good = size > 0
    if not good.any():
        return None
    dip = np.arcsin(np.clip(-np.sum(at[good] * m[good], axis=1) / size[good], -1, 1)) / DEG
    return float(dip.mean()), float(dip.std())


def place(log: Log) -> Place | None:
    """Return the Earth's gravity and field where ``log.info`` says it was recorded, or None without a latitude."""
    latitude, longitude, year = (_number(log, key) for key in ("latitude_deg", "longitude_deg", "year"))
    height = _number(log, "height_m") or 0.0
    if latitude is None or not -90 <= latitude <= 90:
        return None
    gravity = normal_gravity(latitude * DEG, height)
    if longitude is None or year is None:
        return Place(gravity)
    try:
        field = magnetic_field(latitude, longitude, height, year)
    except InputError:  # a year outside the models: gravity is still known
        return Place(gravity)
    return Place(gravity, field.norm, field.dip_deg, field.declination_deg)


def _number(log: Log, key: str) -> float | None:
    value = log.info.get(key)
    return float(value) if isinstance(value, int | float) and np.isfinite(value) else None
