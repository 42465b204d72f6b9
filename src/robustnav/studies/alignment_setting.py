"""What the alignment study compares: scenarios, winds, the published model, estimators and where they start."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from robustnav.alignment import AlignSetup
from robustnav.alignment.heading_bank import HeadingBank
from robustnav.alignment.riekf import Correction
from robustnav.filter.ukf import Spread
from robustnav.frames import Array, quat_from_rotvec, quat_multiply
from robustnav.model import Model
from robustnav.models import AlignmentNoise, alignment
from robustnav.run import UKF, HInfinity, Start
from robustnav.sim.alignment import AlignmentData, load_scenario, scenario_names
from robustnav.sim.alignment_scenario import Scenario
from robustnav.units import DEG

GAMMA = 5.0
SENSOR_SIZED, UNIT = 0.1, 1.0  # m/s: measurement weights of the two published filters
SPREAD = Spread(1.0, 2.0)  # of sigma points, alpha and beta as published
VELOCITY_SD = 3.0  # m/s, at the start
DRAWS = 4000
PUBLISHED = "lines"  # the published wind with phases drawn for each run
COMPARED = {
    PUBLISHED: "the published lines, phases drawn for each run",
    "printed": "the published lines with the phases as printed",
    "gusts": "the published lines, and 5 % of readings off by 3 m/s",
    "markov": "a Gauss-Markov wind of 0.5 m/s and 4 s, no lines",
    "none": "no wind",
}
CHANGING = {
    "changing": "lines, after 100 s the Gauss-Markov wind",
    "changing-back": "the Gauss-Markov wind, after 100 s lines",
    "changing-mean": "lines, after 100 s about another mean, with other phases",
}
OTHER = {
    "markov-strong": "a Gauss-Markov wind of 1 m/s and 8 s, no lines",
    "lines-markov": "lines and a Gauss-Markov wind of 0.2 m/s and 4 s",
}
WINDS = COMPARED | CHANGING | OTHER
LATITUDES_DEG = (0.0, 45.0, 75.0)
UNITS = ("s", "h")  # of the gyro errors: 0.01 deg/s, 0.01 deg/h
OURS = "align"
METHODS = {
    "ukf": "UKF on the published model, measurement weight 0.1 m/s",
    "ukf-r1": "the same UKF with the H-infinity filter's weight, 1 m/s",
    "hinf": "the published filter: unscented, H-infinity, weight 1 m/s, gamma 5, L = I",
    "riekf": "right-invariant EKF, weight 1 m/s, first-order covariance transport",
    "riekf-lie": "the same, corrections and covariance along the group",
    "bank": "twelve headings and backtracking over an EKF on SO(3), told the wind's frequencies; 15 or 60 s late",
    OURS: "robustnav.alignment.align: any heading, wind found online",
}
BOUNDS = {
    "told": "one filter of align, told the wind exactly: what remains is not the wind's doing",
    "floor": "the sensors' biases alone, averaged since the start: tilt from level force, heading from the east rate",
}
BANK_JUDGED = {"s": 15.0, "h": 60.0}  # s; fine gyros tell headings apart, but slowly
BANK_WINDS = (PUBLISHED, "printed")  # it knows lines, of known frequency, and nothing else
INVARIANT: dict[str, Correction] = {"riekf": "first order", "riekf-lie": "lie"}


@dataclass(frozen=True)
class Case:
    """A scenario in a wind at a latitude [deg], None for the scenario's own."""

    scenario: str
    wind: str = PUBLISHED
    latitude_deg: float | None = None

    @property
    def name(self) -> str:
        """The scenario's name, with wind and latitude where they are not the published ones."""
        wind = "" if self.wind == PUBLISHED else f"-{self.wind}"
        return f"{self.scenario}{wind}" + ("" if self.latitude_deg is None else f"-{self.latitude_deg:g}deg")

    @property
    def unit(self) -> str:
        """Unit of the gyro errors: ``s`` or ``h``."""
        return self.scenario.split("-")[0]

    @property
    def methods(self) -> tuple[str, ...]:
        """The methods and bounds that run: the rivals only in winds to compare in, at the scenario's latitude."""
        if self.latitude_deg is not None or self.wind not in COMPARED:
            return (OURS, *BOUNDS)
        return (*(name for name in METHODS if name != "bank" or self.wind in BANK_WINDS), *BOUNDS)

    @property
    def tried(self) -> bool:
        """Whether ``align`` is held against single winds, fixed beforehand."""
        return self.wind == "markov" or self.wind in CHANGING

    def load(self) -> Scenario:
        """Return what is simulated."""
        scenario = load_scenario(self.scenario, self.wind)
        return scenario if self.latitude_deg is None else replace(scenario, latitude=self.latitude_deg * DEG)


