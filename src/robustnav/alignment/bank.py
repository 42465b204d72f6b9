"""The estimator, as it is meant: a bank of winds without lines, filters with the lines found so far, and the record to
find them in.  ``robustnav.alignment.align`` runs the same in C.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp

import numpy as np

from robustnav.alignment.compass import fair_fields, take_bearing
from robustnav.alignment.filter import Belief, Core, anchor, core_transition, graft, predict, start, update
from robustnav.alignment.heading import Answer, answer, mix
from robustnav.alignment.identify import identify
from robustnav.alignment.level import first_velocity, level_attitude, missing, odd_limit, oddness
from robustnav.alignment.lines import MOST_SAMPLES, Window
from robustnav.alignment.readings import FIELD, VELOCITY
from robustnav.alignment.setting import BANK, LINED, NEXT, AlignSetup, Wind
from robustnav.frames import Array

# Places of filters: the bank, those with lines, those for what may come next.
FIRST_LINED, FIRST_NEXT = len(BANK), len(BANK) + LINED
LEVEL_TIME = 2.0  # s before the filters start
FIRST_TIME = 12.0  # s of record needed to tell a slow wind from a tilt
EARLY_TIME = 60.0  # s: until then the window is the whole record
SHORT_WINDOW = 20.0  # s
SNAPSHOT_TIME, PREPARE_TIME = 10.0, 20.0  # s
MEMORY = 150.0  # s, forgetting of likelihood
BROAD_SD = 0.5  # m/s: winds below it have no say before FIRST_TIME
REFIT_UNTIL = 40.0  # s: until then new lines always replace the old
COARSE = 1e-3  # rad/s: gyro biases beyond it are taken off the record as soon as they are known
COARSE_BOTH = 1e-6  # rad/s: or beyond this times the accelerometer's biases over gravity
RECENTRE_TIMES = (5.0, 12.0, 30.0)  # s
HEALTHY = 2.6  # smoothed misfit, 2 expected
NEGLIGIBLE = 20.0  # nats below the best
LINE_PRIOR = 3.0  # nats, of a line whose frequency was found in what is judged
CHANGE_COST = 8.0  # nats: at ten readings a second a wind changes about once in five minutes
CHANGE_FROM = 40.0  # s
FASTER = 4.0  # times: below that the bank has what comes next


@dataclass
class Running:
    """A filter that runs: what it believes, its log likelihood with forgetting, and its smoothed misfit."""

    belief: Belief
    score: float
    fit: float = 2.0


class Aligner:
    """An alignment in progress; ``step`` takes one reading (30,), ``read`` answers."""

    def __init__(self, setup: AlignSetup) -> None:
        self.setup = setup
        self._keep = exp(-setup.period / MEMORY)
        self._rows: list[Array] = []
        self._filters: dict[int, Running] = {}
        self._best: list[float] = []  # score of the filter that led, and its log likelihood
        self._history: list[float] = []
        self._snapshots: dict[int, Belief] = {}
        self._next = self._steps(FIRST_TIME)
        self._changed = self._lines_from = self._next_from = 0
        self._q0, self._v0 = np.zeros(4), np.zeros(2)
        self._gyro_bias: Array | None = None

    def _steps(self, seconds: float) -> int:
        return int(seconds / self.setup.period + 0.5)

    def step(self, reading: Array) -> None:
        """Take the next reading (30,), reference velocity and magnetic field NaN where missing."""
        self._rows.append(np.array(reading, float))
        self._best.append(0.0)
        self._history.append(0.0)
        count = len(self._rows)
        if count <= self._steps(LEVEL_TIME):
            if count == self._steps(LEVEL_TIME):
                self._restart(dict(enumerate(BANK)))
            return
        self._run(reading)
        if self._leading() >= FIRST_NEXT:
            self._follow()
        if count % self._steps(SNAPSHOT_TIME) == 0:
            if count % self._steps(PREPARE_TIME) == 0:
                self._prepare()
            self._snapshots[count] = self._filters[self._leading()].belief
        self._recentre()
        if count >= self._next:
            self._check()

    def read(self) -> Answer | None:
        """Return the answer now; None in the first two seconds."""
        if not self._filters:
            return None
        top = self._filters[self._leading()].score
        kept = [one for i, one in self._filters.items() if self._says(i) and one.score > top - CHANGE_COST]
        weights = np.exp([one.score - top for one in kept])
        return mix([answer(one.belief, self.setup) for one in kept], weights / weights.sum())

    def _says(self, place: int) -> bool:
        """Whether a filter has a say: in the first seconds, and after a change, smooth winds pass for tilts."""
        early = len(self._rows) - self._changed < self._steps(FIRST_TIME)
        return not (early and place < FIRST_LINED and self._filters[place].belief.wind.markov_sd < BROAD_SD)

    def _leading(self, end: int = FIRST_NEXT + len(NEXT)) -> int:
        """Return the place of the filter with the highest score before ``end`` that has a say."""
        return max((i for i in self._filters if i < end and self._says(i)), key=lambda i: self._filters[i].score)

    @property
    def _healthy(self) -> bool:
        return self._filters[self._leading()].fit < HEALTHY

    def _run(self, reading: Array) -> None:
        """Take the newest reading with all filters."""
        there = not missing(reading[VELOCITY])
        for one in self._filters.values():
            moved = predict(one.belief, self.setup, reading)
            if there:
                moved = update(moved, self.setup, reading[VELOCITY])
                one.score = self._keep * one.score + moved.log_likelihood
                one.fit += self.setup.period / 5.0 * (moved.misfit - one.fit)
            one.belief = take_bearing(moved, self.setup, reading[FIELD])
        best = self._filters[self._leading()]
        self._history[-1] = best.belief.log_likelihood if there else 0.0
        self._best[-1] = best.score
        for i, one in self._filters.items():
            if i >= FIRST_NEXT:
                one.score = max(one.score, best.score - CHANGE_COST)

    def _restart(self, winds: dict[int, Wind]) -> None:
        """Level, and run a filter with each wind, by place, over the whole record."""
        rows = np.array(self._rows[: self._steps(LEVEL_TIME)])
        first = self._gyro_bias is None
        self._q0 = level_attitude(rows, self._gyro_bias)
        self._v0 = first_velocity(rows[:, VELOCITY])
        for k in np.flatnonzero(~fair_fields(rows, self.setup, self._q0)) if first else ():
            self._rows[k][FIELD] = np.nan
        self._filters = {i: self._run_from(wind, 0)[0] for i, wind in winds.items()}

    def _started(self, wind: Wind) -> Belief:
        """Return a belief at the start; after a recentring linear about the start."""
        belief = start(self.setup, wind, self._q0, self._v0, self._gyro_bias)
        return belief if self._gyro_bias is None else anchor(belief)

    def _run_from(self, wind: Wind, first: int) -> tuple[Running, float]:
        """Return a filter that has run from row ``first`` to now, and its plain log likelihood.

        It begins at the start, or with what was known at a snapshot, past which the wind may have changed at any time.
        In its first two seconds gusts are left out; later it judges them itself.
        """
        if first == 0:
            belief, score = self._started(wind), 0.0
        else:
            belief, score = graft(self._snapshots[first], wind), self._best[first - 1] - CHANGE_COST
        rows, careful, total = np.array(self._rows[first:]), self._steps(LEVEL_TIME), 0.0
        odd = oddness(rows[:careful, VELOCITY])
        use = np.concatenate([odd <= odd_limit(odd, self.setup.reference_sd), ~missing(rows[careful:, VELOCITY])])
        for k, (row, used) in enumerate(zip(rows, use, strict=True), first):
            belief = predict(belief, self.setup, row)
            if used:
                belief = update(belief, self.setup, row[VELOCITY])
                score = self._keep * score + belief.log_likelihood
                total += belief.log_likelihood
            if first > 0:
                score = max(score, self._best[k] - CHANGE_COST)
            belief = take_bearing(belief, self.setup, row[FIELD])
        return Running(belief, score - LINE_PRIOR * len(wind.omega)), total

    def _recentre(self) -> None:
        """With large biases start over, few times, linear about the gyro bias found.

        While a large gyro bias is learned, attitude and its turns move with every reading, and what moves seems to tell
        tilt from the bias of the accelerometer.
        """
        setup = self.setup
        both = setup.gyro_bias_sd * setup.accel_bias_sd
        if not (setup.gyro_bias_sd > COARSE or both > COARSE_BOTH * setup.gravity):
            return
        if len(self._rows) in [self._steps(time) for time in RECENTRE_TIMES]:
            said = self.read()
            self._gyro_bias = None if said is None else said.gyro_bias
            self._restart({i: one.belief.wind for i, one in self._filters.items()})

    def _check(self) -> None:
        count = len(self._rows)
        time = count * self.setup.period
        if time < EARLY_TIME + 0.05:
            self._propose(0)
        else:
            held = self._leading() >= FIRST_LINED and self._healthy
            young = (count - self._lines_from) * self.setup.period < EARLY_TIME + 0.05
            if held and young:
                self._propose(self._lines_from)  # its window still grows
            if not held or young:
                self._propose(count - self._steps(SHORT_WINDOW))
            if not held:
                self._propose(count - self._steps(EARLY_TIME))
        self._prune()
        wait = 1.0 if time < 19.9 else 5.0 if time < 29.9 else 10.0
        self._next = count + self._steps(wait)

    def _propose(self, first: int) -> None:
        """Look for lines from row ``first`` to now and let filters with them compete."""
        core = self._started(Wind(0.0, 1.0)).core if first == 0 else self._snapshots[first].estimate
        winds = identify(self._window(core, first))
        if not winds:
            return
        likeliest, total = self._run_from(winds[0], first)
        now, past = len(self._rows), sum(self._history[first:])
        early = first == self._lines_from and (now - first) * self.setup.period < REFIT_UNTIL + 0.5 * self.setup.period
        if not early and total < past + 5.0 + LINE_PRIOR * len(winds[0].omega):
            return
        others = [self._run_from(wind, first)[0] for wind in winds[1:]]
        self._filters = {i: one for i, one in self._filters.items() if not FIRST_LINED <= i < FIRST_NEXT}
        self._filters.update(enumerate([likeliest, *others], FIRST_LINED))
        self._lines_from = first
        if total > past:
            self._history[first:] = [total / (now - first)] * (now - first)

    def _prepare(self) -> None:
        """Have filters ready for winds that may come next.

        They start from what the best knew ten seconds ago, before any change that does not show yet.
        """
        count, best = len(self._rows), self._filters[self._leading()]
        old = count - self._next_from >= self._steps(CHANGE_FROM)
        if count < self._steps(CHANGE_FROM) or not (self._healthy or old):
            return
        first = count - self._steps(SNAPSHOT_TIME)
        for i, wind in enumerate(NEXT, FIRST_NEXT):
            self._filters.pop(i, None)
            if _speed(wind) > FASTER * _speed(best.belief.wind):
                self._filters[i] = self._run_from(wind, first)[0]
        self._next_from = first

    def _follow(self) -> None:
        """The wind has changed: the bank starts anew from what was known before."""
        lined = {i: one for i, one in self._filters.items() if FIRST_LINED <= i < FIRST_NEXT}
        bank = {i: self._run_from(wind, self._next_from)[0] for i, wind in enumerate(BANK)}
        self._filters = {**bank, **lined}
        self._changed = len(self._rows)

    def _prune(self) -> None:
        """Stop filters far worse than the best; those of the bank than the best of the bank, in case lines deceive."""
        best = self._filters[self._leading()].score
        of_bank = self._filters[self._leading(FIRST_LINED)].score
        for i, one in list(self._filters.items()):
            if i < FIRST_NEXT and one.score < (of_bank if i < FIRST_LINED else best) - NEGLIGIBLE:
                del self._filters[i]

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


def _speed(wind: Wind) -> float:
    """Return how fast a wind changes besides its lines [m^2/s^3]."""
    return 2.0 * wind.markov_sd**2 / wind.markov_time


def _drift_sd(setup: AlignSetup, span: float) -> Array:
    """Return the size of each Legendre coefficient (5,) [m/s] over ``span`` [s].

    Start and tilt are free; then gyro bias and Earth rate bend, then the walk of the bias.
    """
    bend = setup.gravity * np.hypot(setup.gyro_bias_sd, 6e-5) * span**2 / 12
    walk = setup.gravity * setup.gyro_bias_walk * span**2.5 / 45
    return np.array([3.0, 3.0, bend + 1e-4, walk + 1e-4, 0.5 * walk + 1e-4])
