"""What a three-axis sensor adds to the truth, one small function per error, for many runs at once.

reading = clip(round(M * lowpass(truth) + bias + lowpass(white noise))), M = I + scale errors + misalignments,
bias = turn-on bias + random walk + instability.  Temperature effects are not modelled.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi, sqrt

import numpy as np

from robustnav.datasheet.sensors import SensorSpec
from robustnav.frames import Array

INSTABILITY_TIME = 100.0  # s, assumed: data sheets give a level only
GAUSS_MARKOV_PEAK = 0.6174  # highest Allan deviation over sd of a first-order Gauss-Markov process

# The place in each tuple numbers the random streams: append, do not reorder.
SENSORS = ("gyro", "accel", "mag")
RANDOM_ERRORS = ("white_noise", "bias_instability", "random_walk", "turn_on_bias", "scale", "misalignment")


@dataclass(frozen=True)
class ErrorSwitches:
    """Which errors are simulated; one that is on and has no figure in the ``SensorSpec`` adds nothing.

    White noise is the exception: on without a figure, it is refused.
    """

    white_noise: bool = False
    bias_instability: bool = False
    random_walk: bool = False
    turn_on_bias: bool = False
    scale: bool = False
    misalignment: bool = False
    bandwidth: bool = False
    resolution: bool = False
    clipping: bool = False


NO_ERRORS = ErrorSwitches()
ALL_ERRORS = ErrorSwitches(*[True] * 9)
STUDY_ERRORS = ErrorSwitches(white_noise=True, random_walk=True)

_FIGURES = {
    "bias_instability": "bias_instability",
    "random_walk": "random_walk",
    "turn_on_bias": "turn_on_bias_sd",
    "scale": "scale_sd",
    "misalignment": "misalignment_sd",
    "bandwidth": "bandwidth_hz",
    "resolution": "resolution",
    "clipping": "range_max",
}


def active(spec: SensorSpec, errors: ErrorSwitches) -> dict[str, float]:
    """Return the figure of every error that is switched on and stated, by the name of its switch; no white noise."""
    figures = {name: getattr(spec, figure) for name, figure in _FIGURES.items() if getattr(errors, name)}
    return {name: value for name, value in figures.items() if value is not None}


@dataclass(frozen=True)
class Draws:
    """Random numbers of one sensor: those of run i depend on the seed, the sensor, the error and i, on nothing else."""

    seed: int
    runs: range
    sensor: str

    def normal(self, error: str, shape: tuple[int, ...]) -> Array:
        """Return standard normal numbers (runs, *shape)."""
        return np.stack([generator.standard_normal(shape) for generator in self._generators(error)])

    def uniform(self, error: str, shape: tuple[int, ...]) -> Array:
        """Return uniform numbers (runs, *shape) of unit variance, so within +-sqrt(3)."""
        return np.stack([generator.uniform(-sqrt(3), sqrt(3), shape) for generator in self._generators(error)])

    def _generators(self, error: str) -> list[np.random.Generator]:
        stream = (SENSORS.index(self.sensor), RANDOM_ERRORS.index(error))
        return [np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(run, *stream))) for run in self.runs]


@dataclass(frozen=True)
class Sampled:
    """A sensor at its rate: figures, switches and random numbers."""

    spec: SensorSpec
    errors: ErrorSwitches
    rate_hz: float
    draws: Draws


def corrupt(true: Array, sensor: Sampled) -> tuple[Array, Array]:
    """Return readings and bias, both (runs, n, 3), of a sensor that should have read ``true`` (n, 3).

    Raises
    ------
    InputError : white noise is on and the sensor has no noise figure.
    """
    figures = active(sensor.spec, sensor.errors)
    bias = _bias(len(true), sensor, figures)
    pole = _pole(figures, sensor.rate_hz)
    # The low-pass is linear, so the truth is filtered once and not in every run.
    signal = _low_pass(true[None], pole, true[None, 0])[0]
    values = np.einsum("rij,nj->rni", _gain_matrix(sensor.draws, figures), signal) + bias
    if sensor.errors.white_noise:
        values += _white_noise(len(true), sensor, pole)
    return _digitise(values, figures), bias


def _white_noise(n: int, sensor: Sampled, pole: float) -> Array:
    """White at the sample rate, then through the sensor's low-pass, which keeps its density at low frequencies."""
    noise = sensor.spec.sample_sd(sensor.rate_hz) * sensor.draws.normal("white_noise", (n, 3))
    if sensor.spec.density is None:
        return noise  # a total is what is left behind the low-pass
    return _low_pass(noise, pole, noise[:, 0] * sqrt((1 - pole) / (1 + pole)))  # starts at its lasting variance


