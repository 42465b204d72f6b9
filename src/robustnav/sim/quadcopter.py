"""A quadcopter among ultra-wideband anchors: the setting of the published filter, and all that we had to assume.

The published system is a line calibration, a filter on position and velocity with the acceleration as process noise,
and an outlier test.  Flight, anchors, rates and noise figures are not published.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

from robustnav.records import Log
from robustnav.sim.attitude_cases import Assumption
from robustnav.sim.batch import Batch, Environment, Sensors, simulate
from robustnav.sim.ranging import RangingBatch, simulate_ranging
from robustnav.sim.ranging_errors import Colour, LinkLine, Nlos, Outliers, RangingErrors
from robustnav.sim.ranging_path import FigureEight, Leg, Path, Rest, SampledPath, Segment, States
from robustnav.sim.ranging_setup import RangingSetup, Schedule, ring_pairs
from robustnav.sim.rig import hall
from robustnav.units import STANDARD_GRAVITY

ROUNDS_HZ = 10.0
SLOPE, OFFSET, SIGMA = 1.0045, 0.075, 0.05
COLOUR_SD, COLOUR_TAU, WHITE_SD = 0.12, 3.0, 0.05
OUTLIER_SHARE, NLOS_SHARE = 0.006, 0.05
_SQUARE = ((3.5, 2.5, -1.0), (3.5, -2.5, -2.8), (-3.5, -2.5, -1.2), (-3.5, 2.5, -3.2), (0.0, 0.0, -2.0))


def flight() -> Path:
    """Return the flight: take-off, hover, two figures of eight, five climbing and sinking legs, hover, landing.

    77 s inside ``rig.hall``; 5.3 m/s, 8 m/s^2 and 37 deg of tilt at most; the nose makes a whole turn on the way.
    """
    legs = [Leg(to, 5.0, pi / 4) for to in _SQUARE]
    segments: tuple[Segment, ...] = (
        Leg((0.0, 0.0, -1.2), 4.0),
        Rest(4.0),
        FigureEight(3.5, 2.0, 0.6, 2, 28.0, pi / 2),
        *legs,
        Rest(10.0, pi / 4),
        Leg((0.0, 0.0, 0.0), 6.0),
    )
    return Path((0.0, 0.0, 0.0), 0.0, segments, STANDARD_GRAVITY, tilts=True)


def published_errors() -> RangingErrors:
    """Return the errors that the published range model knows: a line and white noise."""
    return RangingErrors(white_sd=SIGMA, line=LinkLine(SLOPE, OFFSET, 0.0, 0.0))


def measured_errors() -> RangingErrors:
    """Return errors like those of recordings with calibrated ranges: small and white at rest, coloured in motion."""
    return RangingErrors(
        white_sd=WHITE_SD,
        colour=Colour(COLOUR_SD, COLOUR_TAU),
        nlos=Nlos(NLOS_SHARE, 2.0, 0.3, "exponential"),
        outliers=Outliers(OUTLIER_SHARE, -4.0, 2.0),
        dropout_share=0.02,
    )


def ranges_setup(errors: RangingErrors) -> RangingSetup:
    """Return two-way ranges of the flight to the anchors of the hall, one at a time."""
    return RangingSetup(hall(), Schedule(ROUNDS_HZ, flight().duration, simultaneous=False), errors)


def differences_setup(errors: RangingErrors) -> RangingSetup:
    """Return range differences of the flight between neighbouring anchors of the hall, one at a time."""
    return replace(ranges_setup(errors), pairs=ring_pairs(len(hall().ids)))


def assumptions() -> tuple[Assumption, ...]:
    """Return what the setting assumes beyond the published text, for a report."""
    static = "static ranges of a DW1000 pair, four heights, 2 m to 60 m"
    moving = "with such figures a filter's covariance holds on recorded drives"
    return (
        Assumption("flight_s", flight().duration, "not published; a battery allows ten times as much"),
        Assumption("anchors", float(len(hall().ids)), "not published; corners of a hall of 12 m x 10 m x 4.5 m"),
        Assumption("rounds_hz", ROUNDS_HZ, "not published; usual for two-way ranging to eight anchors"),
        Assumption("line_slope", SLOPE, f"not published; {static}"),
        Assumption("line_offset_m", OFFSET, f"not published; {static}"),
        Assumption("white_sd_m", SIGMA, f"not published; {static}"),
        Assumption("colour_sd_m", COLOUR_SD, f"not part of the published model; {moving}"),
        Assumption("colour_tau_s", COLOUR_TAU, f"not part of the published model; {moving}"),
        Assumption("nlos_share", NLOS_SHARE, "not part of the published model; a person or a beam in the way"),
        Assumption("outlier_share", OUTLIER_SHARE, "not part of the published model; recordings have 0.004 to 0.009"),
        Assumption("gravity_m_s2", STANDARD_GRAVITY, "not published; standard gravity"),
    )


@dataclass(frozen=True)
class Carried:
    """What flies along: inertial ``sensors`` sampled at ``rate_hz`` [Hz] in an ``environment``."""

    sensors: Sensors
    rate_hz: float
    environment: Environment


@dataclass(frozen=True)
class Flights:
    """Simulated flights: the truth at the IMU's times, its readings, and the ranging."""

    states: States
    imu: Batch
    ranging: RangingBatch

    def log(self, run: int) -> Log:
        """Return one run as a recording with position, velocity and attitude as truth.

        Raises
        ------
        InputError : ``run`` was not simulated.
        """
        log, readings = self.imu.log(run), self.ranging.stream(run)
        streams = {**log.streams, readings.name: readings}
        return replace(log, streams=streams, truth=self.states.truth(self.imu.north))


def simulate_flights(path: Path, setup: RangingSetup, carried: Carried, *, runs: int | range, seed: int) -> Flights:
    """Simulate an IMU and ranging along one path.

    Parameters
    ----------
    path, setup, carried : where it flies, what is ranged, what is carried.
    runs, seed : as in ``simulate`` and ``simulate_ranging``, whose random numbers are independent of each other.

    Raises
    ------
    InputError : see ``simulate`` and ``simulate_ranging``.
    """
    sampled = SampledPath(path, carried.rate_hz)
    imu = simulate(sampled, carried.sensors, carried.environment, runs=runs, seed=seed)
    ranging = simulate_ranging(path.at(setup.events.t), setup, runs=runs, seed=seed)
    return Flights(sampled.states(), imu, ranging)
