"""The published attitude model: Euler angles and gyro bias, body-frame residuals, one nominal point."""

from __future__ import annotations

from typing import Any

from robustnav.model import Equations, Model, Noise, Symbols, Vector
from robustnav.models.attitude_noise import AttitudeNoise, place
from robustnav.units import DEG, DPS


def attitude_euler(noise: AttitudeNoise, *, field: float, dip_deg: float) -> Model:
    """Return the Euler-angle model: state ``euler`` (roll, pitch, yaw) and ``gyro_bias``.

    Kept as the reference form.  Singular at pitch +-90 deg; a constant gain on it loses its heading beyond +-90 deg
    of yaw, because its residual is in body axes (docs/models.md, section 3).  Parameters as in ``attitude``; noise in
    proportion to the turn rate is not part of this model.

    Source: Kim, Tadiparthi, Bhattacharya, "Nonlinear Attitude Estimation for Small UAVs with Low Power
    Microprocessors", ACC 2020, with the accelerometer as specific force.
    """
    return Model(
        name="attitude_euler",
        state=(Vector("euler", "rad"), Vector("gyro_bias", "rad/s")),
        inputs=(Vector("gyro", "rad/s"),),
        noises=(
            Noise("gyro_noise", "rad/s/sqrt(Hz)", noise.gyro_density),
            Noise("gyro_bias_noise", "rad/s^2/sqrt(Hz)", noise.gyro_bias_density),
        ),
        sensors=noise.sensors(),
        parameters=place(field, dip_deg),
        equations=_equations,
        start_sd={"euler": (5 * DEG, 5 * DEG, 10 * DEG), "gyro_bias": 0.5 * DPS},
        shipped=_equations,
    )


def _equations(s: Symbols) -> Equations:
    import sympy as sp

    roll, pitch, yaw = s.euler
    rate_p, rate_q, rate_r = s.gyro - s.gyro_bias - s.gyro_noise
    turning = rate_q * sp.sin(roll) + rate_r * sp.cos(roll)
    euler_rate = (
        rate_p + turning * sp.tan(pitch),
        rate_q * sp.cos(roll) - rate_r * sp.sin(roll),
        turning / sp.cos(pitch),
    )
    C_bn = _about_x(roll) * _about_y(pitch) * _about_z(yaw)
    return Equations(
        rates={"euler": euler_rate, "gyro_bias": s.gyro_bias_noise},
        sensors={
            "accel": C_bn * sp.Matrix([0, 0, -s.gravity]),
            "mag": C_bn * sp.Matrix([s.mag_north, 0, s.mag_down]),
        },
    )


def _about_x(a: Any) -> Any:
    import sympy as sp

    return sp.Matrix([[1, 0, 0], [0, sp.cos(a), sp.sin(a)], [0, -sp.sin(a), sp.cos(a)]])


def _about_y(a: Any) -> Any:
    import sympy as sp

    return sp.Matrix([[sp.cos(a), 0, -sp.sin(a)], [0, 1, 0], [sp.sin(a), 0, sp.cos(a)]])


def _about_z(a: Any) -> Any:
    import sympy as sp

    return sp.Matrix([[sp.cos(a), sp.sin(a), 0], [-sp.sin(a), sp.cos(a), 0], [0, 0, 1]])
