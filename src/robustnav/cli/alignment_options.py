"""Options of ``align`` in groups: where and what, what holds it down, which part, or a simulation instead."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from cyclopts import Parameter

from robustnav.cli.options import Flag

ReferenceName = Literal["velocity", "zero", "gnss"]


@Parameter(name="*")
@dataclass(frozen=True)
class Carrier:
    """Where the unit is and what it is."""

    latitude: float | None = None
    """Geodetic latitude [deg], north positive; default: the recording's own, if it states one."""
    height: float | None = None
    """Height above the ellipsoid [m]; default: the recording's own, else 0."""
    imu: str | None = None
    """Data-sheet preset of the IMU, or a TOML file."""
    grade: str | None = None
    """In place of --imu: gyro and accelerometer with their units, as in 0.01deg/h,0.1mg."""


@Parameter(name="*")
@dataclass(frozen=True)
class Reference:
    """What holds the alignment down."""

    reference: ReferenceName = "velocity"
    """The recording's stream velocity; zero: a base at rest, nothing measured; gnss: a carrier in motion."""
    reference_sd: float = 0.05
    """White noise of a reading [m/s]; with zero, how much the base trembles."""
    compass: Flag = False
    """Use the recording's magnetometer for the heading."""
    declination: float | None = None
    """From true to magnetic north, east positive [deg]; default: the recording's own, if it states one."""
    compass_sd: float = 2.0
    """White noise of the compass [deg]."""
    compass_bias_sd: float = 5.0
    """Constant error of the compass [deg]: iron near it, mounting, declination."""


@Parameter(name="*")
@dataclass(frozen=True)
class Satellites:
    """What is known of the receiver and the unit of a carrier in motion, with --reference gnss."""

    velocity_sd: float | None = None
    """Noise of a velocity on each axis [m/s]; default: what the receiver claims, if the recording states it."""
    position_sd: float | None = None
    """Noise of a position on each axis [m]; default: what the receiver claims, if the recording states it."""
    lever: str | None = None
    """From the unit to the antenna, forward, right, down [m], as in 0.3,-0.2,-0.5."""
    delay: float = 0.0
    """How late the receiver's stamps are [s]."""
    heading_sd: float = 15.0
    """With --compass: how far off the magnetometer's heading is, lastingly [deg]."""
    gyro_bias_sd: float | None = None
    """What a calibration leaves of the gyro's bias on each axis [deg/s]; default: that of --imu or --grade."""
    accel_bias_sd: float | None = None
    """What a calibration leaves of the accelerometer's bias on each axis [m/s^2]; default: that of --imu or --grade."""


@Parameter(name="*")
@dataclass(frozen=True)
class Part:
    """Which part of a recording, and how it is cut."""

    start: float | None = None
    """Begin here [s]."""
    stop: float | None = None
    """End here [s]."""
    longest: Flag = False
    """Of a recording with gaps take the longest piece."""
    period: float = 0.1
    """Of the increments and the filter [s]; 0.1 to 0.5, a whole number of them to the second."""
    mapping: Path | None = None
    """TOML file naming columns, units and frames of a foreign table."""


@Parameter(name="*")
@dataclass(frozen=True)
class Simulated:
    """A simulated carrier in place of a recording."""

    scenario: str | None = None
    """s-10-10-60, s-30-30-170, h-10-10-60, h-30-30-170, or a TOML file of your own."""
    wind: str | None = None
    """lines, printed, gusts, markov, lines-markov or none; default: the file's own, or lines."""
    seed: int = 0
    """Fixes every random number."""


CARRIER, REFERENCE, SATELLITES, PART, SIMULATED = Carrier(), Reference(), Satellites(), Part(), Simulated()
