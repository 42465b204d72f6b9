"""A compass in one filter: the azimuth of the magnetic field says where the Earth rate points.

In the wander frame the rate is ``length (cos a, sin a)`` with ``a`` the azimuth of true north.  The field, less the
declination, gives ``a + error + noise``, seen through an attitude that errs by ``theta``.  Across a direction ``north``
the rate is therefore ``length sin(bearing - north + g theta - error - noise)``: one row, linear about what the filter
expects.  ``north`` is chosen once: rows across several directions would claim to see the length of the rate, and with
it the error of the compass.  ``g`` holds the bearing expected, not the one read, whose noise would pass for a tilt.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin, atan2, cos, exp, isnan, pi, sin, sqrt

import numpy as np

from robustnav.alignment.filter import COMPASS, RATE, TURN, Belief, Core, inject
from robustnav.alignment.readings import FIELD
from robustnav.alignment.setting import AlignSetup, Compass
from robustnav.frames import Array, matrix_from_quat, quat_multiply, wrap_angle
from robustnav.records import BoolArray

LENGTH_SD = 0.3  # of the Earth rate's length along a first bearing, by which it is told from its opposite
LEVEL_SHARE = 0.1  # of the field: nearer the vertical it says nothing of north
WIDEST = 0.85  # sine of the farthest that north may be expected from where it was first seen
DISTURBED = 0.05  # share of readings whose bearing may be any
STEEPNESS_TIME = 5.0  # s, over which the field's dip is averaged
ODD = 0.3  # rad from the middle of the first bearings


@dataclass(frozen=True)
class Bearing:
    """``azimuth`` [rad] of the field in the wander frame, and ``steepness``, the tangent of its dip."""

    azimuth: float
    steepness: float


def bearing(q: Array, field_b: Array) -> Bearing | None:
    """Return the bearing of a field (3,) at attitude ``q`` (4,); None if it is missing or upright."""
    m = matrix_from_quat(q) @ field_b
    level = float(m[0] ** 2 + m[1] ** 2)
    if not level > LEVEL_SHARE**2 * float(m @ m):
        return None
    return Bearing(atan2(m[1], m[0]), float(m[2]) / sqrt(level))


def take_bearing(belief: Belief, setup: AlignSetup, field_b: Array) -> Belief:
    """Return the belief after a reading of the magnetic field (3,) in body axes, any unit; NaN changes nothing."""
    now, compass = belief.estimate, setup.compass
    seen = bearing(now.q, field_b)
    if compass is None or seen is None:
        return belief
    if not isnan(belief.core.north):
        share = float(_side(now, setup) @ now.rate)
        return _across(belief, setup, compass, seen, asin(min(max(share, -WIDEST), WIDEST)))
    length, rate = setup.horizontal_earth_rate, now.rate
    known = belief.P[RATE, RATE] + belief.P[RATE + 1, RATE + 1] < length**2
    north = atan2(rate[1], rate[0]) if known else seen.azimuth - compass.declination
    core = replace(belief.core, north=north, steepness=seen.steepness)
    belief = _across(replace(belief, core=core), setup, compass, seen, 0.0)
    if known:
        return belief
    H = np.zeros(len(belief.P))
    H[RATE:COMPASS] = cos(north), sin(north)
    return _scalar(belief, H, length - float(H[RATE:COMPASS] @ belief.estimate.rate), (LENGTH_SD * length) ** 2)


def _side(core: Core, setup: AlignSetup) -> Array:
    """Return the row (2,) that gives the part of the Earth rate across north, as a share of its length."""
    return np.array([-sin(core.north), cos(core.north)]) / setup.horizontal_earth_rate


def _across(belief: Belief, setup: AlignSetup, compass: Compass, seen: Bearing, turn: float) -> Belief:
    """Update with a bearing, linear about a rate turned by ``turn`` [rad] from north.

    The bearing may be disturbed: its noise is divided by the probability that it is not.
    """
    core, P = belief.estimate, belief.P
    side, steep = _side(core, setup), core.steepness
    expected = core.north + turn + compass.declination + float(core.compass_bias[0])
    H = np.zeros(len(P))
    ahead = expected - belief.turn  # a tilt is about the axes of the anchor
    H[TURN : TURN + 3] = steep * cos(ahead), steep * sin(ahead), -1.0
    H[RATE:COMPASS], H[COMPASS] = side / cos(turn), 1.0
    off = float(wrap_angle(seen.azimuth - expected)) - (float(side @ core.rate) - sin(turn)) / cos(turn)
    # What a tilt does to a bearing in second order.
    bend = (0.5 + steep**2) * float(P[TURN, TURN] + P[TURN + 1, TURN + 1])
    noise = compass.sd**2 + bend**2
    S = float(H @ P @ H) + noise
    fair = (1 - DISTURBED) * exp(-0.5 * off**2 / S) * sqrt(2 * pi / S)
    weight = max(fair / (fair + DISTURBED), 1e-6)
    steep += weight * setup.period / STEEPNESS_TIME * (seen.steepness - steep)
    return _scalar(replace(belief, core=replace(belief.core, steepness=steep)), H, off, noise / weight)


def _scalar(belief: Belief, H: Array, innovation: float, noise: float) -> Belief:
    PH = belief.P @ H
    w = PH / sqrt(H @ PH + noise)
    return inject(replace(belief, P=belief.P - np.outer(w, w)), w * innovation / sqrt(H @ PH + noise))


def fair_fields(rows: Array, setup: AlignSetup, q0: Array) -> BoolArray:
    """Return which rows (n, 30) of the start have a field near the middle one: before a filter has a north to judge by.

    Parameters
    ----------
    rows : readings from the start on.
    setup : of the alignment.
    q0 : (4,) attitude at the start, body to wander frame.
    """
    azimuth, q = np.full(len(rows), np.nan), q0
    for k, row in enumerate(rows):
        q = quat_multiply(q, row[:4])
        seen = bearing(q, row[FIELD])
        azimuth[k] = np.nan if seen is None else seen.azimuth
    compass, there = setup.compass, np.flatnonzero(np.isfinite(azimuth))
    if compass is None or not there.size:
        return np.zeros(len(rows), bool)
    apart = np.abs(wrap_angle(azimuth[there, None] - azimuth[there]))
    middle = azimuth[there[int(np.argmin(apart.sum(axis=1)))]]
    fair: BoolArray = np.abs(wrap_angle(azimuth - middle)) < max(ODD, 4 * compass.sd)
    return fair
