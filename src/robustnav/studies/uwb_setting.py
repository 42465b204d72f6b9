"""The ranging study as data: scenarios, the filters that are compared, and the layouts that cannot tell a position."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from robustnav.filter.weighting import Gate, StudentT
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.models import RangeBias, uwb
from robustnav.records import Anchors, Run
from robustnav.run.acquisition import Acquisition
from robustnav.run.estimators import EKF
from robustnav.run.tracking import ranging_ekf, track
from robustnav.run.tracking_task import Readings
from robustnav.sim import rig
from robustnav.sim.quadcopter import COLOUR_SD, COLOUR_TAU, ROUNDS_HZ, WHITE_SD, flight, measured_errors, ranges_setup
from robustnav.sim.ranging_errors import Colour, LinkLine, Nlos, Outage, Outliers, RangingErrors
from robustnav.sim.ranging_path import FigureEight, Leg, Path, Rest, Segment
from robustnav.sim.ranging_random import WhiteAcceleration
from robustnav.sim.ranging_setup import RangingSetup, Schedule, ring_pairs
from robustnav.sim.trajectory import Vector
from robustnav.units import STANDARD_GRAVITY

RANGE_SD = 0.1  # m, white, of the ranges in all scenarios but the flight's and the coloured one's
OWN_DENSITY = 0.3  # m/s^2/sqrt(Hz), of the tracks drawn from the filters' own model
DENSITY = 2.0  # m/s^2/sqrt(Hz), for a quadcopter that flies to 8 m/s^2
PUBLISHED_GATE = 8.8  # chi-square of one reading at 99.7 %; the published threshold is not stated
OUTLIERS = Outliers(0.2, 0.5, 5.0)  # 20 % of readings late by half a metre to five
BURSTS = Nlos(0.2, 1.0, 1.0, "exponential")  # sight blocked 20 % of the time, a second each, a metre late
FALLS_SILENT, RETURNS = 5.0, 15.0  # s
JUMPS = 7.0  # s
CARRIED: Vector = (3.0, -3.5, -0.8)  # m, how far a kidnapped tag is carried


@dataclass(frozen=True)
class Scenario:
    """Flights of one path, or of tracks drawn from a model, with their ranging.

    Parameters
    ----------
    words : what it is, one line.
    setup : anchors, schedule, errors.
    motion : a path, or a model that tracks are drawn from.
    methods : names of ``METHODS``.
    moved_at : when the tag is carried ``CARRIED`` away [s], or None.
    returns : when ranges come back, or the tag has been moved [s]: recovery counts from here; None: none of it.
    part : share of the study's seeds that it is run with.
    """

    words: str
    setup: RangingSetup
    motion: Path | WhiteAcceleration
    methods: tuple[str, ...]
    moved_at: float | None = None
    returns: float | None = None
    part: float = 1.0


def own_motion() -> WhiteAcceleration:
    """Return the model that tracks are drawn from where a filter is held against its bound."""
    density = (OWN_DENSITY,) * 3
    return WhiteAcceleration((0.0, 0.0, -2.0), (0.0, 0.0, 0.0), (0.3, 0.3, 0.3), (0.5, 0.5, 0.5), density)


def circuit(duration: float) -> Path:
    """Return a quadcopter's figures of eight in the hall."""
    around = (FigureEight(3.5, 2.0, 0.6, max(1, round(duration / 12.0)), duration),)
    return Path((0.0, 0.0, -1.2), 0.0, around, STANDARD_GRAVITY, tilts=True)


def white_model(range_sd: float = RANGE_SD, density: float = DENSITY) -> Model:
    """Return the model with white noise alone."""
    return uwb(range_sd=range_sd, acceleration_density=density)


def biased_model(density: float = DENSITY) -> Model:
    """Return the model that estimates coloured errors of the anchors, with the figures they are simulated with."""
    return uwb(range_sd=WHITE_SD, acceleration_density=density, bias=RangeBias(COLOUR_SD, COLOUR_TAU, 1e-4))


def _method(estimator: EKF, *, restart: bool = True, smooth: bool = False) -> Callable[[Readings], Run]:
    settings = Acquisition(restart=restart)
    return lambda readings: track(estimator, readings, acquisition=settings, smooth=smooth)


def methods(range_sd: float = RANGE_SD) -> dict[str, Callable[[Readings], Run]]:
    """Return what is compared, by name: from readings to a run, without a prior.

    ``published`` is the published filter and outlier test, which never starts again; ``gate`` the same with our
    restart; ``student`` our default; ``smoother`` goes back over it; ``biased`` estimates the anchors' errors.
    """
    model = white_model(range_sd)
    return {
        "published": _method(ranging_ekf(model, Gate(PUBLISHED_GATE)), restart=False),
        "gate": _method(ranging_ekf(model, Gate(PUBLISHED_GATE))),
        "student": _method(ranging_ekf(model, StudentT())),
        "smoother": _method(ranging_ekf(model, StudentT()), smooth=True),
        "biased": _method(ranging_ekf(biased_model(), StudentT())),
        "biased-smoother": _method(ranging_ekf(biased_model(), StudentT()), smooth=True),
    }


