"""Runs of an initial alignment: pre-integrated increments, a velocity reference in the wind, and the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from math import exp, pi

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array, quat_from_rotvec, quat_multiply
from robustnav.records import Stream, Truth
from robustnav.sim.alignment_file import load_scenario, scenario_names, wind_names
from robustnav.sim.alignment_scenario import Scenario, SensorErrors
from robustnav.sim.sway import Sway, SwayIncrements, attitude_n, sway_increments
from robustnav.sim.wind import gauss_markov, wind
from robustnav.strapdown.increments import ImuSamples, Increments
from robustnav.strapdown.preintegration import preintegrate

__all__ = [
    "AlignmentData",
    "Unit",
    "in_other_wind",
    "load_scenario",
    "scenario_names",
    "simulate_alignment",
    "simulate_alignments",
    "simulate_unit",
    "wind_names",
]

Preintegrate = Callable[[ImuSamples, int], Increments]

# The place in the tuple numbers the random streams: append, do not reorder.
_DRAWS = ("heading", "start", "gyro", "accel", "velocity", "wind")


@dataclass(frozen=True)
class AlignmentData:
    """One run.

    Parameters
    ----------
    scenario, seed : what was simulated.
    increments : over the n intervals of the filter.
    velocity : the reference's readings (n, 3) [m/s] in north-east-down, at the intervals' ends.
    truth : attitude and velocity at the n + 1 instants, the start first; true north.
    gyro_bias, accel_bias : (n + 1, 3) [rad/s], [m/s^2]; row k holds from instant k to k + 1.
    wind_n : (n, 3) what disturbed the reference [m/s].
    q_nb_start : (4,) the attitude to start an estimator at: the truth turned by the scenario's misalignment.
    """

    scenario: Scenario
    seed: int
    increments: Increments
    velocity: Stream
    truth: Truth
    gyro_bias: Array
    accel_bias: Array
    wind_n: Array
    q_nb_start: Array

    @property
    def q_nb(self) -> Array:
        """The true attitude (n + 1, 4)."""
        if self.truth.q_nb is None:
            raise InputError("simulated alignment", got="a truth without attitude", expected="q_nb")
        return self.truth.q_nb


@dataclass(frozen=True)
class Unit:
    """What one inertial unit measured: samples, and biases (n + 1, 3) at the filter's instants; heading [rad]."""

    samples: ImuSamples
    gyro_bias: Array
    accel_bias: Array
    heading: float


def simulate_alignment(scenario: Scenario, seed: int, preintegrate: Preintegrate = preintegrate) -> AlignmentData:
    """Simulate one run.

    Parameters
    ----------
    scenario : from ``load_scenario``, or made.
    seed : not negative; fixes heading, start, biases and noises.  A stream of its own for each, so that another wind
        changes no inertial sample.
    preintegrate : turns samples into increments; ``robustnav.engine.strapdown.preintegrate`` does it in C.

    Raises
    ------
    InputError : a negative seed, or a sway too fast for the unit's rate.
    """
    unit = simulate_unit(scenario, seed)
    n = scenario.intervals
    t = np.arange(n + 1, dtype=np.float64) / scenario.filter_rate_hz
    q_nb = attitude_n(scenario.sway, unit.heading, t)
    velocity, blown = _reference(scenario, seed, t[1:])
    return AlignmentData(
        scenario=scenario,
        seed=seed,
        increments=preintegrate(unit.samples, scenario.every),
        velocity=velocity,
        truth=Truth(t, q_nb, north="true", v_n=np.zeros((n + 1, 3)), accuracy="exact"),
        gyro_bias=unit.gyro_bias,
        accel_bias=unit.accel_bias,
        wind_n=blown,
        q_nb_start=_start(scenario, seed, q_nb[0]),
    )


def in_other_wind(data: AlignmentData, scenario: Scenario) -> AlignmentData:
    """Return what ``simulate_alignment(scenario, data.seed)`` would, from the inertial data already there.

    Parameters
    ----------
    data : a run.
    scenario : one that differs from the run's in name, wind, noise of the reference and misalignment alone.

    Raises
    ------
    InputError : it differs in something else.
    """
    free = {name: getattr(data.scenario, name) for name in ("name", "wind", "velocity_sd", "misalignment")}
    if replace(scenario, **free) != data.scenario:
        raise InputError("other wind", got=scenario.name, expected=f"motion, place and unit of {data.scenario.name}")
    velocity, blown = _reference(scenario, data.seed, data.velocity.t)
    start = _start(scenario, data.seed, data.q_nb[0])
    return replace(data, scenario=scenario, velocity=velocity, wind_n=blown, q_nb_start=start)


def simulate_alignments(
    scenario: Scenario, seeds: Iterable[int], preintegrate: Preintegrate = preintegrate
) -> Iterator[AlignmentData]:
    """Simulate runs one after the other, as ``simulate_alignment``; memory does not grow with their number."""
    for seed in seeds:
        yield simulate_alignment(scenario, seed, preintegrate)


def simulate_unit(scenario: Scenario, seed: int) -> Unit:
    """Simulate an inertial unit at its own rate; arguments and errors as for ``simulate_alignment``."""
    if seed < 0:
        raise InputError("seed", got=f"{seed}", expected="a whole number, not negative")
    drawn = _generator(seed, "heading").uniform(0, 2 * pi)
    heading = drawn if scenario.heading is None else scenario.heading
    true = _swayed(scenario.sway, scenario.intervals * scenario.every, scenario.imu_rate_hz).samples(
        heading, scenario.place
    )
    angle, gyro_bias = _corrupt(true.angle, scenario.gyro, scenario, _generator(seed, "gyro"))
    velocity, accel_bias = _corrupt(true.velocity, scenario.accel, scenario, _generator(seed, "accel"))
    return Unit(ImuSamples(angle, velocity, true.dt), gyro_bias, accel_bias, heading)


@lru_cache(maxsize=1)
def _swayed(sway: Sway, n: int, rate_hz: float) -> SwayIncrements:
    """Keep the sway of the last scenario: all its runs share it."""
    return sway_increments(sway, n, rate_hz)


def _corrupt(true: Array, errors: SensorErrors, scenario: Scenario, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return increments (samples, 3) with errors, and the bias (n + 1, 3) at the filter's instants."""
    n, dt = scenario.intervals, 1 / scenario.imu_rate_hz
    decay = exp(-1 / (scenario.filter_rate_hz * errors.markov_time))
    constant = errors.bias * rng.choice([-1.0, 1.0], 3)
    bias = constant + errors.markov_sd * gauss_markov(rng.standard_normal((n + 1, 3)), decay)
    out = rng.standard_normal(true.shape)
    out *= errors.white_sd * dt
    out += true
    out.reshape(n, scenario.every, 3)[...] += bias[:n, None] * dt
    return out, bias


def _reference(scenario: Scenario, seed: int, t: Array) -> tuple[Stream, Array]:
    """Return the reference's readings, and the wind (n, 3) [m/s] in them."""
    blown = wind(scenario.wind, t, _generator(seed, "wind"))
    noise = scenario.velocity_sd * _generator(seed, "velocity").standard_normal((len(t), 3))
    return Stream("velocity", t, blown + noise, "m/s", "n"), blown


def _start(scenario: Scenario, seed: int, q_nb: Array) -> Array:
    signs = _generator(seed, "start").choice([-1.0, 1.0], 3)
    return quat_multiply(quat_from_rotvec(signs * scenario.misalignment), q_nb)


def _generator(seed: int, draw: str) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_DRAWS.index(draw),)))