def all_cases() -> tuple[Case, ...]:
    """Return all cases; where only ``align`` runs, which is told of no start, one start is enough.

    The printed phases are one realisation: they run with the gyros as printed.
    """
    names = scenario_names()
    compared = [Case(n, wind) for wind in COMPARED for n in names if wind != "printed" or n.startswith("s-")]
    near = [next(n for n in names if n.startswith(f"{unit}-")) for unit in UNITS]
    others = [Case(n, wind) for wind in CHANGING | OTHER for n in near]
    return (*compared, *others, *(Case(n, latitude_deg=deg) for deg in LATITUDES_DEG for n in near))


def stations(cases: Iterable[Case]) -> list[tuple[Case, ...]]:
    """Return cases by unit and place: those together whose inertial data are the same."""
    found: dict[tuple[str, float | None], list[Case]] = {}
    for case in cases:
        found.setdefault((case.unit, case.latitude_deg), []).append(case)
    return [tuple(group) for group in found.values()]


def estimators(scenario: Scenario) -> dict[str, UKF | HInfinity]:
    """Return the filters on the published model, by name, tuned to a scenario's sensors."""
    unit, sensor_sized = (_model(scenario, sd) for sd in (UNIT, SENSOR_SIZED))
    return {
        "ukf": UKF(sensor_sized, SPREAD),
        "ukf-r1": UKF(unit, SPREAD),
        "hinf": HInfinity(unit, GAMMA, spread=SPREAD),
    }


def setup_of(scenario: Scenario) -> AlignSetup:
    """Return what ``align`` is told of a scenario: place and sensors, nothing of wind or start."""
    return AlignSetup.published(scenario.gyro.white_sd, scenario.accel.white_sd, scenario.latitude)


def bank_of(case: Case) -> HeadingBank:
    """Return the bank of headings that is told the frequencies of a case's wind."""
    lines = tuple(line.frequency for line in case.load().wind[0].lines)
    return HeadingBank(lines, judged=BANK_JUDGED[case.unit])


def start_of(data: AlignmentData, estimator: UKF | HInfinity) -> Start:
    """Return where the filters on the published model start: the covariance of the quaternion is that of the draw."""
    setup, q = setup_of(data.scenario), data.q_nb_start
    sd = {"v_n": VELOCITY_SD, "gyro_bias": setup.gyro_bias_sd, "accel_bias": setup.accel_bias_sd}
    start = Start.at(estimator.model, sd, quaternion=q)
    part = estimator.model.error_slices["quaternion"]
    times_q = quat_multiply(np.eye(4), q).T  # the matrix that takes w to w * q
    start.P[part, part] = times_q @ _spread(data.scenario.misalignment) @ times_q.T
    return start


def _model(scenario: Scenario, velocity_sd: float) -> Model:
    setup, place = setup_of(scenario), scenario.place
    noise = AlignmentNoise(
        gyro_density=setup.gyro_density,
        accel_density=setup.accel_density,
        gyro_bias_density=setup.gyro_bias_walk,
        accel_bias_density=setup.accel_bias_walk,
        velocity_sd=velocity_sd,
    )
    return alignment(
        noise,
        gravity=float(place.gravity_n[2]),
        earth_rate_north=float(place.earth_rate_n[0]),
        earth_rate_down=float(place.earth_rate_n[2]),
    )


@lru_cache(maxsize=8)
def _spread(misalignment: tuple[float, float, float]) -> Array:
    """Return the covariance (4, 4) of Exp(m), m normal with standard deviations ``misalignment`` [rad]."""
    m = np.random.default_rng(0).standard_normal((DRAWS, 3)) * misalignment
    out: Array = np.cov(quat_from_rotvec(m).T) + 1e-10 * np.eye(4)
    return out
