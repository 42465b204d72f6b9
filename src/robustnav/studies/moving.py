"""The study of moving carriers: how soon the heading is found, how good it is, and whether the filter knows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from robustnav.engine.backends import functions_of
from robustnav.errors import InputError
from robustnav.evaluate import Consistency, consistency
from robustnav.frames import rotation_error
from robustnav.records import Array, Log, Run, Truth
from robustnav.run.inertial_course import found_at
from robustnav.run.loop import Start, run
from robustnav.run.moving import align_moving, fused_streams
from robustnav.run.moving_setting import moving_ekf
from robustnav.sim.moving import simulate_moving
from robustnav.sim.moving_ways import way
from robustnav.studies.goals import Goal, goal
from robustnav.studies.moving_setting import DURATION, LATITUDE, RATE_HZ, SECONDS, TIMES, MovingScenario, scenarios
from robustnav.units import DEG

LEAST_SEEDS = 4
WRONG = 20.0 * DEG  # a heading that is said to be found and is this far off was found wrong
MOST_ASTRAY = 0.0  # share of runs
MOST_OVER_PEER = 1.25
PEER_SD = {"q_nb": 0.1 * DEG, "v_n": 0.05, "p_n": 0.5}  # of a filter that starts at the truth


AXES = {"tilt": slice(0, 2), "heading": slice(2, 3)}


@dataclass(frozen=True)
class MovingOutcome:
    """Runs of one scenario.

    ``found`` (runs,) [s] from the recording's begin, NaN where the heading was not; ``wrong`` how many were found
    wrong, ``restarts`` how often a filter was started again.  At ``SECONDS``, NaN before a start: ``errors`` and
    ``peer`` (runs, seconds, 3) [rad] of the filter and of one started at the truth; ``squares`` errors squared over
    variances.
    """

    found: Array
    wrong: int
    restarts: int
    errors: Array
    peer: Array
    squares: Array

    def nees(self, second: float, axes: slice) -> Consistency:
        """Return the consistency at one of ``SECONDS`` of attitude errors, axis by axis, of runs begun.

        The band is for 99 %, so that all of five times are inside with 95 %.
        """
        values = self.squares[:, SECONDS.index(second), axes]
        begun = values[np.isfinite(values)] if np.isfinite(values).any() else np.array([np.nan])
        return consistency(begun[:, None], 1, confidence=0.99)

    @property
    def figures(self) -> dict[str, float]:
        """Seconds, degrees and ratios."""
        out = {
            "found_s": float(np.nanmedian(self.found)),
            "found_95_s": float(np.nanpercentile(self.found, 95)),
            "not_found": int(np.isnan(self.found).sum()),
            "wrong": self.wrong,
            "restarts": self.restarts,
        }
        for t in TIMES:
            k = SECONDS.index(t)
            tilt, heading = _rms(self.errors[:, k, :2]), _rms(self.errors[:, k, 2:])
            out |= {f"tilt_deg_{t:g}s": tilt, f"heading_deg_{t:g}s": heading}
            out |= {f"nees_{what}_{t:g}s": self.nees(t, axes).mean for what, axes in AXES.items()}
            out[f"heading_over_peer_{t:g}s"] = heading / _rms(self.peer[:, k, 2:])
        return out


@dataclass(frozen=True)
class MovingStudy:
    """All numbers of the study, by scenario."""

    seeds: int
    seed: int
    outcomes: dict[str, MovingOutcome]


def steps_of(seeds: int) -> int:
    """Return how often ``progress`` will be called."""
    return seeds * len(scenarios())


def moving_study(seeds: int = 100, seed: int = 1, progress: Callable[[], None] = lambda: None) -> MovingStudy:
    """Run the study.

    Parameters
    ----------
    seeds : independent runs a scenario, each on its own way.
    seed : fixes every random number.
    progress : called after every run, ``steps_of(seeds)`` times.

    Raises
    ------
    InputError : fewer than 4 seeds.
    """
    if seeds < LEAST_SEEDS:
        raise InputError("seeds", got=str(seeds), expected=f"{LEAST_SEEDS} or more")
    numbers = [1000 * seed + k for k in range(seeds)]
    return MovingStudy(seeds, seed, {name: run_scenario(one, numbers, progress) for name, one in scenarios().items()})


def run_scenario(
    scenario: MovingScenario, seeds: list[int], progress: Callable[[], None] = lambda: None
) -> MovingOutcome:
    """Run one scenario on numbered recordings."""
    rows = []
    for number in seeds:
        rows.append(_one(scenario, number))
        progress()
    found, wrong, restarts, errors, peer, squares = (list(column) for column in zip(*rows, strict=True))
    arrays = (np.array(one) for one in (errors, peer, squares))
    return MovingOutcome(np.array(found), sum(wrong), sum(restarts), *arrays)


def _one(scenario: MovingScenario, seed: int) -> tuple[float, bool, int, Array, Array, Array]:
    states = way(scenario.way, seed, DURATION, RATE_HZ)
    log = simulate_moving(states, scenario.kit, latitude=LATITUDE, seed=seed)
    truth, said = states.truth("true"), align_moving(log, scenario.grade.unit, scenario.aiding)
    errors, sd = _at_seconds(said, truth)
    times = found_at(said.events)
    found = times[0] if times else np.nan
    row = int(np.searchsorted(said.t, found)) if times else 0
    off = float(np.abs(_errors(said, truth)[row, 2]))
    restarts = sum(word.startswith("lost") for word in said.events)
    return found, bool(times) and off > WRONG, restarts, errors, _peer(scenario, log, truth, seed), (errors / sd) ** 2


def _peer(scenario: MovingScenario, log: Log, truth: Truth, seed: int) -> Array:
    """Return the errors at ``SECONDS`` of the same filter, started at the truth but for the biases."""
    aiding = replace(scenario.aiding, heading_sd=None)  # it needs no compass
    estimator = moving_ekf(log, scenario.grade.unit, aiding)
    model, rng = estimator.model, np.random.default_rng([seed, 17])
    start = Start.at(model, {**model.start_sd, **PEER_SD})
    x = start.x.copy()
    for name in PEER_SD:
        x[model.state_slices[name]] = getattr(truth, name)[0]
    e = np.zeros(model.error_size)
    for name, sd in PEER_SD.items():
        e[model.error_slices[name]] = rng.normal(0, sd, 3)
    begun = replace(start, x=functions_of(model).inject(x, e))
    return _at_seconds(run(estimator, replace(log, streams=fused_streams(log, aiding)), begun), truth)[0]


def _errors(said: Run, truth: Truth) -> Array:
    rows = np.searchsorted(truth.t, said.t - 1e-6)
    return rotation_error(np.asarray(truth.q_nb)[rows], said.state["q_nb"])


def _at_seconds(said: Run, truth: Truth) -> tuple[Array, Array]:
    """Return attitude errors and their standard deviations (seconds, 3) at ``SECONDS``, NaN before the start."""
    seconds = np.array(SECONDS)
    rows = np.searchsorted(said.t, seconds - 1e-6)
    begun = (seconds >= said.t[0])[:, None]
    errors, sd = _errors(said, truth)[rows], said.sd["q_nb"][rows]
    return np.where(begun, errors, np.nan), np.where(begun, sd, np.nan)


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.nanmean(np.sum(errors**2, axis=-1)))) / DEG


def goals(study: MovingStudy) -> list[Goal]:
    """Return what the study must show, with its figures."""
    out = []
    for name, one in study.outcomes.items():
        figures, last = one.figures, f"{TIMES[-1]:g}"
        astray = (figures["wrong"] + figures["not_found"]) / study.seeds
        out.append(goal(f"{name}: share of headings found wrong or not at all", astray, MOST_ASTRAY))
        ratio = figures[f"heading_over_peer_{last}s"]
        out.append(goal(f"{name}: heading error over that of a filter that knew, {last} s", ratio, MOST_OVER_PEER))
        tests = [one.nees(t, AXES["heading"]) for t in TIMES]
        worst = float(np.nanmax([test.mean / test.high for test in tests]))
        out.append(goal(f"{name}: largest heading NEES over its band", worst, 1.0))
    return out


def found_rows(study: MovingStudy) -> list[dict[str, object]]:
    """Return a row a scenario: when the heading was found."""
    keys = ("found_s", "found_95_s", "not_found", "wrong", "restarts")
    return [{"scenario": name} | {key: one.figures[key] for key in keys} for name, one in study.outcomes.items()]


def error_rows(study: MovingStudy) -> list[dict[str, object]]:
    """Return a row a scenario and time: rms of tilt and heading [deg], over the peer's, and NEES, expected 1."""
    rows: list[dict[str, object]] = []
    for name, one in study.outcomes.items():
        figures = one.figures
        for t in TIMES:
            keys = ("tilt_deg", "heading_deg", "heading_over_peer", "nees_tilt", "nees_heading")
            rows.append({"scenario": name, "t_s": round(t)} | {key: figures[f"{key}_{t:g}s"] for key in keys})
    return rows


def results(study: MovingStudy) -> dict[str, object]:
    """Return the study as the plain numbers of ``results.json``."""
    return {
        "study": "moving",
        "seeds": study.seeds,
        "seed": study.seed,
        "scenarios": {name: one.figures for name, one in study.outcomes.items()},
        "goals": [one._asdict() for one in goals(study)],
    }
