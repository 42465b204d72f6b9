"""The runs of the ranging study: filters without a prior, filters against their bound, layouts that leave doubt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from robustnav.calibrate import Pairs, fit_line
from robustnav.design.bounds import PathRows, posterior_bound
from robustnav.engine.backends import functions_of
from robustnav.engine.snapshot import Layout, solve_many
from robustnav.errors import EstimatorError
from robustnav.evaluate import Consistency, consistency, nees
from robustnav.filter.weighting import Gate, StudentT
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.ranging import RangeDifferences, Ranges
from robustnav.records import BoolArray, Run
from robustnav.run.ensemble import Readings, run_ensemble
from robustnav.run.estimators import EKF
from robustnav.run.loop import Start
from robustnav.run.tracking import ranging_ekf, track
from robustnav.sim.quadcopter import COLOUR_SD, OFFSET, SIGMA, SLOPE, WHITE_SD
from robustnav.sim.ranging import RangingBatch, simulate_ranging
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.ranging_path import Path
from robustnav.sim.ranging_random import RandomTracks
from robustnav.sim.ranging_setup import RangingSetup, Schedule
from robustnav.studies.uwb_setting import (
    CARRIED,
    FLIGHT,
    OWN_DENSITY,
    RANGE_SD,
    Doubtful,
    Scenario,
    biased_model,
    coloured_errors,
    hall_setup,
    methods,
    own_motion,
    white_model,
)

_T = TypeVar("_T")
Progress = Callable[[], None]
THREADS = 2  # the filters release the interpreter's lock
LOST_M, LOST_S = 1.0, 2.0  # a run whose error is above one for longer than the other, while ranges come, is lost
FOUND_M, FOUND_S = 0.5, 1.0  # a filter has recovered when its error stays below the one for the other
OWN_SECONDS = 10.0
CALIBRATION = 600  # ranges at known distances, for the line
SHARE_OF_WRONG = 6.0  # errors of more standard deviations than this are confidently wrong


@dataclass(frozen=True)
class Followed:
    """What one run of one method gave: ``t`` (n,), errors and standard deviations (n, 3) [m]; None where it refused."""

    t: Array
    error: Array
    sd: Array


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
        figures[method] = _figures([None if f is None else _errors(*f) for f in found], scenario)
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


@dataclass(frozen=True)
class Bounded:
    """Filters on tracks of their own model, from a known prior, beside the bound.

    By filter: ``figures``, ``test`` and ``values`` (runs, n) of the position's NEES; ``rms`` (n,) of the position's
    error over runs [m]; ``bound`` (n,) [m], or None.
    """

    t: Array
    figures: dict[str, dict[str, float]]
    tests: dict[str, Consistency]
    values: dict[str, Array]
    rms: dict[str, Array]
    bound: Array | None


def run_bounded(seeds: int, seed: int, progress: Progress) -> Bounded:
    """Run filters with Gaussian ranges on tracks of their own model, and reckon the bound along those tracks."""
    setup = hall_setup(OWN_SECONDS, RangingErrors(white_sd=RANGE_SD))
    tracks = own_motion().draw(setup.events.t, runs=seeds, seed=seed)
    model = white_model(RANGE_SD, OWN_DENSITY)
    filters = {
        "ekf": EKF(model),
        "gate": ranging_ekf(model, Gate(8.8)),
        "student": ranging_ekf(model, StudentT()),
    }
    return _own_runs(filters, setup, tracks, seed, progress, bound=True)


def run_coloured(seeds: int, seed: int, progress: Progress) -> Bounded:
    """Run the model with white noise and the one with biases on ranges whose errors last."""
    setup = hall_setup(OWN_SECONDS, coloured_errors())
    tracks = own_motion().draw(setup.events.t, runs=seeds, seed=seed)
    sd = float(np.hypot(WHITE_SD, COLOUR_SD))
    filters = {
        "white noise": EKF(white_model(sd, OWN_DENSITY)),
        "biased": ranging_ekf(biased_model(OWN_DENSITY), Gate()),
    }
    return _own_runs(filters, setup, tracks, seed, progress, bound=False)


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


def _figures(found: Sequence[Followed | None], scenario: Scenario) -> dict[str, float]:
    """Return the figures of a method: errors from the first position on, recovery, lost and refused runs."""
    runs = [f for f in found if f is not None]
    out = {"runs": float(len(found)), "refused": float(len(found) - len(runs))}
    if not runs:
        return out | {"lost": float(len(found))}
    # where a tag was moved unseen, its error until it is found again is what recovery tells, not what the filter's does
    since = [_after(f, scenario) for f in runs]
    out |= position_figures([f.error[s] for f, s in zip(runs, since, strict=True)])
    normalised = np.concatenate([((f.error / f.sd)[s] ** 2).sum(axis=1) for f, s in zip(runs, since, strict=True)])
    recovery = np.array([_recovery(f, scenario.returns) for f in runs])
    lost = [_lost(f, scenario) for f in runs]
    out |= {"nees": float(np.mean(normalised)), "lost": float(sum(lost)) + out["refused"]}
    if scenario.returns is not None:
        out |= {"recovery_median_s": float(np.median(recovery)), "recovery_max_s": float(np.max(recovery))}
    return out


def position_figures(errors: Sequence[Array]) -> dict[str, float]:
    """Return rms in the plane and in space, and the 95th percentile, of errors (n, 3) of several runs [m]."""
    squares = np.vstack(errors) ** 2
    return {
        "rmse_2d": float(np.sqrt(squares[:, :2].sum(axis=1).mean())),
        "rmse_3d": float(np.sqrt(squares.sum(axis=1).mean())),
        "p95_3d": float(np.sqrt(np.percentile(squares.sum(axis=1), 95))),
    }


def _after(followed: Followed, scenario: Scenario) -> BoolArray:
    """Return which rows are judged: all, but for two seconds after ranges return or a tag was moved."""
    if scenario.returns is None:
        return np.ones(len(followed.t), bool)
    return (followed.t < scenario.returns) | (followed.t > scenario.returns + LOST_S)


def _recovery(followed: Followed, returns: float | None) -> float:
    """Return how long after ranges return the error falls below ``FOUND_M`` and stays there for a second [s]."""
    if returns is None:
        return 0.0
    later = followed.t >= returns
    t = followed.t[later]
    far = t[np.linalg.norm(followed.error[later], axis=1) > FOUND_M]
    begins = np.concatenate([[returns], far])
    ends = np.concatenate([far, [t[-1]]])
    held = np.flatnonzero(ends - begins > FOUND_S)
    return float(begins[held[0]] - returns) if held.size else float("inf")


def _lost(followed: Followed, scenario: Scenario) -> bool:
    """Return whether the error stays above a limit for too long while ranges come."""
    far = np.linalg.norm(followed.error, axis=1) > LOST_M
    change = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]]).astype(int)))
    for begin, stop in zip(change[::2], change[1::2] - 1, strict=True):
        start, end = followed.t[begin], followed.t[stop]
        if scenario.returns is not None and start <= scenario.returns <= end:
            start = scenario.returns
        if end - start > LOST_S:
            return True
    return False


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


def _own_runs(
    filters: dict[str, EKF], setup: RangingSetup, tracks: RandomTracks, seed: int, progress: Progress, *, bound: bool
) -> Bounded:
    """Run filters over tracks of their own model; they know the distribution the tracks start from."""
    runs = len(tracks.p_n)
    batch = simulate_ranging(tracks, setup, runs=runs, seed=seed)
    figures, tests, values, rms = {}, {}, {}, {}
    start = own_start(white_model(RANGE_SD, OWN_DENSITY))
    for name, estimator in filters.items():
        model = estimator.model
        ensemble = run_ensemble(
            estimator, _fed(model, batch), [own_start(model)] * runs, covariance=True, progress=progress
        )
        error = ensemble.x[..., :3] - tracks.p_n
        P = np.empty(0) if ensemble.P is None else ensemble.P[..., :3, :3]
        values[name] = nees(error, P)
        tests[name] = consistency(values[name], 3)
        figures[name] = position_figures(list(error)) | {"nees": tests[name].mean, "lost": 0.0, "runs": float(runs)}
        rms[name] = np.sqrt((error**2).sum(axis=2).mean(axis=0))
    limit = None
    if bound:
        P = range_bound(white_model(RANGE_SD, OWN_DENSITY), start.P, setup, tracks)
        limit = np.sqrt(np.trace(P[..., :3, :3], axis1=-2, axis2=-1).mean(axis=1))
        plane = np.sqrt(np.trace(P[..., :2, :2], axis1=-2, axis2=-1).mean())
        figures["bound"] = {"rmse_2d": float(plane), "rmse_3d": float(np.sqrt(np.mean(limit**2)))}
    return Bounded(setup.events.t, figures, tests, values, rms, limit)


def own_start(model: Model) -> Start:
    """Return the start that ``own_motion`` draws tracks from."""
    motion = own_motion()
    return Start.at(model, {"p_n": motion.p_sd, "v_n": motion.v_sd}, p_n=motion.p_mean, v_n=motion.v_mean)


def _fed(model: Model, batch: RangingBatch) -> Readings:
    """Return a batch as filters take it."""
    t, values = batch.t, batch.readings()
    if "range_bias" in model.state_slices:
        slots = np.eye(len(batch.setup.anchors.ids))[batch.setup.events.second]
        values = np.concatenate([values, np.broadcast_to(slots, (*values.shape[:2], slots.shape[1]))], axis=2)
    sensors = [(t, values) if s.name == "range" else None for s in model.sensors]
    return Readings(t, np.zeros((len(values), len(t), 0)), sensors)


def range_bound(model: Model, P0: Array, setup: RangingSetup, tracks: RandomTracks) -> Array:
    """Return the posterior Cramer-Rao bound (n, runs, 6, 6) along every true track.

    Averaged over tracks it bounds the mean square error of any estimator (Tichavsky et al. 1998, section II).
    """
    functions, t = functions_of(model), setup.events.t
    steps = [functions.transition(np.zeros(6), np.zeros(0), dt) for dt in np.diff(t, prepend=t[0])]
    F, Q = (np.array([s[k] for s in steps])[:, None] for k in (0, 1))
    away = np.swapaxes(tracks.p_n, 0, 1) - setup.anchors.p_a[setup.events.second][:, None]
    H = np.zeros((*away.shape[:2], 1, 6))
    H[..., 0, :3] = away / np.linalg.norm(away, axis=2, keepdims=True)
    F = np.broadcast_to(F, (*away.shape[:2], 6, 6))
    return posterior_bound(F, Q, [PathRows(H, np.array([model.variances[0]]))], P0)
