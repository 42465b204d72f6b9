"""Initial alignment against a velocity reference: the published model with an additive quaternion error.

Wu, Wang, Zhu, AASRI Procedia 9 (2014) 99-106, in total-state form: the error model of the paper is a shift of the
quaternion, so an unscented filter on attitude, velocity and biases is the same filter (docs/alignment.md, section 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robustnav.model import Equations, Model, Noise, Sensor, Symbols, Vector
from robustnav.units import DEG


@dataclass(frozen=True)
class AlignmentNoise:
    """Densities of an inertial unit and the sd of its velocity reference.

    ``gyro_density`` [rad/s/sqrt(Hz)], ``accel_density`` [m/s^2/sqrt(Hz)], ``gyro_bias_density``
    [rad/s^2/sqrt(Hz)], ``accel_bias_density`` [m/s^3/sqrt(Hz)], ``velocity_sd`` [m/s] of one reading.
    """

    gyro_density: float
    accel_density: float
    gyro_bias_density: float
    accel_bias_density: float
    velocity_sd: float


INCREMENTS = (
    Vector("turn", "1", 4),
    Vector("velocity_increment", "m/s"),
    Vector("turn_by_bias", "s", 9),
    Vector("velocity_by_bias", "m", 9),
)


def alignment_noises(noise: AlignmentNoise) -> tuple[Noise, ...]:
    """Return what drives attitude, velocity and biases."""
    return (
        Noise("gyro_noise", "rad/s/sqrt(Hz)", noise.gyro_density),
        Noise("accel_noise", "m/s^2/sqrt(Hz)", noise.accel_density),
        Noise("gyro_bias_noise", "rad/s^2/sqrt(Hz)", noise.gyro_bias_density),
        Noise("accel_bias_noise", "m/s^3/sqrt(Hz)", noise.accel_bias_density),
    )


def alignment(noise: AlignmentNoise, *, gravity: float, earth_rate_north: float, earth_rate_down: float) -> Model:
    """Return the published model: state ``v_n``, ``quaternion``, ``gyro_bias``, ``accel_bias``, sensor ``velocity``.

    The quaternion is four plain numbers, not a rotation: its error adds, its norm is free, and C(Q) scales with the
    norm squared, as in the paper.  Inputs are pre-integrated increments of the strapdown unit over one step.

    Parameters
    ----------
    noise : of the unit and the reference.
    gravity : normal gravity [m/s^2].
    earth_rate_north, earth_rate_down : of the Earth at the latitude [rad/s]: Omega cos L and -Omega sin L.
    """
    return Model(
        name="alignment",
        state=(
            Vector("v_n", "m/s"),
            Vector("quaternion", "1", 4),
            Vector("gyro_bias", "rad/s"),
            Vector("accel_bias", "m/s^2"),
        ),
        inputs=INCREMENTS,
        noises=alignment_noises(noise),
        sensors=(Sensor("velocity", "m/s", noise.velocity_sd),),
        parameters={"gravity": gravity, "earth_rate_north": earth_rate_north, "earth_rate_down": earth_rate_down},
        equations=_equations,
        nominal={
            "quaternion": (1.0, 0.0, 0.0, 0.0),
            "turn": (1.0, 0.0, 0.0, 0.0),
            "velocity_increment": (0.0, 0.0, -0.1 * gravity),
            "turn_by_bias": (0.1, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1),
        },
        start_sd={"v_n": 3.0, "quaternion": 0.1, "gyro_bias": 0.01 * DEG, "accel_bias": 1e-3},
        shipped=_equations,
    )


def increment(phi: Any) -> list[Any]:
    """Return the quaternion of a small turn, to fourth order in the angle."""
    square = phi.dot(phi)
    return [1 - square / 8 + square**2 / 384, *(phi / 2 - phi * square / 48)]


def specific(s: Symbols) -> Any:
    """Return the velocity increment in body axes less what the biases add to it."""
    import sympy as sp

    J, H = sp.Matrix(3, 3, list(s.turn_by_bias)), sp.Matrix(3, 3, list(s.velocity_by_bias))
    return s.velocity_increment - J * s.accel_bias - H * s.gyro_bias


def _equations(s: Symbols) -> Equations:
    import sympy as sp

    from robustnav.model.derive import quat_product

    J = sp.Matrix(3, 3, list(s.turn_by_bias))
    turn = quat_product(increment(-J * s.gyro_bias), list(s.turn))
    a = _scaled_matrix(list(s.quaternion)) * specific(s)
    earth_rate_n = sp.Matrix([s.earth_rate_north, 0, s.earth_rate_down])
    coriolis = s.dt * earth_rate_n.cross(a / 2 + 2 * s.v_n)
    v_n = s.v_n + a + sp.Matrix([0, 0, s.gravity]) * s.dt - coriolis + s.accel_noise
    moved = quat_product(quat_product(increment(-earth_rate_n * s.dt), list(s.quaternion)), turn)
    shaken = [e / 2 for e in quat_product(list(s.quaternion), [0, *s.gyro_noise])]
    return Equations(
        steps={
            "v_n": v_n,
            "quaternion": [a + b for a, b in zip(moved, shaken, strict=True)],
            "gyro_bias": s.gyro_bias + s.gyro_bias_noise,
            "accel_bias": s.accel_bias + s.accel_bias_noise,
        },
        sensors={"velocity": s.v_n},
    )


def _scaled_matrix(q: list[Any]) -> Any:
    """Return C(Q) = Y(Q)' U(Q): for a unit quaternion the rotation, else scaled by the norm squared."""
    import sympy as sp

    w, x, y, z = q
    return sp.Matrix(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )
