"""Runs of the alignment study: one simulation feeds every estimator, and what each said is held against the truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from robustnav.alignment import Alignment, align
from robustnav.alignment.riekf import InvariantStart, invariant_ekf
from robustnav.engine.filters import Output, SensorData
from robustnav.engine.strapdown import preintegrate
from robustnav.errors import InputError
from robustnav.filter.steps import unpack
from robustnav.frames import Array, matrix_from_quat, quat_conjugate, quat_multiply, quat_normalize, rotate, wrap_angle
from robustnav.run import UKF, HInfinity, stream
from robustnav.sim.alignment import AlignmentData, simulate_alignment
from robustnav.sim.alignment_scenario import Scenario
from robustnav.studies.alignment_setting import INVARIANT, METHODS, UNIT, Case, estimators, setup_of, start_of

Progress = Callable[[], None]
WORKERS = 2
CHUNK = 50  # seeds that one worker simulates and filters together
DOWN = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Followed:
    """What one run of one method gave at the n + 1 instants; NaN where it said nothing.

    ``tilt`` (n + 1, 2) true minus estimated, about north and east [rad]; ``heading`` (n + 1,) error of the forward
    axis [rad]; ``tilt_sd`` (n + 1,) of both axes together [rad]; ``tilt_nees``, ``heading_nees`` at the end.
    """

    tilt: Array
    heading: Array
    tilt_sd: Array
    tilt_nees: float
    heading_nees: float


@dataclass(frozen=True)
class Example:
    """One run: by method what it gave, existence margins (n,), true wind (n, 3) and the one found (n, 2) [m/s]."""

    followed: dict[str, Followed]
    margin: Array
    wind_n: Array
    wind_found: Array


@dataclass(frozen=True)
class Outcome:
    """All runs of a case: by method what each run gave; ``margins`` (runs, n) of existence; the first run in detail."""

    t: Array
    followed: dict[str, list[Followed]]
    margins: Array
    example: Example

    def first(self) -> Outcome:
        """Return the first run alone."""
        followed = {name: runs[:1] for name, runs in self.followed.items()}
        return Outcome(self.t, followed, self.margins[:1], self.example)


def run_cases(cases: Sequence[Case], seeds: Sequence[int], progress: Progress) -> list[Outcome]:
    """Run all estimators over cases that differ only in where estimators start, seeds shared among workers.

    ``progress`` is called after every seed.  The result does not depend on the number of workers.
    """
    chunks = [seeds[k : k + CHUNK] for k in range(0, len(seeds), CHUNK)]
    found: list[list[Example]] = [[] for _ in cases]
    with ThreadPoolExecutor(WORKERS) as pool:
        for chunk, done in zip(chunks, pool.map(lambda chunk: _run_chunk(cases, chunk), chunks), strict=True):
            for examples, more in zip(found, done, strict=True):
                examples += more
            for _ in chunk:
                progress()
    return [_outcome(case.load(), examples) for case, examples in zip(cases, found, strict=True)]


def _outcome(scenario: Scenario, examples: list[Example]) -> Outcome:
    t = np.arange(scenario.intervals + 1) / scenario.filter_rate_hz
    followed = {name: [e.followed[name] for e in examples] for name in METHODS}
    return Outcome(t, followed, np.array([e.margin for e in examples]), examples[0])


def tilt_error(q_true: Array, q_est: Array) -> Array:
    """Return the rotation (..., 2) [rad] about the estimate's north and east that levels it; its heading is free."""
    up = rotate(quat_multiply(q_est, quat_conjugate(q_true)), DOWN)
    size = np.hypot(up[..., 0], up[..., 1])
    turn = np.arctan2(size, up[..., 2]) / np.maximum(size, 1e-300)
    return np.stack([turn * up[..., 1], -turn * up[..., 0]], axis=-1)


def heading_error(q_true: Array, q_est: Array) -> Array:
    """Return true minus estimated heading of the forward axis (...,) [rad]."""
    C, E = matrix_from_quat(q_true), matrix_from_quat(q_est)
    return wrap_angle(np.arctan2(C[..., 1, 0], C[..., 0, 0]) - np.arctan2(E[..., 1, 0], E[..., 0, 0]))


def additive_covariance(quaternion: Array, P: Array) -> Array:
    """Return the covariance (..., 3, 3) of the rotation about n axes from that of an additive quaternion (..., 4, 4).

    ``Q_true = Exp(theta) * Q^`` moves the quaternion by ``(0, theta / 2) * Q^``; lengths are taken off.
    """
    length2 = np.sum(quaternion**2, axis=-1)[..., None, None]
    back = quat_multiply(np.eye(4), quat_conjugate(quaternion)[..., None, :])[..., 1:]  # rows: unit dQ to theta / 2
    out: Array = 4 * np.swapaxes(back, -1, -2) @ P @ back / length2**2
    return out