def _bias(n: int, sensor: Sampled, figures: dict[str, float]) -> Array:
    draws, dt = sensor.draws, 1 / sensor.rate_hz
    bias = np.zeros((len(draws.runs), n, 3))
    if "turn_on_bias" in figures:
        bias += figures["turn_on_bias"] * draws.uniform("turn_on_bias", (1, 3))
    if "random_walk" in figures:
        steps = figures["random_walk"] * sqrt(dt) * draws.normal("random_walk", (n, 3))
        steps[:, 0] = 0.0  # it walks from the turn-on bias
        bias += np.cumsum(steps, axis=1)
    if "bias_instability" in figures:
        bias += _gauss_markov(figures["bias_instability"], dt, draws.normal("bias_instability", (n, 3)))
    return bias


def _gauss_markov(level: float, dt: float, normal: Array) -> Array:
    """First-order Gauss-Markov process, stationary from the start, whose Allan deviation peaks at ``level``.

    The peak is at 1.89 time constants.  Flicker noise would stay at the level for longer; IEEE Std 952, annex B.
    """
    sd = level / GAUSS_MARKOV_PEAK
    pole = exp(-dt / INSTABILITY_TIME)
    # _low_pass weighs its input with 1 - pole; the process needs sqrt(1 - pole^2).
    drive = sd * sqrt((1 + pole) / (1 - pole)) * normal
    return _low_pass(drive, pole, sd * normal[:, 0])


def _gain_matrix(draws: Draws, figures: dict[str, float]) -> Array:
    matrix = np.tile(np.eye(3), (len(draws.runs), 1, 1))
    if "scale" in figures:
        matrix += np.eye(3) * (figures["scale"] * draws.uniform("scale", (1, 3)))
    if "misalignment" in figures:
        matrix += (1 - np.eye(3)) * (figures["misalignment"] * draws.uniform("misalignment", (3, 3)))
    return matrix


def _pole(figures: dict[str, float], rate_hz: float) -> float:
    """Pole of a first-order low-pass of the sensor's bandwidth at the sample rate; 0 passes everything."""
    return exp(-2 * pi * figures["bandwidth"] / rate_hz) if "bandwidth" in figures else 0.0


def _low_pass(x: Array, pole: float, start: Array) -> Array:
    """``y[k] = pole y[k-1] + (1 - pole) x[k]`` along axis 1 of ``x`` (runs, n, 3), ``y[0] = start`` (runs, 3)."""
    y = (1 - pole) * x
    y[:, 0] = start
    if pole > 0:
        for k in range(1, y.shape[1]):
            y[:, k] += pole * y[:, k - 1]
    return y


def _digitise(values: Array, figures: dict[str, float]) -> Array:
    """Round to the resolution and clip to the range, at a whole number of bits inside it."""
    bit, limit = figures.get("resolution"), figures.get("clipping")
    if bit is not None:
        values = np.rint(values / bit) * bit
        # The tolerance keeps the last bit when limit / bit is whole but for rounding.
        limit = None if limit is None else np.floor(limit / bit * (1 + 1e-12)) * bit
    return values if limit is None else np.clip(values, -limit, limit)
