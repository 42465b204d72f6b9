"""Pose of a level carrier in a plane from ranges to several of its tags."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, Sensor, Symbols, Vector
from robustnav.models.uwb import distance
from robustnav.ranging import Ranges
from robustnav.streams import Stream
from robustnav.units import DEG

HARMONICS = 4  # numbers of a tag's antenna: cosine and sine of the bearing and of twice the bearing


def uwb_planar(
    *,
    range_sd: float,
    acceleration_density: float,
    yaw_acceleration_density: float,
    body_down: float = 0.0,
    time_offset: float = 0.0,
) -> Model:
    """Return the planar model: state ``p_n`` (2), ``v_n`` (2), ``yaw`` and ``yaw_rate``; accelerations as white noise.

    Axes are those the anchors are surveyed in, z down; the carrier stays level.  Its one sensor, ``range``, takes the
    readings of ``planar_stream``: the anchor's position, where the tag sits on the carrier and how its antenna errs
    travel with each, so any number of tags and anchors will do.

    Parameters
    ----------
    range_sd : of a calibrated range, white [m].  Where errors last longer than the time between readings, state what
        is as bad at low frequencies: sd sqrt(2 tau f) for errors of time constant tau in readings of rate f.
    acceleration_density : of each horizontal axis, two-sided [m/s^2/sqrt(Hz)].
    yaw_acceleration_density : two-sided [rad/s^2/sqrt(Hz)].
    body_down : where the carrier's origin is on the down axis [m].
    time_offset : how late the stamps of ranges are [s].
    """
    anchor, lever = Vector("p_anchor", "m"), Vector("range_lever_b", "m", frame="b")
    return Model(
        name="uwb_planar",
        state=(Vector("p_n", "m", 2), Vector("v_n", "m/s", 2), Vector("yaw", "rad", 1), Vector("yaw_rate", "rad/s", 1)),
        inputs=(),
        noises=(
            Noise("acceleration", "m/s^2/sqrt(Hz)", acceleration_density, 2),
            Noise("yaw_acceleration", "rad/s^2/sqrt(Hz)", yaw_acceleration_density, 1),
        ),
        sensors=(Sensor("range", "m", range_sd, 1, known=(anchor, lever, Vector("range_pattern", "m", HARMONICS))),),
        parameters={"body_down": body_down, "time_offset": time_offset},
        equations=_equations,
        start_sd={"p_n": 1.0, "v_n": 0.5, "yaw": 30 * DEG, "yaw_rate": 0.5},
        shipped=_equations,
    )


def planar_stream(ranges: Ranges, pattern: ArrayLike | None = None) -> Stream:
    """Return ranges as readings (n, 11) of ``uwb_planar``: distance, anchor (3,), lever arm (3,), antenna (4,).

    Parameters
    ----------
    ranges : calibrated, with ``lever_b``.
    pattern : (tags, 4) what a range of each tag is too long by [m], as amplitudes of the cosine and sine of the
        anchor's bearing from the carrier's forward axis and of twice that bearing; None: antennas alike all round.

    Raises
    ------
    InputError : no lever arms, or a pattern of another shape or with a number missing.
    """
    if ranges.lever_b is None:
        raise InputError("planar ranges", got="no lever arms", expected="lever_b, where each tag sits on the carrier")
    shape = (len(ranges.tags), HARMONICS)
    amplitudes = np.zeros(shape) if pattern is None else np.asarray(pattern, float)
    if amplitudes.shape != shape or not np.isfinite(amplitudes).all():
        raise InputError("antenna pattern", got=f"shape {amplitudes.shape}", expected=f"finite numbers, shape {shape}")
    readings = ranges.stream(lever=True)
    return Stream("range", readings.t, np.hstack([readings.values, amplitudes[ranges.tag]]), "m", "a")


def _equations(s: Symbols) -> Equations:
    import sympy as sp

    yaw = s.yaw[0] - s.time_offset * s.yaw_rate[0]
    c, sine = sp.cos(yaw), sp.sin(yaw)
    forward, right, down = s.range_lever_b
    x = s.p_anchor[0] - (s.p_n[0] - s.time_offset * s.v_n[0] + c * forward - sine * right)
    y = s.p_anchor[1] - (s.p_n[1] - s.time_offset * s.v_n[1] + sine * forward + c * right)
    level = sp.sqrt(x**2 + y**2)
    ahead, aside = (c * x + sine * y) / level, (c * y - sine * x) / level  # cosine and sine of the bearing
    bearing = sp.Matrix([ahead, aside, ahead**2 - aside**2, 2 * ahead * aside])
    return Equations(
        rates={"p_n": s.v_n, "v_n": s.acceleration, "yaw": s.yaw_rate, "yaw_rate": s.yaw_acceleration},
        sensors={"range": distance((x, y, s.body_down + down), (0, 0, s.p_anchor[2])) + bearing.dot(s.range_pattern)},
    )
