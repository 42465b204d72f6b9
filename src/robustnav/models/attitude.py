"""Attitude and gyro bias from a gyro, an accelerometer and a magnetometer, valid at every attitude."""

from __future__ import annotations

from robustnav.model import Equations, Model, Noise, Rotation, Symbols, Vector
from robustnav.models.attitude_noise import AttitudeNoise, place
from robustnav.units import DEG, DPS


def attitude(noise: AttitudeNoise, *, field: float, dip_deg: float) -> Model:
    """Return the quaternion model: state ``q_nb`` and ``gyro_bias``, input ``gyro``, sensors ``accel`` and ``mag``.

    Navigation axes are magnetic north, east, down: the field has no east part, which keeps gains sparse; turn the
    result by the declination where true north is wanted.  The error is kept in navigation axes and both sensors see
    fixed navigation vectors, so their Jacobians are constant (docs/models.md, section 2).

    Parameters
    ----------
    noise : of gyro, accelerometer and magnetometer.
    field : strength of the magnetic field [T].
    dip_deg : angle of the field below the horizon [deg].
    """
    return Model(
        name="attitude",
        state=(Rotation("q_nb", error="n"), Vector("gyro_bias", "rad/s", frame="b")),
        inputs=(Vector("gyro", "rad/s", frame="b"),),
        noises=(
            Noise("gyro_noise", "rad/s/sqrt(Hz)", noise.gyro_density),
            Noise("gyro_bias_noise", "rad/s^2/sqrt(Hz)", noise.gyro_bias_density),
            Noise("gyro_scale_noise", "1/sqrt(Hz)", noise.gyro_scale_density),
        ),
        sensors=noise.sensors(),
        parameters=place(field, dip_deg),
        equations=_equations,
        start_sd={"q_nb": (5 * DEG, 5 * DEG, 10 * DEG), "gyro_bias": 0.5 * DPS},
        shipped=_equations,
    )


def _equations(s: Symbols) -> Equations:
    import sympy as sp

    rate = s.gyro - s.gyro_bias
    turning = sp.sqrt(rate.dot(rate))
    return Equations(
        rates={"q_nb": rate - s.gyro_noise - turning * s.gyro_scale_noise, "gyro_bias": s.gyro_bias_noise},
        directions={"accel": (0, 0, -s.gravity), "mag": (s.mag_north, 0, s.mag_down)},
    )