def hall_setup(duration: float, errors: RangingErrors) -> RangingSetup:
    """Return two-way ranges in the hall, one at a time."""
    return RangingSetup(rig.hall(), Schedule(ROUNDS_HZ, duration, simultaneous=False), errors)


def scenarios() -> dict[str, Scenario]:
    """Return the scenarios in which filters start without a prior, by name."""
    white = RangingErrors(white_sd=RANGE_SD)
    silent = replace(white, outages=(Outage(FALLS_SILENT, RETURNS, None),))
    robust, long = ("published", "gate", "student"), circuit(20.0)
    differences = replace(hall_setup(12.0, white), pairs=ring_pairs(8))
    return {
        "clean": Scenario("Gaussian ranges", hall_setup(12.0, white), circuit(12.0), ("gate", "student")),
        "outliers": Scenario(
            "20 % of ranges late by 0.5 m to 5 m",
            hall_setup(12.0, replace(white, outliers=OUTLIERS)),
            circuit(12.0),
            ("published", "student"),
        ),
        "nlos bursts": Scenario(
            "each anchor blocked 20 % of the time, 1 s on end, 1 m late on average",
            hall_setup(12.0, replace(white, nlos=BURSTS)),
            circuit(12.0),
            ("published", "student"),
        ),
        "outage": Scenario("no range for 10 s", hall_setup(20.0, silent), long, robust, returns=RETURNS),
        "kidnapped": Scenario(
            "no range for 10 s, the tag carried 4.7 m away meanwhile",
            hall_setup(20.0, silent),
            long,
            robust,
            moved_at=0.5 * (FALLS_SILENT + RETURNS),
            returns=RETURNS,
        ),
        "jump": Scenario(
            "the tag jumps 4.7 m between two ranges",
            hall_setup(12.0, white),
            circuit(12.0),
            robust,
            moved_at=JUMPS,
            returns=JUMPS,
        ),
        "differences": Scenario(
            "differences of ranges between neighbouring anchors, 20 % of them gross errors",
            replace(differences, errors=replace(white, outliers=Outliers(0.2, -5.0, 5.0))),
            circuit(12.0),
            ("gate", "student"),
        ),
        FLIGHT: Scenario(
            "the quadcopter's flight: line, colour, bursts, outliers, losses",
            ranges_setup(replace(measured_errors(), line=LinkLine(1.0045, 0.075, 0.0, 0.0))),
            flight(),
            ("published", "gate", "student", "biased", "smoother", "biased-smoother"),
            part=0.1,
        ),
    }


FLIGHT = "flight"


def coloured_errors() -> RangingErrors:
    """Return ranges whose errors last: what the recordings have."""
    return RangingErrors(white_sd=WHITE_SD, colour=Colour(COLOUR_SD, COLOUR_TAU))


@dataclass(frozen=True)
class Doubtful:
    """Anchors, and a path among them, that ranges may not tell a position for."""

    words: str
    anchors: Anchors
    path: Path


def doubtful() -> dict[str, Doubtful]:
    """Return layouts and paths that invite a confident wrong answer, by name."""
    flat, hall = rig.ceiling(), rig.hall()
    below = _level((1.0, 1.0, -1.2), (3.0, -2.0, -2.0), (-3.0, -1.0, -1.0), (0.0, 2.0, -1.5))
    through = _level((1.0, 1.0, -1.5), (2.0, -2.0, -5.5), (-3.0, -1.0, -6.0), (0.0, 2.0, -2.0))
    within = _level((1.0, 1.0, -4.0), (2.0, -2.0, -4.0), (-1.0, -1.0, -1.5), (2.0, 2.0, -1.0))
    far = _level((60.0, 40.0, -1.2), (50.0, 30.0, -2.0), (60.0, 20.0, -1.0))
    line = Anchors(flat.ids, np.array([[x, 0.0, -1.0] for x in (-6.0, -2.0, 2.0, 6.0)]))
    bent = Anchors(flat.ids, flat.p_a + _DENTS)
    return {
        "below the plane": Doubtful("four anchors in one plane, the tag below it", flat, below),
        "through the plane": Doubtful("the tag passes to the other side and back", flat, through),
        "in the plane": Doubtful("the tag starts in the anchors' plane, then sinks", flat, within),
        "anchors in line": Doubtful("four anchors on a line", line, below),
        "far from a hall": Doubtful("50 m from the anchors of a hall of 12 m", hall, far),
        "far from a rig": Doubtful("50 m from the anchors of a rig of 5 m", rig.vehicle_rig(), far),
        "nearly a plane, below": Doubtful("anchors 0.12 m off a plane, the tag below it", bent, below),
        "nearly a plane, through": Doubtful("anchors 0.12 m off a plane, the tag passes through it", bent, through),
    }


_DENTS: Array = np.array([[0.0, 0.0, 0.1], [0.0, 0.0, -0.1], [0.0, 0.0, 0.15], [0.0, 0.0, -0.12]])
HARD = ("nearly a plane, through",)  # what is not promised


def _level(start: Vector, *stops: Vector) -> Path:
    legs: tuple[Segment, ...] = (Rest(1.0), *(Leg(to, 6.0) for to in stops))
    return Path(start, 0.0, legs, STANDARD_GRAVITY, tilts=False)
