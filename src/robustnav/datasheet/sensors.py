"""What is known of a sensor, in SI units: the record every error model reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError


@dataclass(frozen=True)
class SensorSpec:
    """Error figures of a three-axis sensor, in its SI unit u (rad/s, m/s^2 or T); None where nothing is stated.

    Parameters
    ----------
    density : one-sided noise density [u/sqrt(Hz)].
    noise_rms_sd : total noise as the sheet gives it, at ``bandwidth_hz`` [u].
    bandwidth_hz : -3 dB bandwidth [Hz].
    bias_instability : lowest level of the Allan deviation [u].
    random_walk : bias random walk [u/sqrt(s)].
    turn_on_bias_sd : constant bias of a run [u].
    scale_sd : scale error [1].
    misalignment_sd : cross-axis sensitivity, as an angle [rad].
    resolution : size of the least significant bit [u].
    range_max : largest reading, either sign [u].
    """

    density: float | None = None
    noise_rms_sd: float | None = None
    bandwidth_hz: float | None = None
    bias_instability: float | None = None
    random_walk: float | None = None
    turn_on_bias_sd: float | None = None
    scale_sd: float | None = None
    misalignment_sd: float | None = None
    resolution: float | None = None
    range_max: float | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is not None and not 0 < value < np.inf:
                raise InputError(
                    f"sensor figure {name!r}",
                    got=str(value),
                    expected="a positive number, or None where none is stated",
                )

    def sample_sd(self, rate_hz: float) -> float:
        """Return the standard deviation [u] of one white reading at ``rate_hz`` [Hz].

        From the density, ``density * sqrt(rate_hz / 2)``, or else the total noise.  A sheet may state a total above
        what its density gives; ``dataclasses.replace(spec, density=None)`` takes the total.

        Raises
        ------
        InputError : neither figure is stated.
        """
        if self.density is not None:
            return self.density * float(np.sqrt(rate_hz / 2))
        if self.noise_rms_sd is not None:
            return self.noise_rms_sd
        raise InputError("sensor without a noise figure", expected="density or noise_rms_sd", do="state one of them")

    @property
    def intensity(self) -> float | None:
        """Continuous-time, two-sided intensity ``density^2 / 2`` [u^2 s], or None."""
        return None if self.density is None else self.density**2 / 2


@dataclass(frozen=True)
class Imu:
    """Gyro [rad/s] and accelerometer [m/s^2], the document their figures come from, and which keys are assumed."""

    name: str
    gyro: SensorSpec
    accel: SensorSpec
    document: str = ""
    assumed: tuple[str, ...] = ()


@dataclass(frozen=True)
class Magnetometer:
    """Magnetometer [T], the document its figures come from, and which keys are assumed."""

    name: str
    field: SensorSpec
    document: str = ""
    assumed: tuple[str, ...] = ()
