"""Runs of the alignment study: one simulation feeds every wind, start and estimator, and is reduced to its figures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from robustnav.alignment import align
from robustnav.alignment.heading_bank import heading_bank
from robustnav.alignment.riekf import InvariantStart, invariant_ekf
from robustnav.engine.filters import Output, SensorData
from robustnav.engine.strapdown import preintegrate
from robustnav.filter.steps import unpack
from robustnav.frames import Array, quat_normalize
from robustnav.run import UKF, HInfinity, stream
from robustnav.sim.alignment import AlignmentData, in_other_wind, simulate_alignment
from robustnav.studies.alignment_bounds import LIMITS, fixed_winds
from robustnav.studies.alignment_errors import Followed, additive_covariance, aligned, judged
from robustnav.studies.alignment_figures import Reduced, joined, reduced
from robustnav.studies.alignment_setting import (
    INVARIANT,
    OURS,
    UNIT,
    Case,
    bank_of,
    estimators,
    setup_of,
    start_of,
)

Progress = Callable[[], None]
WORKERS = 2
CHUNK = 10  # seeds that one worker simulates and filters together


@dataclass(frozen=True)
class Example:
    """One run: by method what it gave, true wind (n, 3) and the one found (n, 2) [m/s]; instants ``t`` (n + 1,) [s].

    ``change`` is when the last part of the wind begins [s].
    """

    t: Array
    change: float
    followed: dict[str, Followed]
    wind_n: Array
    wind_found: Array


@dataclass(frozen=True)
class Outcome:
    """All runs of a case, reduced: by method or bound; ``fixed``: tilt after a start or change by single wind (runs,)
    [arcmin]; existence of the H-infinity filter; the first run in detail.

    ``margins`` (parts, n) are the least over some runs each, no part without that filter; ``without_filter`` (runs,) is
    the share of its steps.
    """

    t: Array
    runs: dict[str, Reduced]
    fixed: dict[str, Array]
    margins: Array
    without_filter: Array
    example: Example | None


@dataclass(frozen=True)
class Ours:
    """What ``align``, which is told of no start, gave in each run; tilt by single wind (runs,) [arcmin].

    ``wind`` is what it found in the first run (n, 2) [m/s].
    """

    followed: list[Followed]
    fixed: dict[str, Array]
    wind: Array


@dataclass(frozen=True)
class Work:
    """Cases whose inertial data are the same, and the methods to run."""

    cases: Sequence[Case]
    methods: frozenset[str]

    def methods_of(self, case: Case) -> list[str]:
        """Return the methods and bounds of a case in the order of the study."""
        return [name for name in case.methods if name in self.methods]


def run_work(work: Sequence[Work], seeds: Sequence[int], progress: Progress) -> list[list[Outcome]]:
    """Run everything, parts of seeds shared among workers; return an outcome a case of each piece of work.

    ``progress`` is called after every seed of every case, from the workers, on whose number the result does not depend.
    """
    parts = [seeds[k : k + CHUNK] for k in range(0, len(seeds), CHUNK)]
    jobs = [(one, part) for one in work for part in parts]

    def run(job: tuple[Work, Sequence[int]]) -> list[Outcome]:
        one, part = job
        return _run_part(one, part, part is parts[0], progress)

    with ThreadPoolExecutor(WORKERS) as pool:
        done = pool.map(run, jobs)
        return [_collected(len(one.cases), [next(done) for _ in parts]) for one in work]


def _collected(cases: int, parts: list[list[Outcome]]) -> list[Outcome]:
    return [_joined([part[k] for part in parts]) for k in range(cases)]


def _joined(parts: list[Outcome]) -> Outcome:
    first = parts[0]
    return Outcome(
        t=first.t,
        runs={name: joined([part.runs[name] for part in parts]) for name in first.runs},
        fixed={name: np.concatenate([part.fixed[name] for part in parts]) for name in first.fixed},
        margins=np.concatenate([part.margins for part in parts]),
        without_filter=np.concatenate([part.without_filter for part in parts]),
        example=first.example,
    )


def _run_part(work: Work, seeds: Sequence[int], detailed: bool, progress: Progress) -> list[Outcome]:
    """Simulate the inertial data of some seeds once, and run all cases on them; ``detailed``: keep an example."""
    base = [simulate_alignment(work.cases[0].load(), seed, preintegrate) for seed in seeds]
    data = [[in_other_wind(one, case.load()) for one in base] for case in work.cases]
    invariant = _invariant(work, data)
    # The wind is not in the bounds, and a start is not in what align and the bank give.
    bounds = {name: [bound(one) for one in base] for name, bound in LIMITS.items() if name in work.methods}
    ours: dict[str, Ours] = {}
    banked: dict[str, list[Followed]] = {}
    out = []
    for case, runs, done in zip(work.cases, data, invariant, strict=True):
        if OURS in work.methods and case.wind not in ours:
            ours[case.wind] = _ours(case, runs)
        if "bank" in work.methods_of(case):
            if case.wind not in banked:
                banked[case.wind] = [_banked(case, one) for one in runs]
            done["bank"] = banked[case.wind]
        outcome = _run_case(work.methods_of(case), runs, ours.get(case.wind), done | bounds)
        out.append(outcome if detailed else replace(outcome, example=None))
        for _ in runs:
            progress()
    return out


def _run_case(
    methods: list[str], data: list[AlignmentData], ours: Ours | None, followed: dict[str, list[Followed]]
) -> Outcome:
    """Return the outcome of a case; ``followed`` holds the runs of the invariant filters and of the bounds."""
    margins = np.empty((0, len(data[0].velocity.t)))
    for name, estimator in estimators(data[0].scenario).items():
        if name in methods:
            outputs = [_filter(one, estimator) for one in data]
            followed[name] = [_additive(one, output) for one, output in zip(data, outputs, strict=True)]
            if name == "hinf":
                margins = np.array([seen.margin for output in outputs for seen in output.seen if seen is not None])
    if ours is not None:
        followed[OURS] = ours.followed
    t, changed = data[0].truth.t, data[0].scenario.wind[-1].start
    found = np.full((len(t) - 1, 2), np.nan) if ours is None else ours.wind
    return Outcome(
        t=t,
        runs={name: reduced(t, followed[name], changed) for name in methods},
        fixed={} if ours is None else ours.fixed,
        margins=margins.min(axis=0, keepdims=True) if len(margins) else margins,
        without_filter=np.mean(~(margins > 0), axis=1),
        example=Example(t, changed, {name: followed[name][0] for name in methods}, data[0].wind_n, found),
    )


def _ours(case: Case, data: list[AlignmentData]) -> Ours:
    said = [align(d.increments, d.velocity.values[:, :2], d.velocity.t, setup_of(d.scenario)) for d in data]
    tilts = [fixed_winds(one) for one in data] if case.tried else [{}]
    fixed = {name: np.array([tilt[name] for tilt in tilts]) for name in tilts[0]}
    return Ours([aligned(*one) for one in zip(data, said, strict=True)], fixed, said[0].wind)


def _banked(case: Case, data: AlignmentData) -> Followed:
    run = heading_bank(data.increments, data.velocity.values, setup_of(data.scenario), bank_of(case))
    return judged(data, run.q_nb, run.P)


def _invariant(work: Work, data: list[list[AlignmentData]]) -> list[dict[str, list[Followed]]]:
    """Run the invariant filters over all cases that have them together."""
    out: list[dict[str, list[Followed]]] = [{} for _ in data]
    for name, correction in INVARIANT.items():
        cases = [k for k, case in enumerate(work.cases) if name in work.methods_of(case)]
        runs = [one for k in cases for one in data[k]]
        if not runs:
            continue
        rows, z = np.array([d.increments.rows for d in runs]), np.array([d.velocity.values for d in runs])
        start = InvariantStart(
            np.array([d.q_nb_start for d in runs]), np.array([d.scenario.misalignment for d in runs])
        )
        said = invariant_ekf(rows, z, start, replace(setup_of(runs[0].scenario), reference_sd=UNIT), correction)
        followed = iter([judged(one, q, P) for one, q, P in zip(runs, said.q_nb, said.P, strict=True)])
        for k in cases:
            out[k][name] = [next(followed) for _ in data[k]]
    return out


def _filter(data: AlignmentData, estimator: UKF | HInfinity) -> Output:
    t, rows = data.velocity.t, data.increments.rows
    running = stream(estimator, start_of(data, estimator))
    # The first row only sets the clock: no increment ends at the start.
    return running.run(np.append(0.0, t), np.vstack([rows[:1], rows]), [SensorData(t, data.velocity.values)])


def _additive(data: AlignmentData, output: Output) -> Followed:
    Q = output.x[:, 3:7]
    P = unpack(output.P)[:, 3:7, 3:7] if output.P is not None else np.full((len(Q), 4, 4), np.nan)
    return judged(data, quat_normalize(Q), additive_covariance(Q, P))