def _run_chunk(cases: Sequence[Case], seeds: Sequence[int]) -> list[list[Example]]:
    """Return an example a case and seed; ``align`` is told of no start, so it runs once a seed."""
    data = [[simulate_alignment(case.load(), seed, preintegrate) for seed in seeds] for case in cases]
    told = [_align(one) for one in data[0]]
    invariant = _invariant([one for case in data for one in case])
    examples = []
    for k, case in enumerate(data):
        filters = estimators(case[0].scenario)
        row = []
        for i, one in enumerate(case):
            outputs = {name: _filter(one, estimator) for name, estimator in filters.items()}
            followed = {name: _additive(one, output) for name, output in outputs.items()}
            followed |= {name: runs[k * len(case) + i] for name, runs in invariant.items()}
            followed["align"] = _aligned(one, told[i])
            seen = outputs["hinf"].seen[0]
            margin = np.full(len(one.velocity.t), np.nan) if seen is None else seen.margin
            row.append(Example(followed, margin, one.wind_n, told[i].wind))
        examples.append(row)
    return examples


def _invariant(data: list[AlignmentData]) -> dict[str, list[Followed]]:
    """Run the invariant filters over all of them together."""
    rows, z = np.array([d.increments.rows for d in data]), np.array([d.velocity.values for d in data])
    start = InvariantStart(np.array([d.q_nb_start for d in data]), np.array([d.scenario.misalignment for d in data]))
    setup = replace(setup_of(data[0].scenario), reference_sd=UNIT)
    out = {}
    for name, correction in INVARIANT.items():
        run = invariant_ekf(rows, z, start, setup, correction)
        out[name] = [_judge(one, q, P) for one, q, P in zip(data, run.q_nb, run.P, strict=True)]
    return out


def _align(data: AlignmentData) -> Alignment:
    return align(data.increments, data.velocity.values[:, :2], data.velocity.t, setup_of(data.scenario))


def _filter(data: AlignmentData, estimator: UKF | HInfinity) -> Output:
    t, rows = data.velocity.t, data.increments.rows
    begin = np.full((1, rows.shape[1]), np.nan)  # no increment ends at the start
    running = stream(estimator, start_of(data, estimator))
    return running.run(np.append(0.0, t), np.vstack([begin, rows]), [SensorData(t, data.velocity.values)])


def _additive(data: AlignmentData, output: Output) -> Followed:
    Q = output.x[:, 3:7]
    P = unpack(output.P)[:, 3:7, 3:7] if output.P is not None else np.full((len(Q), 4, 4), np.nan)
    return _judge(data, quat_normalize(Q), additive_covariance(Q, P))


def _judge(data: AlignmentData, q_nb: Array, P: Array) -> Followed:
    """Hold attitudes and covariances (n + 1, 3, 3) about n axes against the truth."""
    q_true = _truth(data)
    tilt, heading = tilt_error(q_true, q_nb), heading_error(q_true, q_nb)
    return Followed(
        tilt=tilt,
        heading=heading,
        tilt_sd=np.sqrt(np.trace(P[:, :2, :2], axis1=1, axis2=2)),
        tilt_nees=float(tilt[-1] @ np.linalg.solve(P[-1, :2, :2], tilt[-1])),
        heading_nees=float(heading[-1] ** 2 / P[-1, 2, 2]),
    )


def _aligned(data: AlignmentData, said: Alignment) -> Followed:
    """As ``_judge``; the tilt's covariance is about axes of its own, so NEES is reckoned with its mean radius."""
    q_true = _truth(data)
    tilt = np.vstack([np.full((1, 2), np.nan), tilt_error(q_true[1:], said.q_nb)])
    heading = np.append(np.nan, heading_error(q_true[1:], said.q_nb))
    trace = np.append(np.nan, np.trace(said.tilt_cov, axis1=1, axis2=2))
    return Followed(
        tilt=tilt,
        heading=heading,
        tilt_sd=np.sqrt(trace),
        tilt_nees=float(2 * tilt[-1] @ tilt[-1] / trace[-1]),
        heading_nees=float(heading[-1] ** 2 / said.heading_sd[-1] ** 2),
    )


def _truth(data: AlignmentData) -> Array:
    """Return the true attitude (n + 1, 4)."""
    if data.truth.q_nb is None:
        raise InputError("simulated alignment", got="a truth without attitude", expected="q_nb")
    return data.truth.q_nb
