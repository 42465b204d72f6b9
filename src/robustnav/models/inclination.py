"""Attitude and gyro bias from a gyro and an accelerometer alone: heading drifts with the gyro."""

from __future__ import annotations

from robustnav.model import Equations, Model, Noise, Rotation, Symbols, Vector
from robustnav.models.attitude_noise import AttitudeNoise
from robustnav.units import DEG, DPS, STANDARD_GRAVITY


def inclination(noise: AttitudeNoise) -> Model:
    """Return the quaternion model without a magnetometer: state ``q_nb``, ``gyro_bias``, input ``gyro``, ``accel``.

    The same equations as ``attitude``; north is wherever the filter started.  Of the error, rotation about the vertical
    and the bias along it are seen by no sensor: a covariance filter lets them grow, a constant gain leaves them out.

    Parameters
    ----------
    noise : of gyro and accelerometer; the magnetometer's is not used.
    """
    accel, _ = noise.sensors()
    return Model(
        name="inclination",
        state=(Rotation("q_nb", error="n"), Vector("gyro_bias", "rad/s", frame="b")),
        inputs=(Vector("gyro", "rad/s", frame="b"),),
        noises=(
            Noise("gyro_noise", "rad/s/sqrt(Hz)", noise.gyro_density),
            Noise("gyro_bias_noise", "rad/s^2/sqrt(Hz)", noise.gyro_bias_density),
        ),
        sensors=(accel,),
        parameters={"gravity": STANDARD_GRAVITY},
        equations=_equations,
        start_sd={"q_nb": (5 * DEG, 5 * DEG, 10 * DEG), "gyro_bias": 0.5 * DPS},
    )


def _equations(s: Symbols) -> Equations:
    rate = s.gyro - s.gyro_bias
    return Equations(
        rates={"q_nb": rate - s.gyro_noise, "gyro_bias": s.gyro_bias_noise},
        directions={"accel": (0, 0, -s.gravity)},
    )
