"""Lines in a window of the record: the set of frequencies with the most evidence, found one line at a time.

What remains of the reference velocity is a slow drift (tilt, biases: Legendre polynomials), lines of Gaussian
amplitude, and Markov plus white noise, which whitening takes out of data and columns alike.  The evidence is exact
for given frequencies; each frequency costs LINE_COST for having been chosen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.polynomial import legendre

from robustnav.alignment.setting import MOST_LINES
from robustnav.frames import Array

POLY = 5
LOWEST, HIGHEST = 0.2, 4.0  # rad/s searched
LINE_SD = 0.3  # m/s, amplitude
LINE_COST = 4.0  # what one more frequency must gain, nats
MOST_SAMPLES = 100


@dataclass(frozen=True)
class Window:
    """Averaged rows of the reference velocity less free motion.

    ``r`` (n, 2) m/s; ``weight`` (n,) share of each row that was there, 0 for none; ``period`` of a row [s];
    ``noise_sd`` of a full row [m/s]; ``poly_sd`` (5,) of the drift's Legendre coefficients [m/s].
    """

    r: Array
    weight: Array
    period: float
    noise_sd: float
    poly_sd: Array

    @property
    def span(self) -> float:
        """Length [s]."""
        return len(self.r) * self.period


@dataclass(frozen=True)
class Spectrum:
    """Lines found: ``omega`` and ``omega_sd`` (k,) [rad/s], and the log evidence of the window with them."""

    omega: Array
    omega_sd: Array
    evidence: float


NO_LINES = Spectrum(np.zeros(0), np.zeros(0), -np.inf)


class Whitened:
    """A window seen through the filter that makes its Markov and white noise white.

    ``base`` is the log density of the data with neither drift nor lines, up to a constant; ``evidence`` adds columns.
    """

    def __init__(self, window: Window, markov_sd: float, markov_time: float) -> None:
        n = len(window.r)
        decay = exp(-window.period / markov_time)
        gain, scale, log_det, P = np.zeros(n), np.zeros(n), 0.0, markov_sd**2
        for k, weight in enumerate(window.weight):
            if weight > 0:
                S = P + window.noise_sd**2 / weight
                gain[k], scale[k] = P / S, 1 / np.sqrt(S)
                log_det += float(np.log(S))
            P = decay**2 * (1 - gain[k]) * P + markov_sd**2 * (1 - decay**2)
        self.window = window
        self._whiten = _innovations(decay, gain, scale)
        self._data = self._whiten @ window.r
        x = (2 * np.arange(n) + 1) / n - 1
        self._drift = self._whiten @ legendre.legvander(x, POLY - 1)
        self.base = -0.5 * float(np.sum(self._data**2)) - log_det
        self._times = window.period * np.arange(n)

    def evidence(self, omega: Array) -> float:
        """Return the log evidence that drift and lines ``omega`` (k,) [rad/s] add to ``base``."""
        phase = np.outer(self._times, omega)
        waves = self._whiten @ np.stack([np.cos(phase), np.sin(phase)], axis=-1).reshape(len(phase), -1)
        A = np.hstack([self._drift, waves])
        sd = np.concatenate([self.window.poly_sd, np.full(2 * len(omega), LINE_SD)])
        L = np.linalg.cholesky(A.T @ A + np.diag(sd**-2.0))
        y = np.linalg.solve(L, A.T @ self._data)
        return 0.5 * float(np.sum(y**2)) - float(np.sum(np.log((np.diag(L) * sd) ** 2)))


def alone(window: Window, markov_sd: float, markov_time: float) -> float:
    """Return the log density of a window without lines."""
    seen = Whitened(window, markov_sd, markov_time)
    return seen.base + seen.evidence(np.zeros(0))


def given(window: Window, markov_sd: float, markov_time: float, lines: Spectrum) -> float:
    """Return the log evidence of given lines in another noise."""
    seen = Whitened(window, markov_sd, markov_time)
    return seen.base + seen.evidence(lines.omega) - LINE_COST * len(lines.omega)


def search(window: Window, markov_sd: float, markov_time: float, goal: float, known: Spectrum = NO_LINES) -> Spectrum:
    """Return the lines with the most evidence, starting from those known.

    Gives up when ``goal``, the evidence to beat, is out of reach, each line gaining less than the one before.
    """
    seen = Whitened(window, markov_sd, markov_time)
    omega = _settle(seen, known.omega)
    best = seen.evidence(omega)
    while len(omega) < MOST_LINES:
        more = _settle(seen, np.append(omega, _scan(seen, omega)))
        value = seen.evidence(more)
        gain = value - best - LINE_COST
        if gain < 0:
            break
        omega, best = more, value
        if seen.base + best - LINE_COST * len(omega) + (MOST_LINES - len(omega)) * gain < goal:
            break
    return Spectrum(omega, _widths(seen, omega), seen.base + best - LINE_COST * len(omega))


def _innovations(decay: float, gain: Array, scale: Array) -> Array:
    """Return the matrix that takes a column to its scaled innovations: v = x - decay m, m = decay m + gain v."""
    n = len(gain)
    out, mean = np.zeros((n, n)), np.zeros(n)
    for k in range(n):
        innovation = -decay * mean
        innovation[k] += 1.0
        mean = decay * mean + gain[k] * innovation
        out[k] = scale[k] * innovation
    return out


def _climb(value: Callable[[float], float], there: float, step: float) -> float:
    """Climb by parabolas through three points, ever closer."""
    for _ in range(3):
        here, below, above = value(there), value(there - step), value(there + step)
        bend = 2 * here - below - above
        uphill = step if above > below else -step
        move = 0.5 * step * (above - below) / bend if bend > 0 else uphill
        if abs(move) > step:
            move = uphill
        if LOWEST < there + move < HIGHEST:
            there += move
        step *= 0.4
    return there


def _moved(seen: Whitened, omega: Array, line: int) -> Callable[[float], float]:
    def value(there: float) -> float:
        trial = omega.copy()
        trial[line] = there
        return seen.evidence(trial)

    return value


def _scan(seen: Whitened, omega: Array) -> float:
    """Return the best place for one more line, on a grid finer than the window resolves, refined."""
    step = 1.5 / seen.window.span
    value = _moved(seen, np.append(omega, 0.0), len(omega))
    grid, there = [], LOWEST
    while there < HIGHEST:
        grid.append(there)
        there += step
    best = grid[int(np.argmax([value(one) for one in grid]))]
    return _climb(value, best, 0.6 * step)


def _settle(seen: Whitened, omega: Array) -> Array:
    """Refine all lines in turn until nothing is gained."""
    omega = omega.copy()
    if not omega.size:
        return omega
    after = seen.evidence(omega)
    for _ in range(5):
        before = after
        for line in range(len(omega)):
            omega[line] = _climb(_moved(seen, omega, line), float(omega[line]), 0.5 / seen.window.span)
        after = seen.evidence(omega)
        if after - before < 0.3:
            break
    return omega


def _widths(seen: Whitened, omega: Array) -> Array:
    """Return how well each frequency is known [rad/s], from the bend of the evidence."""
    h = 0.2 / seen.window.span
    best = seen.evidence(omega)
    out = np.zeros(len(omega))
    for line, there in enumerate(omega):
        value = _moved(seen, omega, line)
        bend = (2 * best - value(there - h) - value(there + h)) / h**2
        out[line] = 1 / np.sqrt(max(bend, 0.04 / h**2))
    return out
