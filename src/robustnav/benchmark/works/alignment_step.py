"""The alignment of the published study: a step of each unscented filter on thirteen states, and whole alignments."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from robustnav.alignment import Alignment, align
from robustnav.alignment.heading_bank import BankRun, HeadingBank, bank_estimator, heading_bank
from robustnav.benchmark.callbacks import few
from robustnav.benchmark.peer import require
from robustnav.benchmark.timing import Contender, Entry, Work
from robustnav.benchmark.works.alignment_peer import AlignmentEquations, AlignmentUkf
from robustnav.engine.filters import Output, SensorData
from robustnav.engine.strapdown import preintegrate
from robustnav.frames import Array, quat_normalize
from robustnav.run import EKF, UKF, HInfinity, Start, stream
from robustnav.sim.alignment import AlignmentData, simulate_alignment
from robustnav.studies.alignment_errors import tilt_error
from robustnav.studies.alignment_setting import PUBLISHED, SPREAD, Case, bank_of, estimators, setup_of, start_of
from robustnav.units import DEG

SEED, PERIOD = 1, 0.1  # s
CASE = Case("s-10-10-60", PUBLISHED)
LEAST_FOR_BANK = 200  # steps: it chooses after 15 s
RIGHT, RIGHT_SOON, SOON = 1.0 * DEG, 15.0 * DEG, 500  # of tilt, also in fewer steps than SOON: it starts at 14 deg
AGREE = 1e-9  # numbers of the state by filterpy's filter and by ours, over the steps that are timed


@dataclass(frozen=True)
class Aligned:
    """A simulated alignment of ``n`` steps: stamps (n,) of their ends, increments (n, 25), velocities (n, 3)."""

    data: AlignmentData
    t: Array
    u: Array
    z: Array

    def __len__(self) -> int:
        return len(self.z)

    def fault(self, q_nb: Array) -> float:
        """Return how far the tilt of an attitude (4,) at the end is from the truth, in units of what is right."""
        truth = self.data.truth.q_nb
        off = np.nan if truth is None else np.linalg.norm(tilt_error(truth[len(self)], quat_normalize(q_nb)))
        return float(off) / (RIGHT if len(self) >= SOON else RIGHT_SOON)


@lru_cache(maxsize=1)
def _simulated() -> AlignmentData:
    return simulate_alignment(CASE.load(), SEED, preintegrate)


def aligned(steps: int) -> Aligned:
    """Return the first ``steps`` steps of the published alignment, of 2000 at most."""
    data = _simulated()
    return Aligned(data, data.velocity.t[:steps], data.increments.rows[:steps], data.velocity.values[:steps])


def published(kind: str, data: AlignmentData) -> tuple[EKF | UKF | HInfinity, Start]:
    """Return a filter on the published model, weight 1 m/s, and its start; ``kind``: ``ukf``, ``hinf`` or ``ekf``."""
    ours = {"ukf": "ukf-r1", "hinf": "hinf", "ekf": "ukf-r1"}[kind]
    estimator = estimators(data.scenario)[ours]
    start = start_of(data, estimator)
    return (EKF(estimator.model) if kind == "ekf" else estimator), start


def _ours(samples: int, kind: str) -> Contender:
    one = aligned(samples)
    running = stream(*published(kind, one.data))
    x, P, _, elapsed = running.snapshot()
    begin, readings = (x, P, 0.0, elapsed), [SensorData(one.t, one.z)]  # the first increment starts at 0 s

    def work() -> Output:
        running.restore(begin)
        return running.run(one.t, one.u, readings, covariance=False, innovations=False)

    return Contender(work, len(one), lambda output: one.fault(output.x[-1, 3:7]))


def _filterpy(samples: int) -> Contender:
    one = aligned(few(samples))
    estimator, start = published("ukf", one.data)
    theirs = AlignmentUkf(require("filterpy.kalman"), AlignmentEquations(estimator.model, PERIOD), SPREAD)
    inputs = list(zip(list(one.u), list(one.z), strict=True))
    ours = stream(estimator, start)
    for increments, velocity in inputs:
        ours.update(increments, velocity, PERIOD)
    expected = ours.state

    def work() -> Array:
        theirs.restart(start.x, start.P)
        for increments, velocity in inputs:
            theirs.step(increments, velocity)
        return np.asarray(theirs.filter.x)

    return Contender(work, len(one), lambda x: float(np.abs(x - expected).max()) / AGREE)


def _so3(samples: int, lines: tuple[float, ...]) -> Contender:
    """Return the filter on SO(3) from the truth: it is timed, the bank below finds the truth."""
    one = aligned(samples)
    estimator = bank_estimator(setup_of(one.data.scenario), HeadingBank(lines))
    running = stream(estimator, Start.at(estimator.model, {"q_nb": 1 * DEG}, q_nb=one.data.q_nb[0]))
    x, P, _, elapsed = running.snapshot()
    begin, readings = (x, P, 0.0, elapsed), [SensorData(one.t, one.z)]

    def work() -> Output:
        running.restore(begin)
        return running.run(one.t, one.u, readings, covariance=False, innovations=False)

    return Contender(work, len(one), lambda output: one.fault(output.x[-1, :4]))


def _bank(samples: int) -> Contender:
    one = aligned(max(samples, LEAST_FOR_BANK))
    n, setup = len(one), setup_of(one.data.scenario)
    increments, bank = one.data.increments.between(0, n), bank_of(CASE)

    def work() -> BankRun:
        return heading_bank(increments, one.z, setup, bank)

    return Contender(work, n, lambda said: one.fault(said.q_nb[-1]))


def _align(samples: int, backend: str) -> Contender:
    one = aligned(samples)
    n, setup = len(one), setup_of(one.data.scenario)
    increments, reference = one.data.increments.between(0, n), one.z[:, :2].copy()

    def work() -> Alignment:
        return align(increments, reference, one.t, setup, backend)

    return Contender(work, n, lambda said: one.fault(said.q_nb[-1]))


WHAT = "increments of 0.1 s and a velocity in wind: the published alignment of 200 s"

STEP = Work(
    "alignment-step",
    "a predict with increments and an update with a velocity: thirteen states, 27 points; hinf bounds all of them",
    WHAT,
    {
        "ukf": Entry(lambda n: _ours(n, "ukf")),
        "hinf": Entry(lambda n: _ours(n, "hinf")),
        "ekf": Entry(lambda n: _ours(n, "ekf")),
        "ekf-so3": Entry(lambda n: _so3(n, ())),
        "ekf-so3-lines": Entry(lambda n: _so3(n, (0.5, 1.0, 2.0))),
        "filterpy-ukf": Entry(_filterpy, needs="filterpy", baseline=True),
    },
)
ALIGN = Work(
    "align",
    "a tenth of a second of a whole alignment, heading and wind found: 2000 of them are 200 s",
    WHAT,
    {
        "align": Entry(lambda n: _align(n, "compiled")),
        "align-float": Entry(lambda n: _align(n, "compiled-float")),
        "heading-bank": Entry(_bank),
    },
)
