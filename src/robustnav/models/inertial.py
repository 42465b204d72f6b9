"""Attitude, velocity and position from an inertial unit, corrected by ranges, positions, velocities or heading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from robustnav.model import Equations, Model, Noise, Rotation, Sensor, Symbols, Vector
from robustnav.model.blocks import Block
from robustnav.models.uwb import BIAS_SLOTS, RangeBias, distance
from robustnav.units import DEG


@dataclass(frozen=True)
class InertialNoise:
    """White noise and bias walks of an inertial unit, two-sided, as they act on a filter that moves.

    ``gyro_density`` [rad/s/sqrt(Hz)], ``accel_density`` [m/s^2/sqrt(Hz)], ``gyro_bias_density`` [rad/s^2/sqrt(Hz)],
    ``accel_bias_density`` [m/s^3/sqrt(Hz)].
    """

    gyro_density: float
    accel_density: float
    gyro_bias_density: float
    accel_bias_density: float


@dataclass(frozen=True)
class AidingNoise:
    """Standard deviations of the sensors that may correct an inertial unit, those that are fused: metres, m/s, rad."""

    range_sd: float = 0.1
    position_sd: float = 0.1
    velocity_sd: float = 0.1
    height_sd: float = 0.1
    level_sd: float = 0.5
    heading_sd: float = 5 * DEG


def inertial(
    noise: InertialNoise,
    aiding: AidingNoise,
    *,
    gravity: float = 9.80665,
    earth_rate_n: Sequence[float] = (0.0, 0.0, 0.0),
    time_offset: float = 0.0,
    bias: RangeBias | None = None,
) -> Model:
    """Return the strapdown model: 15 errors, inputs ``gyro`` and ``accel``, state of attitude, motion and biases.

    State ``q_nb``, ``v_n``, ``p_n``, ``gyro_bias``, ``accel_bias``; the attitude error is kept in navigation axes.
    Navigation axes are the anchors' or any level frame, z down.  Sensors, each optional and fused at its own time:
    ``range`` and ``tdoa`` (the anchors and the tag's lever arm travel with each reading), ``position`` (with the
    antenna's lever arm), ``velocity`` (with that and what the gyro reads then), ``height`` (metres up), ``level``
    (specific force of a carrier at rest) and ``heading`` of the body's forward axis (docs/ranging.md, section 2).

    Parameters
    ----------
    noise : of the inertial unit.
    aiding : of the sensors.
    gravity : normal gravity where it flies [m/s^2].
    earth_rate_n : rate of the navigation axes against inertial space [rad/s]; zero where the gyros cannot see it.
    time_offset : how late the stamps of ranges and differences are [s].
    bias : estimate a bias of the ranges of each of up to eight anchors, and an error of scale, as ``uwb`` does; of
        differences only the scale.  None: white noise only.
    """
    biased = bias is not None
    return Model(
        name="inertial_biased" if biased else "inertial",
        state=_state(biased),
        inputs=(Vector("gyro", "rad/s", frame="b"), Vector("accel", "m/s^2", frame="b")),
        noises=_noises(noise, bias),
        sensors=_sensors(aiding, biased),
        parameters={
            "gravity": gravity,
            **{f"earth_rate_{axis}": float(v) for axis, v in zip("xyz", earth_rate_n, strict=True)},
            "time_offset": time_offset,
            **({} if bias is None else {"bias_time": bias.time}),
        },
        equations=_EQUATIONS[biased],
        nominal={"accel": (0.0, 0.0, -gravity)},
        start_sd={
            "q_nb": (2 * DEG, 2 * DEG, 15 * DEG),
            "v_n": 0.5,
            "p_n": 0.5,
            "gyro_bias": 0.5 * DEG,
            "accel_bias": 0.2,
            **({} if bias is None else {"range_bias": bias.sd, "range_scale": bias.scale_sd}),
        },
        shipped=_EQUATIONS[biased],
    )


def _state(biased: bool) -> tuple[Block, ...]:
    motion = (
        Rotation("q_nb", error="n"),
        Vector("v_n", "m/s"),
        Vector("p_n", "m"),
        Vector("gyro_bias", "rad/s", frame="b"),
        Vector("accel_bias", "m/s^2", frame="b"),
    )
    return (*motion, Vector("range_bias", "m", BIAS_SLOTS), Vector("range_scale", "1", 1)) if biased else motion


def _noises(noise: InertialNoise, bias: RangeBias | None) -> tuple[Noise, ...]:
    unit = (
        Noise("gyro_noise", "rad/s/sqrt(Hz)", noise.gyro_density),
        Noise("accel_noise", "m/s^2/sqrt(Hz)", noise.accel_density),
        Noise("gyro_bias_noise", "rad/s^2/sqrt(Hz)", noise.gyro_bias_density),
        Noise("accel_bias_noise", "m/s^3/sqrt(Hz)", noise.accel_bias_density),
    )
    return (
        unit
        if bias is None
        else (*unit, Noise("range_bias_noise", "m/s/sqrt(Hz)", bias.sd * (2 / bias.time) ** 0.5, BIAS_SLOTS))
    )


def _sensors(aiding: AidingNoise, biased: bool) -> tuple[Sensor, ...]:
    def lever(sensor: str) -> Vector:
        return Vector(f"{sensor}_lever_b", "m", frame="b")

    anchor, first, second = (Vector(f"p_{which}", "m") for which in ("anchor", "first", "second"))
    rate = Vector("velocity_rate_b", "rad/s", frame="b")
    slot = (Vector("range_slot", "1", BIAS_SLOTS),) if biased else ()
    return (
        Sensor("range", "m", aiding.range_sd, 1, known=(anchor, *slot, lever("range"))),
        Sensor("tdoa", "m", aiding.range_sd * 2**0.5, 1, known=(first, second, lever("tdoa"))),
        Sensor("position", "m", aiding.position_sd, 3, known=(lever("position"),)),
        Sensor("velocity", "m/s", aiding.velocity_sd, 3, known=(lever("velocity"), rate)),
        Sensor("height", "m", aiding.height_sd, 1),
        Sensor("level", "m/s^2", aiding.level_sd, 3),
        Sensor("heading", "rad", aiding.heading_sd, 1, wraps=True),
    )


def _equations(s: Symbols, *, biased: bool) -> Equations:
    import sympy as sp

    from robustnav.model.derive import matrix

    C_nb = sp.Matrix(matrix(list(s.q_nb)))
    gravity_n = sp.Matrix([0, 0, s.gravity])
    earth_rate_n = sp.Matrix([s.earth_rate_x, s.earth_rate_y, s.earth_rate_z])

    def tag(lever_b: sp.Matrix) -> sp.Matrix:
        return s.p_n + C_nb * lever_b - s.time_offset * s.v_n

    walks = {"range_bias": s.range_bias_noise - s.range_bias / s.bias_time, "range_scale": [0]} if biased else {}
    one = distance(tag(s.range_lever_b), s.p_anchor)
    two = distance(tag(s.tdoa_lever_b), s.p_second) - distance(tag(s.tdoa_lever_b), s.p_first)
    if biased:
        one = one * (1 + s.range_scale[0]) + s.range_bias.dot(s.range_slot)
        two = two * (1 + s.range_scale[0])
    return Equations(
        rates={
            "q_nb": s.gyro - s.gyro_bias - s.gyro_noise - C_nb.T * earth_rate_n,
            # white noise of equal size on every axis is the same in navigation axes, where it needs no turning
            "v_n": C_nb * (s.accel - s.accel_bias) + gravity_n - 2 * earth_rate_n.cross(s.v_n) + s.accel_noise,
            "p_n": s.v_n,
            "gyro_bias": s.gyro_bias_noise,
            "accel_bias": s.accel_bias_noise,
            **walks,
        },
        sensors={
            "range": one,
            "tdoa": two,
            "position": s.p_n + C_nb * s.position_lever_b,
            "velocity": s.v_n + C_nb * (s.velocity_rate_b - s.gyro_bias).cross(s.velocity_lever_b),
            "height": -s.p_n[2],
            "level": s.accel_bias - C_nb.T * gravity_n,
            "heading": sp.atan2(C_nb[1, 0], C_nb[0, 0]),
        },
    )


_EQUATIONS = {biased: partial(_equations, biased=biased) for biased in (False, True)}
