"""What is told of an inertial unit and its satellite receiver, and how a moving carrier's filter starts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians, sqrt
from typing import Any

import numpy as np

from robustnav.earth import earth_rate_n, normal_gravity
from robustnav.errors import InputError
from robustnav.filter.weighting import StudentT
from robustnav.model.blocks import Model
from robustnav.models.inertial import AidingNoise, InertialNoise, inertial
from robustnav.records import Log
from robustnav.run.estimators import EKF
from robustnav.run.inertial_start import check_start
from robustnav.units import DEG, STANDARD_GRAVITY


@dataclass(frozen=True)
class InertialUnit:
    """An inertial unit: its ``noise`` in motion, and its biases when it is switched on, one standard deviation an axis.

    ``gyro_bias_sd`` [rad/s], ``accel_bias_sd`` [m/s^2].
    """

    noise: InertialNoise
    gyro_bias_sd: float
    accel_bias_sd: float

    def __post_init__(self) -> None:
        for name in ("gyro_bias_sd", "accel_bias_sd"):
            _positive(f"inertial unit {name}", getattr(self, name))

    @classmethod
    def from_datasheet(
        cls, imu: str, *, gyro_bias_density: float, accel_bias_density: float, gyro_bias_sd: float, accel_bias_sd: float
    ) -> InertialUnit:
        """Return a unit with the white noise of a preset; the rest is what no data sheet states of a calibrated unit.

        Parameters
        ----------
        imu : preset name, see ``robustnav.datasheet.names()``.
        gyro_bias_density, accel_bias_density : two-sided, as of ``InertialNoise``.
        gyro_bias_sd, accel_bias_sd : what is left of the biases [rad/s], [m/s^2].

        Raises
        ------
        InputError : unknown preset, or one that states no noise density.
        """
        from robustnav import datasheet

        spec = datasheet.imu(imu)
        intensities = spec.gyro.intensity, spec.accel.intensity
        if intensities[0] is None or intensities[1] is None:
            raise InputError(f"noise of {imu!r}", got="no density", expected="a density of gyro and accelerometer")
        noise = InertialNoise(sqrt(intensities[0]), sqrt(intensities[1]), gyro_bias_density, accel_bias_density)
        return cls(noise, gyro_bias_sd, accel_bias_sd)


@dataclass(frozen=True)
class GnssAiding:
    """What is known of a receiver's readings, and of a compass beside it; a reading without its sd is not used.

    Parameters
    ----------
    velocity_sd : of ``gnss_velocity`` on each axis [m/s], or None.
    position_sd : of ``gnss_position`` on each axis [m], or None.
    heading_sd : how far off a compass is, lastingly: only the first ``heading`` after the start is used [rad], or None.
    declination : from true to magnetic north, east positive [rad]: without a ``heading`` the first ``mag`` is one.
    lever_b : (3,) from the inertial unit to the antenna [m].
    delay : how late the stamps of velocity and position are [s]; they are moved back by it.

    Raises
    ------
    InputError : neither velocity nor position, or a number out of its range.
    """

    velocity_sd: float | None = None
    position_sd: float | None = None
    heading_sd: float | None = None
    declination: float | None = None
    lever_b: tuple[float, float, float] = (0.0, 0.0, 0.0)
    delay: float = 0.0

    def __post_init__(self) -> None:
        if self.velocity_sd is None and self.position_sd is None:
            raise InputError("GNSS aiding", got="no sd", expected="velocity_sd, position_sd or both")
        for name in ("velocity_sd", "position_sd", "heading_sd"):
            if (value := getattr(self, name)) is not None:
                _positive(f"GNSS {name}", value)
        if self.declination is not None and not (self.heading_sd and abs(self.declination) <= radians(180)):
            got = f"declination {self.declination} rad, heading_sd {self.heading_sd}"
            raise InputError("GNSS declination", got=got, expected="-pi to pi rad, and a heading_sd beside it")
        if np.shape(self.lever_b) != (3,) or not np.isfinite([*self.lever_b, self.delay]).all():
            got = f"lever {self.lever_b}, delay {self.delay}"
            raise InputError("GNSS lever_b and delay", got=got, expected="three finite metres and finite seconds")


@dataclass(frozen=True)
class MovingStart:
    """How the filter of a moving carrier starts, and starts again when it is lost.

    Parameters
    ----------
    headings : filters that begin with headings all round.
    window : readings this young tell tilt and velocity [s]; doubled up to ``patience`` where they do not.
    patience : the longest window [s].
    tilt_sd : a start whose tilt is worse waits [rad].
    found_sd : the heading counts as found once its standard deviation over all filters is below this [rad].
    latitude : geodetic [rad], for gravity and the Earth's rate; None: the log's ``latitude_deg``, and where it has
        none, standard gravity and an Earth at rest.
    restart : whether a lost filter is started again.

    Raises
    ------
    InputError : fewer than four headings, a latitude beyond the poles, or a number that is not positive.
    """

    headings: int = 24
    window: float = 1.0
    patience: float = 16.0
    tilt_sd: float = 4 * DEG
    found_sd: float = 5 * DEG
    latitude: float | None = None
    restart: bool = True

    def __post_init__(self) -> None:
        positive = ("window", "patience", "tilt_sd", "found_sd")
        check_start(self.headings, **{name: getattr(self, name) for name in positive})
        if self.latitude is not None and not abs(self.latitude) <= radians(90):
            raise InputError("latitude", got=f"{self.latitude} rad", expected="-pi/2 to pi/2 rad")


def moving_ekf(log: Log, unit: InertialUnit, aiding: GnssAiding, latitude: float | None = None) -> EKF:
    """Return the filter that ``align_moving`` runs: the inertial model at the log's place, Student-t for every reading.

    Parameters
    ----------
    log : its ``info`` may tell ``latitude_deg`` and ``height_m``.
    unit, aiding : noise of what is fused.
    latitude : geodetic [rad]; None: the log's.
    """
    given = {
        "velocity_sd": aiding.velocity_sd,
        "position_sd": aiding.position_sd,
        "heading_sd": aiding.heading_sd,
    }
    noise = AidingNoise(**{name: sd for name, sd in given.items() if sd is not None})
    model = inertial(unit.noise, noise, **_place(log, latitude))
    return EKF(_with_biases(model, unit), {name: StudentT() for name in ("velocity", "position", "heading")})


def _with_biases(model: Model, unit: InertialUnit) -> Model:
    biases = {"gyro_bias": unit.gyro_bias_sd, "accel_bias": unit.accel_bias_sd}
    return replace(model, start_sd={**model.start_sd, **biases})


def latitude_of(log: Log, latitude: float | None) -> float | None:
    """Return the latitude [rad] that is given, or else the log's, or None."""
    told = log.info.get("latitude_deg")
    return latitude if latitude is not None or told is None else radians(float(told))


def _place(log: Log, latitude: float | None) -> dict[str, Any]:
    where = latitude_of(log, latitude)
    if where is None:
        return {"gravity": STANDARD_GRAVITY}
    gravity = normal_gravity(where, float(log.info.get("height_m", 0.0)))
    return {"gravity": gravity, "earth_rate_n": earth_rate_n(where)}


def _positive(thing: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise InputError(thing, got=str(value), expected="a number above zero")
