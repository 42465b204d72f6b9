"""Test vectors: inputs, readings and the state that the Python filter reaches with them, step by step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robustnav.engine.backends import functions_of, running_filter
from robustnav.engine.filters import FilterSetup
from robustnav.frames import Array, matrix_from_quat
from robustnav.model.blocks import Model

ROWS = 320
_WHOLE = 0.75  # share of the rows, the first ones, that have every sensor's reading


@dataclass(frozen=True)
class Vectors:
    """What went in and what Python made of it.

    ``start`` (nx,) state at the start; ``dt`` (n,) [s], the first 0; ``u`` (n, nu); ``z`` by sensor (n, width);
    ``present`` (n,) bits of the sensors that were fused; ``x`` (n, nx) the states of the Python filter, in double.
    """

    start: Array
    dt: Array
    u: Array
    z: tuple[Array, ...]
    present: NDArray[np.int_]
    x: Array


@dataclass(frozen=True)
class Plan:
    """How vectors are made: rows a second, how many, and what one count of each column is worth (None: float32)."""

    rate_hz: float
    rows: int = ROWS
    seed: int = 1
    counts: tuple[float, ...] | None = None  # of the input, then of each sensor

    def rounded(self, values: Array, column: int) -> Array:
        """Return numbers as the firmware gets them."""
        if self.counts is None:
            return _single(values)
        unit = self.counts[column]
        whole: Array = np.clip(np.round(values / unit), -32768, 32767) * unit
        return whole


def record(model: Model, setup: FilterSetup, plan: Plan) -> Vectors:
    """Run the Python filter in double along a made-up motion of its own model and keep every step.

    Inputs swing about their nominal values, readings have the model's noise, numbers that travel with a reading are
    drawn anew for each.  Float32 holds every number exactly, so that a firmware's arithmetic alone is compared.
    """
    rng, rows = np.random.default_rng(plan.seed), plan.rows
    functions = functions_of(model)
    tick = float(_single(np.array(1.0 / plan.rate_hz))) if plan.counts is None else 1.0 / plan.rate_hz
    dt = np.full(rows, tick)
    if plan.counts is None:
        dt[0] = 0.0
    u = plan.rounded(_inputs(model, np.cumsum(dt), rng), 0)
    full = (1 << len(model.sensors)) - 1
    present = np.where(np.arange(rows) < _WHOLE * rows, full, rng.integers(0, full + 1, rows))
    start = _single(setup.x)
    running = running_filter(model, replace(setup, x=start))
    x_true, x = start, []
    z: list[list[Array]] = [[] for _ in model.sensors]
    for k in range(rows):
        if dt[k] > 0:
            x_true = functions.propagate(x_true, u[k], float(dt[k]))
        for j, sensor in enumerate(model.sensors):
            reading = np.zeros(sensor.width)
            reading[sensor.size :] = rng.uniform(-10.0, 10.0, sensor.width - sensor.size)
            ideal = functions.measure(j, x_true, reading[sensor.size :])
            reading[: sensor.size] = ideal + sensor.sd * rng.normal(size=sensor.size)
            z[j].append(plan.rounded(reading, j + 1))
        fused = [z[j][k] if present[k] >> j & 1 else None for j in range(len(model.sensors))]
        running.update(u[k], *fused, float(dt[k]))
        x.append(running.state)
    return Vectors(start, dt, u, tuple(np.array(part) for part in z), present, np.array(x))


def down_of(x: Array) -> Array:
    """Return states (n, 6) of down direction and bias from states (n, 7) of quaternion and bias."""
    down = matrix_from_quat(x[..., :4])[..., 2, :]
    return np.concatenate([down, x[..., 4:]], axis=-1)


def _single(values: Array) -> Array:
    out: Array = np.asarray(values, np.float32).astype(float)
    return out


def _inputs(model: Model, t: Array, rng: np.random.Generator) -> Array:
    """Return inputs (n, nu): swings of a second or so about the nominal input."""
    frequency = rng.uniform(0.3, 1.5, model.input_size)
    phase = rng.uniform(0.0, 2 * np.pi, model.input_size)
    return model.nominal_input() + 0.8 * np.sin(2 * np.pi * frequency * t[:, None] + phase)
