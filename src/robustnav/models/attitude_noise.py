"""Noise of the attitude models, from data sheets for simulation or widened for a carrier that moves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, hypot, radians, sin, sqrt

from robustnav.model import Sensor
from robustnav.units import DPS, STANDARD_GRAVITY


@dataclass(frozen=True)
class AttitudeNoise:
    """What the attitude models are told of their sensors.

    Parameters
    ----------
    gyro_density : white noise, two-sided [rad/s/sqrt(Hz)].
    gyro_bias_density : random walk of the bias [rad/s^2/sqrt(Hz)].
    accel_sd : accelerometer noise a sample, the carrier's own acceleration included [m/s^2].
    mag_sd : magnetometer noise a sample, disturbances included [T].
    gyro_scale_density : noise in proportion to the turn rate, from scale and axis errors [1/sqrt(Hz)].
    """

    gyro_density: float
    gyro_bias_density: float
    accel_sd: float
    mag_sd: float
    gyro_scale_density: float = 0.0

    @classmethod
    def from_datasheet(
        cls, imu: str, magnetometer: str, rate_hz: float, *, gyro_bias_density: float, mag_sd: float | None = None
    ) -> AttitudeNoise:
        """Return the white noise that data sheets state at a sample rate.

        Parameters
        ----------
        imu, magnetometer : preset names, see ``robustnav.datasheet.names()``.
        rate_hz : sample rate of IMU and magnetometer [Hz].
        gyro_bias_density : random walk of the gyro bias [rad/s^2/sqrt(Hz)]; data sheets do not state it.
        mag_sd : magnetometer noise a sample [T]; None takes the preset's.

        Raises
        ------
        InputError : unknown preset, or a figure that its data sheet does not state.
        """
        from robustnav import datasheet

        unit, field = datasheet.imu(imu), datasheet.magnetometer(magnetometer)
        return cls(
            gyro_density=unit.gyro.sample_sd(rate_hz) / sqrt(rate_hz),
            gyro_bias_density=gyro_bias_density,
            accel_sd=unit.accel.sample_sd(rate_hz),
            mag_sd=mag_sd if mag_sd is not None else field.field.sample_sd(rate_hz),
        )

    def sensors(self) -> tuple[Sensor, Sensor]:
        """Return the two sensors of the attitude models."""
        return Sensor("accel", "m/s^2", self.accel_sd), Sensor("mag", "T", self.mag_sd)

    def turning(self, rate: float) -> AttitudeNoise:
        """Return noise with what a turn at ``rate`` [rad/s] adds to the gyro's, for a gain that cannot follow it."""
        return replace(self, gyro_density=hypot(self.gyro_density, self.gyro_scale_density * rate))

    def moving(self, rate_hz: float, mag_rate_hz: float, field: float) -> AttitudeNoise:
        """Return noise for a carrier that moves and turns, its own motion standing in for the data sheet's figures.

        An acceleration of 1 m/s^2 that lasts half a second and a field disturbance of a fifth of the field that
        lasts a tenth are spread over their samples, so results do not depend on the sample rate.

        Parameters
        ----------
        rate_hz, mag_rate_hz : rates of accelerometer and magnetometer readings [Hz].
        field : strength of the magnetic field [T].
        """
        return replace(
            self,
            gyro_density=max(self.gyro_density, 0.06 * DPS),
            gyro_bias_density=max(self.gyro_bias_density, 3e-4 * DPS),
            gyro_scale_density=max(self.gyro_scale_density, 0.003),
            accel_sd=max(self.accel_sd, 1.0 * sqrt(0.5 * rate_hz)),
            mag_sd=max(self.mag_sd, 0.2 * field * sqrt(0.1 * mag_rate_hz)),
        )


def place(field: float, dip_deg: float) -> dict[str, float]:
    """Return the parameters of the attitude models: gravity [m/s^2] and the field's north and down parts [T]."""
    dip = radians(dip_deg)
    return {"gravity": STANDARD_GRAVITY, "mag_north": field * cos(dip), "mag_down": field * sin(dip)}
