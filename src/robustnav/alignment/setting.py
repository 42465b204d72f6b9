"""What is known before an alignment starts: place, sensors and how the reference velocity is disturbed."""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from math import cos, isfinite, pi, sqrt

import numpy as np

from robustnav.earth import EARTH_RATE, normal_gravity
from robustnav.errors import InputError
from robustnav.frames import Array

SHORTEST_PERIOD, LONGEST_PERIOD = 0.1, 0.5  # s: the record holds 600 readings and must cover 60 s
WORST_COMPASS = pi / 4  # rad


@dataclass(frozen=True)
class Compass:
    """A compass: ``declination``, white noise ``sd`` of one bearing and its constant error ``bias_sd``, all [rad]."""

    declination: float
    sd: float
    bias_sd: float


@dataclass(frozen=True)
class AlignSetup:
    """Place, sensors and reference of one alignment.

    Parameters
    ----------
    period : time between readings [s], 0.1 to 0.5, a whole number of them to the second.
    latitude : geodetic [rad]; within 85 degrees, nearer the poles gyros cannot find north.
    gravity : [m/s^2].
    gyro_density, accel_density : white noise, two-sided [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)].
    gyro_bias_sd, accel_bias_sd : of each axis at the start [rad/s], [m/s^2].
    gyro_bias_walk, accel_bias_walk : random walk of the biases [rad/s/sqrt(s)], [m/s^2/sqrt(s)].
    reference_sd : white noise of the reference velocity, each axis and reading [m/s].
    gust_sd, gust_share : readings hit by a gust [m/s] and their share, 0 to below 1.
    declination : from true to magnetic north, east positive [rad]; this and the next two are None without a compass.
    compass_sd : white noise of the azimuth of one reading [rad].
    compass_bias_sd : constant error of that azimuth [rad], below 45 degrees: hard iron, mounting, declination.

    Raises
    ------
    InputError : a number that is not finite, not positive (``gust_share`` may be 0), or outside its range; a compass of
        which not all three numbers are given.
    """

    period: float
    latitude: float
    gravity: float
    gyro_density: float
    gyro_bias_sd: float
    gyro_bias_walk: float
    accel_density: float
    accel_bias_sd: float
    accel_bias_walk: float
    reference_sd: float
    gust_sd: float
    gust_share: float
    declination: float | None = None
    compass_sd: float | None = None
    compass_bias_sd: float | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is None:
                continue
            low = name not in ("latitude", "gust_share", "declination") and not value > 0
            if not isfinite(value) or low:
                raise InputError(f"alignment setup {name}", got=f"{value}", expected="a positive number")
        if not SHORTEST_PERIOD <= self.period <= LONGEST_PERIOD or abs(round(1 / self.period) * self.period - 1) > 1e-6:
            raise InputError(
                "alignment setup period",
                got=f"{self.period} s",
                expected=f"{SHORTEST_PERIOD} to {LONGEST_PERIOD} s, a whole number to the second",
                do="pre-integrate the inertial samples over about 0.1 s",
            )
        if not abs(self.latitude) <= 85 * pi / 180:
            raise InputError("alignment setup latitude", got=f"{self.latitude} rad", expected="-85 to 85 degrees")
        if not 0 <= self.gust_share < 1:
            raise InputError("alignment setup gust_share", got=f"{self.gust_share}", expected="0 to below 1")
        self._check_compass()

    def _check_compass(self) -> None:
        given = (self.declination, self.compass_sd, self.compass_bias_sd)
        if given.count(None) not in (0, 3):
            raise InputError(
                "alignment setup compass",
                got=f"declination {given[0]}, compass_sd {given[1]}, compass_bias_sd {given[2]}",
                expected="all three, or none",
            )
        if self.compass_bias_sd is not None and not self.compass_bias_sd < WORST_COMPASS:
            raise InputError(
                "alignment setup compass_bias_sd", got=f"{self.compass_bias_sd} rad", expected="below 45 degrees"
            )

    @classmethod
    def published(cls, gyro_rms: float, accel_rms: float, latitude: float) -> AlignSetup:
        """Return the setting of the published study for sensors of the given grade.

        One rms stands for the constant bias, the Markov bias (3600 s gyro, 1800 s accelerometer) and the white noise
        of each 1 ms sample, on every axis; Wu, Wang and Zhu, AASRI Procedia 9 (2014), section 4.

        Parameters
        ----------
        gyro_rms, accel_rms : [rad/s], [m/s^2].
        latitude : [rad].
        """
        return cls(
            period=0.1,
            latitude=latitude,
            gravity=normal_gravity(latitude),
            gyro_density=gyro_rms * sqrt(1e-3),
            gyro_bias_sd=gyro_rms * sqrt(2),
            gyro_bias_walk=gyro_rms * sqrt(2 / 3600),
            accel_density=accel_rms * sqrt(1e-3),
            accel_bias_sd=accel_rms * sqrt(2),
            accel_bias_walk=accel_rms * sqrt(2 / 1800),
            reference_sd=0.05,
            gust_sd=3.0,
            gust_share=0.05,
        )

    @property
    def numbers(self) -> Array:
        """The fifteen numbers in the order of the C structure; zeros stand for no compass."""
        return np.array([0.0 if value is None else value for value in astuple(self)])

    @property
    def compass(self) -> Compass | None:
        """The compass, None without one."""
        if self.declination is None or self.compass_sd is None or self.compass_bias_sd is None:
            return None
        return Compass(self.declination, self.compass_sd, self.compass_bias_sd)

    def without_compass(self) -> AlignSetup:
        """Return the same without a compass."""
        return replace(self, declination=None, compass_sd=None, compass_bias_sd=None)

    @property
    def horizontal_earth_rate(self) -> float:
        """Length of the horizontal part of the Earth's rotation [rad/s]."""
        return EARTH_RATE * cos(self.latitude)

    @property
    def heading_floor(self) -> float:
        """Heading sd [rad] that the gyro bias alone leaves: bias / (Earth rate, horizontal)."""
        return self.gyro_bias_sd / self.horizontal_earth_rate


@dataclass(frozen=True)
class Wind:
    """A disturbance of the reference velocity, north and east alike.

    ``markov_sd`` [m/s] and ``markov_time`` [s] of a first-order Markov part; ``omega`` and ``omega_sd`` [rad/s], the
    frequencies of up to five lines and how well each is known.
    """

    markov_sd: float
    markov_time: float
    omega: tuple[float, ...] = ()
    omega_sd: tuple[float, ...] = ()


def _bank() -> tuple[Wind, ...]:
    """Return no wind, then of each correlation time [s] those that change by 2 sd^2 / time = 0.00125 2^k [m^2/s^3].

    Readings show the rate of change well and the time badly, and tilt is told from slow wind alone.
    """
    speeds = {1.0: range(2, 12), 3.0: range(1, 12), 9.0: range(10), 27.0: range(8)}
    winds = [Wind(sqrt(0.5 * 0.00125 * 2.0**k * time), time) for time, powers in speeds.items() for k in powers]
    return (Wind(0.0, 4.0), *winds)


BANK = _bank()
AROUND = tuple(Wind(sd, 4.0) for sd in (0.0, 0.035, 0.07, 0.14, 0.28, 0.56, 1.5))  # noise tried while lines are sought
NEXT = (Wind(0.5, 4.0), Wind(1.5, 4.0))  # winds that may come next
MOST_LINES = 5
LINED = 8  # filters with the lines found, each in another noise
