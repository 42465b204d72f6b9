"""The estimator, as it is meant: a bank of winds without lines, one filter with the lines found so far, and the record
to find them in.  ``robustnav.alignment.align`` runs the same in C.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp

import numpy as np

from robustnav.alignment.compass import fair_fields, take_bearing
from robustnav.alignment.filter import Belief, Core, anchor, core_transition, graft, predict, start, update
from robustnav.alignment.heading import Answer, answer, mix
from robustnav.alignment.level import first_velocity, level_attitude, missing, odd_limit, oddness
from robustnav.alignment.lines import MOST_SAMPLES, Spectrum, Window, alone, search
from robustnav.alignment.readings import FIELD, VELOCITY
from robustnav.alignment.setting import BANK, LEVELS, RARER, AlignSetup, Wind
from robustnav.frames import Array

LEVEL_TIME = 2.0  # s before the filters start
FIRST_TIME = 12.0  # s of record needed to tell a slow wind from a tilt
EARLY_TIME = 60.0  # s: until then the window is the whole record
SHORT_WINDOW = 20.0  # s
SNAPSHOT_TIME = 10.0  # s
MEMORY = 60.0  # s, forgetting of likelihood
BROAD_SD = 0.5  # m/s: winds below it have no say before FIRST_TIME
REFIT_UNTIL = 40.0  # s: until then new lines always replace the old
COARSE = 1e-3  # rad/s: gyro biases beyond it are taken off the record as soon as they are known
RECENTRE_TIMES = (5.0, 12.0, 30.0)  # s
ANCHOR_TIME, ANCHOR_EVERY = 45.0, 15.0  # s
HEALTHY = 2.6  # smoothed misfit, 2 expected
NEGLIGIBLE = 20.0  # nats below the best


class Aligner:
    """An alignment in progress; ``step`` takes one reading (30,), ``read`` answers."""

    def __init__(self, setup: AlignSetup) -> None:
        self.setup = setup
        self._keep = exp(-setup.period / MEMORY)
        self._rows: list[Array] = []
        self._beliefs: list[Belief] = []
        self._scores: list[float] = []
        self._line_history: dict[int, float] = {}
        self._fit = 2.0
        self._snapshots: dict[int, tuple[Core, Array, float]] = {}
        self._next = self._steps(FIRST_TIME)
        self._q0, self._v0 = np.zeros(4), np.zeros(2)
        self._gyro_bias: Array | None = None

    def _steps(self, seconds: float) -> int:
        return int(seconds / self.setup.period + 0.5)

    def step(self, reading: Array) -> None:
        """Take the next reading (30,), reference velocity and magnetic field NaN where missing."""
        self._rows.append(np.array(reading, float))
        count = len(self._rows)
        if count <= self._steps(LEVEL_TIME):
            if count == self._steps(LEVEL_TIME):
                self._restart(list(BANK))
            return
        there = not missing(reading[VELOCITY])
        for i, belief in enumerate(self._beliefs):
            moved = predict(belief, self.setup, reading)
            if there:
                moved = update(moved, self.setup, reading[VELOCITY])
                self._scores[i] = self._keep * self._scores[i] + moved.log_likelihood
            self._beliefs[i] = take_bearing(moved, self.setup, reading[FIELD])
        if self._has_lines and there:
            self._line_history[count - 1] = self._beliefs[-1].log_likelihood
            self._fit += self.setup.period / 5.0 * (self._beliefs[-1].misfit - self._fit)
        if count % self._steps(SNAPSHOT_TIME) == 0:
            best = int(np.argmax(self._merits))
            belief = self._beliefs[best]
            belief = belief if belief.off is None else anchor(belief)
            common = belief.core.size
            self._snapshots[count] = (belief.core, belief.P[:common, :common], self._scores[best])
        self._recentre()
        if count >= self._next:
            self._check()

    def read(self) -> Answer | None:
        """Return the answer now; None in the first two seconds."""
        if not self._beliefs:
            return None
        merits = self._merits
        if len(self._rows) < self._steps(FIRST_TIME):
            merits = np.where([wind.markov_sd < BROAD_SD for wind in BANK], -np.inf, merits[: len(BANK)])
        kept = np.flatnonzero(merits >= merits.max() - NEGLIGIBLE)
        weights = np.exp(merits[kept] - merits.max())
        return mix([answer(self._beliefs[i], self.setup) for i in kept], weights / weights.sum())

    @property
    def _has_lines(self) -> bool:
        return len(self._beliefs) > len(BANK)

    @property
    def _merits(self) -> Array:
        """Log weight of each filter."""
        out: Array = np.array(self._scores) - np.append(RARER, 0.0)[: len(self._scores)]
        return out

    def _restart(self, winds: list[Wind]) -> None:
        """Level, and run a filter with each wind over the whole record."""
        rows = np.array(self._rows[: self._steps(LEVEL_TIME)])
        first = self._gyro_bias is None
        self._q0 = level_attitude(rows, self._gyro_bias)
        self._v0 = first_velocity(rows[:, VELOCITY])
        for k in np.flatnonzero(~fair_fields(rows, self.setup, self._q0)) if first else ():
            self._rows[k][FIELD] = np.nan
        self._beliefs, self._scores = [], []
        for wind in winds:
            belief, score, _ = self._replay(self._started(wind), 0, 0.0)
            self._beliefs.append(belief)
            self._scores.append(score - 3.0 * len(wind.omega))

    def _started(self, wind: Wind) -> Belief:
        """Return a belief at the start; after a recentring linear about the start."""
        belief = start(self.setup, wind, self._q0, self._v0, self._gyro_bias)
        return belief if self._gyro_bias is None else anchor(belief)

    def _recentre(self) -> None:
        """With coarse gyros start over, few times, linear about the gyro bias found; later anchor now and again.

        While a large gyro bias is learned, attitude and its turns move with every reading, and what moves seems to tell
        tilt from the bias of the accelerometer.
        """
        if not self.setup.gyro_bias_sd > COARSE:
            return
        count = len(self._rows)
        if count in [self._steps(time) for time in RECENTRE_TIMES]:
            said = self.read()
            self._gyro_bias = None if said is None else said.gyro_bias
            self._restart([belief.wind for belief in self._beliefs])
        if count >= self._steps(ANCHOR_TIME) and (count - self._steps(ANCHOR_TIME)) % self._steps(ANCHOR_EVERY) == 0:
            self._beliefs = [anchor(belief) for belief in self._beliefs]

    def _replay(self, belief: Belief, first: int, score: float) -> tuple[Belief, float, float]:
        """Run a fresh belief from row ``first`` to now; return it, its score and its plain log likelihood.

        In its first two seconds gusts are left out; later it judges them itself.
        """
        rows, careful, total = np.array(self._rows[first:]), self._steps(LEVEL_TIME), 0.0
        odd = oddness(rows[:careful, VELOCITY])
        use = np.concatenate([odd <= odd_limit(odd, self.setup.reference_sd), ~missing(rows[careful:, VELOCITY])])
        for row, used in zip(rows, use, strict=True):
            belief = predict(belief, self.setup, row)
            if used:
                belief = update(belief, self.setup, row[VELOCITY])
                score = self._keep * score + belief.log_likelihood
                total += belief.log_likelihood
            belief = take_bearing(belief, self.setup, row[FIELD])
        return belief, score, total

    def _check(self) -> None:
        count = len(self._rows)
        time = count * self.setup.period
        if time < EARLY_TIME + 0.05:
            self._propose(0)
        elif not (self._beliefs[-1].lines and int(np.argmax(self._merits)) == len(BANK) and self._fit < HEALTHY):
            self._propose(count - self._steps(EARLY_TIME))
            self._propose(count - self._steps(SHORT_WINDOW))
        wait = 1.0 if time < 19.9 else 5.0 if time < 29.9 else 10.0
        self._next = count + self._steps(wait)

    def _propose(self, first: int) -> None:
        """Look for lines from row ``first`` to now and let a filter with them compete.

        Where lines held until then, also one without: it starts from what they taught, as no filter of the bank does.
        """
        fresh = self._started(Wind(0.0, 1.0)).core
        core, P, score = self._snapshots.get(first, (fresh, np.zeros((0, 0)), 0.0))
        wind = identify(self._window(core, first))
        if not wind.omega and (first == 0 or not self._has_lines):
            return
        if first == 0:
            belief = self._started(wind)
        else:
            belief = graft(core, P, wind)
            belief = belief if self._gyro_bias is None else anchor(belief)
        belief, score, total = self._replay(belief, first, score)
        now = len(self._rows)
        past = sum(self._line_history.get(k, 0.0) for k in range(first, now))
        early = now * self.setup.period < REFIT_UNTIL + 0.5 * self.setup.period
        lines = len(wind.omega)
        if self._has_lines and not early and total < past + 5.0 + 3.0 * lines:
            return
        self._beliefs[len(BANK) :], self._scores[len(BANK) :] = [belief], [score - 3.0 * lines]
        self._fit = 2.0
        self._line_history.update(dict.fromkeys(range(first, now), total / (now - first)))

    def _window(self, core: Core, first: int) -> Window:
        """Average what the reference velocity says beyond free motion from ``core``."""
        rows = np.array(self._rows[first:])
        group = -(-len(rows) // MOST_SAMPLES)
        n = len(rows) // group
        odd = oddness(rows[:, VELOCITY])
        use = odd <= odd_limit(odd, self.setup.reference_sd)
        free = replace(core, x=np.concatenate([np.zeros(2), core.x[2:]]))
        r = np.zeros((len(rows), 2))
        for k, row in enumerate(rows):
            free, _ = core_transition(free, self.setup, row)
            r[k] = row[VELOCITY] - free.velocity if use[k] else 0.0
        count = use[-n * group :].reshape(n, group).sum(axis=1)
        mean = r[-n * group :].reshape(n, group, 2).sum(axis=1) / np.maximum(count, 1)[:, None]
        period = self.setup.period * group
        noise_sd = self.setup.reference_sd / np.sqrt(group)
        return Window(mean, count / group, period, noise_sd, _drift_sd(self.setup, n * period))


def _drift_sd(setup: AlignSetup, span: float) -> Array:
    """Return the size of each Legendre coefficient (5,) [m/s] over ``span`` [s].

    Start and tilt are free; then gyro bias and Earth rate bend, then the walk of the bias.
    """
    bend = setup.gravity * np.hypot(setup.gyro_bias_sd, 6e-5) * span**2 / 12
    walk = setup.gravity * setup.gyro_bias_walk * span**2.5 / 45
    return np.array([3.0, 3.0, bend + 1e-4, walk + 1e-4, 0.5 * walk + 1e-4])


def identify(window: Window) -> Wind:
    """Return the wind with the most evidence: the likeliest without lines, then less Markov noise and more lines."""
    values = [alone(window, wind.markov_sd, wind.markov_time) for wind in BANK]
    level, best = 0, values[0]
    for i, value in enumerate(values):
        if value > best:
            best, level = value, i if i < LEVELS else level
    kept = search(window, BANK[level].markov_sd, BANK[level].markov_time, best)
    for i in range(level - 1, -1, -1):
        found = search(window, BANK[i].markov_sd, BANK[i].markov_time, kept.evidence, kept)
        if not found.evidence > kept.evidence:
            break
        kept, level = found, i
    return _as_wind(kept, BANK[level], window.span)


def _as_wind(found: Spectrum, around: Wind, span: float) -> Wind:
    omega_sd = np.minimum(3.0 * found.omega_sd, 0.4 * found.omega)
    if around.markov_sd == 0:
        # A line not yet told from its neighbour leaves a remainder that shrinks as the window grows.
        around = Wind(0.05 * min(FIRST_TIME / span, 1.0) ** 3, 2.0)
    return replace(around, omega=tuple(found.omega.tolist()), omega_sd=tuple(omega_sd.tolist()))
