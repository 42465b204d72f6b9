"""What is simulated for an initial alignment, as data in SI units."""

from __future__ import annotations

from dataclasses import dataclass

from robustnav.errors import InputError
from robustnav.sim.sway import Sway
from robustnav.sim.wind import WindPart
from robustnav.strapdown.static import Place


@dataclass(frozen=True)
class SensorErrors:
    """Errors of three equal axes, in the sensor's unit.

    Parameters
    ----------
    bias : size of the constant bias; its sign is drawn for each axis.
    white_sd : of one sample's mean rate or force.
    markov_sd, markov_time : stationary first-order Gauss-Markov bias and its correlation time [s]; it steps once an
        interval of the filter.
    """

    bias: float
    white_sd: float
    markov_sd: float
    markov_time: float


@dataclass(frozen=True)
class Scenario:
    """A carrier that sways at one place, an inertial unit on it, and a velocity reference in the wind.

    Parameters
    ----------
    name : for reports.
    sway : motion about level axes turned by ``heading``.
    heading : [rad], or None: drawn for each run.
    latitude, height : geodetic [rad], above the WGS-84 ellipsoid [m].
    duration : [s].
    imu_rate_hz, filter_rate_hz : of the unit's samples, and of increments and reference readings.
    gyro, accel : errors [rad/s], [m/s^2].
    velocity_sd : white noise of the reference by axis [m/s].
    misalignment : sizes (3,) of the rotation vector, axes of n [rad], from the true attitude to the one an estimator
        is started at; the signs are drawn.
    wind : what is added to the reference.

    Raises
    ------
    InputError : rates and duration that do not divide, or a place beyond the poles.
    """

    name: str
    sway: Sway
    heading: float | None
    latitude: float
    height: float
    duration: float
    imu_rate_hz: float
    filter_rate_hz: float
    gyro: SensorErrors
    accel: SensorErrors
    velocity_sd: float
    misalignment: tuple[float, float, float]
    wind: tuple[WindPart, ...]

    def __post_init__(self) -> None:
        _whole("samples an interval of the filter", self.imu_rate_hz / self.filter_rate_hz)
        _whole("filter intervals in the duration", self.duration * self.filter_rate_hz)
        Place.at(self.latitude, self.height)

    @property
    def every(self) -> int:
        """Inertial samples in an interval of the filter."""
        return round(self.imu_rate_hz / self.filter_rate_hz)

    @property
    def intervals(self) -> int:
        """Filter intervals in the duration."""
        return round(self.duration * self.filter_rate_hz)

    @property
    def place(self) -> Place:
        """Earth rate and gravity where the carrier is."""
        return Place.at(self.latitude, self.height)


def _whole(thing: str, number: float) -> None:
    if number < 1 or abs(number - round(number)) > 1e-9 * number:
        raise InputError(f"alignment scenario, {thing}", got=f"{number:g}", expected="a whole number, at least one")
