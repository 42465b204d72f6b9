"""The runs of the ranging study: filters without a prior, filters against their bound, layouts that leave doubt."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from robustnav.calibrate import Pairs, fit_line
from robustnav.engine.snapshot import Layout, solve_many
from robustnav.errors import EstimatorError
from robustnav.filter.weighting import StudentT
from robustnav.frames import Array
from robustnav.ranging import RangeDifferences, Ranges
from robustnav.records import Run
from robustnav.run.tracking import ranging_ekf, track
from robustnav.sim.quadcopter import COLOUR_SD, OFFSET, SIGMA, SLOPE, WHITE_SD
from robustnav.sim.ranging import RangingBatch, simulate_ranging
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.ranging_path import Path
from robustnav.sim.ranging_random import RandomTracks
from robustnav.sim.ranging_setup import RangingSetup, Schedule
from robustnav.studies.uwb_figures import Followed, figures_of, position_figures
from robustnav.studies.uwb_own import Progress
from robustnav.studies.uwb_setting import (
    CARRIED,
    FLIGHT,
    RANGE_SD,
    Doubtful,
    Scenario,
    methods,
    white_model,
)

_T = TypeVar("_T")
THREADS = 2  # the filters release the interpreter's lock
CALIBRATION = 600  # ranges at known distances, for the line
SHARE_OF_WRONG = 6.0  # errors of more standard deviations than this are confidently wrong


@dataclass(frozen=True)
class Outcome:
    """A scenario's figures by method, and one run with its truth (n, 3) for figures, by method."""

    figures: dict[str, dict[str, float]]
    examples: dict[str, tuple[Run, Array]]


def seeds_of(scenario: Scenario, seeds: int) -> int:
    """Return how many runs a scenario has."""
    return max(int(scenario.part * seeds), min(seeds, 20))


def run_scenario(name: str, scenario: Scenario, seeds: int, seed: int, progress: Progress) -> Outcome:
    """Run every method of a scenario over its seeds."""
    events, batch, p_n = _drawn(scenario, seeds_of(scenario, seeds), seed)
    line = fitted_line(seed) if name == FLIGHT else None
    known = methods(float(np.hypot(WHITE_SD, COLOUR_SD)) if name == FLIGHT else RANGE_SD)
    figures, examples = {}, {}
    for method in scenario.methods:
        follow = known[method]

        def one(i: int, follow: Callable[[Ranges | RangeDifferences], Run] = follow) -> tuple[Run, Array] | None:
            readings = batch.ranges(i) if scenario.setup.pairs is None else batch.differences(i)
            if line is not None and isinstance(readings, Ranges):
                readings = replace(readings, distance=line(readings.distance))
            try:
                run = follow(readings)
            except EstimatorError:
                return None
            finally:
                progress()
            return run, _truth_at(events, p_n[i % len(p_n)], run.t)

        found = _parallel(one, len(batch.runs))
        figures[method] = figures_of([None if f is None else _errors(*f) for f in found], scenario)
        example = next((f for f in found if f is not None), None)
        if example is not None:
            examples[method] = example
    if name == FLIGHT:
        figures["trilateration"] = _trilateration(scenario, batch, p_n, line)
    return Outcome(figures, examples)


def fitted_line(seed: int) -> Callable[[Array], Array]:
    """Return the published calibration: a range line fitted to ranges at known distances from 2 m to 20 m."""
    noise = np.random.default_rng([seed, 2]).standard_normal(CALIBRATION)
    distance = np.linspace(2.0, 20.0, CALIBRATION)
    line = fit_line(Pairs(distance, SLOPE * distance + OFFSET + SIGMA * noise))
    return line.distance


def run_doubtful(case: Doubtful, seeds: int, seed: int, progress: Progress) -> dict[str, float]:
    """Return how many runs of a layout refused, said that two places fit, and were confidently wrong."""
    schedule = Schedule(10.0, case.path.duration, simultaneous=False)
    setup = RangingSetup(case.anchors, schedule, RangingErrors(white_sd=RANGE_SD))
    batch = simulate_ranging(case.path.at(setup.events.t), setup, runs=seeds, seed=seed)
    estimator = ranging_ekf(white_model(RANGE_SD, 1.0), StudentT())

    def one(i: int) -> tuple[float, float, float] | None:
        try:
            run = track(estimator, batch.ranges(i))
        except EstimatorError:
            return None
        finally:
            progress()
        error = np.linalg.norm(run.state["p_n"] - case.path.at(run.t).p_n, axis=1)
        sd = np.linalg.norm(run.sd["p_n"], axis=1)
        return float(np.max(error / sd)), float(any("fit" in e for e in run.events)), float(np.sqrt(np.mean(error**2)))

    found = [f for f in _parallel(one, seeds) if f is not None]
    ratios = np.array([f[0] for f in found])
    return {
        "runs": float(seeds),
        "refused": float(seeds - len(found)),
        "said_two_places": float(sum(f[1] for f in found)),
        "wrong": float(np.count_nonzero(ratios > SHARE_OF_WRONG)),
        "largest_error_in_sd": float(np.max(ratios, initial=0.0)),
        "rmse_3d": float(np.median([f[2] for f in found])) if found else float("nan"),
    }


def _drawn(scenario: Scenario, runs: int, seed: int) -> tuple[Array, RangingBatch, Array]:
    """Return event times (n,), ranging, and positions (1 or runs, n, 3) [m]."""
    t = scenario.setup.events.t
    if isinstance(scenario.motion, Path):
        p_n = scenario.motion.at(t).p_n[None].copy()
    else:
        p_n = scenario.motion.draw(t, runs=runs, seed=seed).p_n
    if scenario.moved_at is not None:
        p_n[:, t >= scenario.moved_at] += np.asarray(CARRIED)
    shared = p_n if len(p_n) > 1 else p_n[0]
    moving = RandomTracks(t, shared, np.zeros_like(shared))
    return t, simulate_ranging(moving, scenario.setup, runs=runs, seed=seed), p_n


def _truth_at(events: Array, p_n: Array, t: Array) -> Array:
    """Return positions at times of a run (n, 3) [m], NaN where no range was due."""
    row = np.minimum(np.searchsorted(events, t), len(events) - 1)
    return np.where((events[row] == t)[:, None], p_n[row], np.nan)


def _errors(run: Run, truth: Array) -> Followed:
    here = np.isfinite(truth).all(axis=1)
    return Followed(run.t[here], run.state["p_n"][here] - truth[here], run.sd["p_n"][here])


def _parallel(one: Callable[[int], _T], runs: int) -> list[_T]:
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(one, range(runs)))


def _trilateration(
    scenario: Scenario, batch: RangingBatch, p_n: Array, line: Callable[[Array], Array] | None
) -> dict[str, float]:
    """Return the figures of single rounds solved by themselves, without a motion model or outlier rule."""
    anchors = scenario.setup.anchors.p_a
    k = len(anchors)
    rounds = batch.values.shape[1] // k
    values = batch.values[:, : rounds * k].reshape(-1, k)
    values = line(values) if line is not None else values
    solved = solve_many(Layout(anchors, RANGE_SD), values, judge=False).position
    truth = p_n[:, : rounds * k].reshape(len(p_n), rounds, k, 3).mean(axis=2)
    errors = (solved.reshape(-1, rounds, 3) - truth).reshape(-1, 3)
    known = np.isfinite(errors).all(axis=1)
    return {"runs": float(len(batch.runs)), "refused": 0.0, **position_figures([errors[known]]), "nees": float("nan")}
