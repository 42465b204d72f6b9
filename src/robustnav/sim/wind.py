"""Wind at a mooring: mean, lines (sines), a Gauss-Markov process and gusts, in parts that follow one another."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Line:
    """``amplitude_n sin(frequency t + phase)`` [m/s], frequency [rad/s]."""

    frequency: float
    amplitude_n: Vector
    phase: float = 0.0


@dataclass(frozen=True)
class Markov:
    """A first-order Gauss-Markov process: standard deviation by axis of n [m/s], correlation time [s]."""

    sd_n: Vector
    time: float


@dataclass(frozen=True)
class Gusts:
    """Impulses: at each reading, with ``probability``, a normal draw of ``sd_n`` by axis of n [m/s]."""

    sd_n: Vector
    probability: float


@dataclass(frozen=True)
class WindPart:
    """A wind from ``start`` [s] until the next part's.

    ``mean_n`` [m/s]; ``random_phases``: those of the lines are drawn, one a line.
    """

    start: float
    mean_n: Vector
    lines: tuple[Line, ...] = ()
    random_phases: bool = False
    markov: Markov | None = None
    gusts: Gusts | None = None


def wind(parts: tuple[WindPart, ...], t: Array, rng: np.random.Generator) -> Array:
    """Return the wind (n, 3) [m/s] in north-east-down at even times ``t`` (n,) [s].

    Raises
    ------
    InputError : the parts do not begin at zero and follow one another, or a time or probability makes no sense.
    """
    starts = [part.start for part in parts]
    if not starts or starts[0] != 0 or sorted(set(starts)) != starts:
        raise InputError("wind", got=f"parts that start at {starts} s", expected="the first at 0 s, then increasing")
    out = np.empty((len(t), 3))
    for part in parts:
        own = _part(part, t, rng)  # drawn over all times, so that a change moves no draw of the part before it
        out[t >= part.start] = own[t >= part.start]
    return out


def gauss_markov(normal: Array, decay: float) -> Array:
    """Return a stationary process (n, ...) of unit variance from independent normal numbers of the same shape.

    ``x[k] = decay x[k-1] + sqrt(1 - decay^2) normal[k]``, ``x[0] = normal[0]``, in log2(n) passes over the array.
    """
    x: Array = np.sqrt(1 - decay**2) * normal
    x[0] = normal[0]
    shift = 1
    while shift < len(x):
        x[shift:] += decay**shift * x[:-shift].copy()
        shift *= 2
    return x


def _part(part: WindPart, t: Array, rng: np.random.Generator) -> Array:
    out = np.tile(np.asarray(part.mean_n, float), (len(t), 1))
    for line in part.lines:
        phase = rng.uniform(0, 2 * pi) if part.random_phases else line.phase
        out += np.outer(np.sin(line.frequency * t + phase), line.amplitude_n)
    if part.markov is not None:
        if not part.markov.time > 0:
            raise InputError("wind, Gauss-Markov", got=f"time {part.markov.time} s", expected="a positive time")
        decay = exp(-float(t[1] - t[0]) / part.markov.time) if len(t) > 1 else 0.0
        out += gauss_markov(rng.standard_normal((len(t), 3)), decay) * part.markov.sd_n
    if part.gusts is not None:
        if not 0 <= part.gusts.probability <= 1:
            raise InputError("wind, gusts", got=f"probability {part.gusts.probability}", expected="0 to 1")
        struck = rng.uniform(size=len(t)) < part.gusts.probability
        out += struck[:, None] * rng.standard_normal((len(t), 3)) * part.gusts.sd_n
    return out
