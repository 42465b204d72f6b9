"""The attitude study: both published cases under three start protocols, and the turns that separate the forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.evaluate import Consistency
from robustnav.frames import rotation_error
from robustnav.records import Array
from robustnav.run.ensemble import run_ensemble
from robustnav.sim.attitude_cases import assumptions
from robustnav.sim.batch import Batch
from robustnav.sim.trajectory import SineAttitude, Trajectory, full_roll_and_pitch, steady_turn
from robustnav.studies.attitude_runs import (
    Progress,
    ProtocolResult,
    attitudes,
    mekf_consistency,
    readings,
    run_protocol,
    simulated,
    start_errors,
    starts,
    time_to_one_degree,
)
from robustnav.studies.attitude_setting import (
    CASES,
    ESTIMATORS,
    PROTOCOLS,
    PUBLISHED,
    Lineup,
    acquisition,
    lineup,
    noise,
    vibrating_noise,
    vibrating_sensors,
)
from robustnav.units import DEG, DPS

AXES = ("roll", "pitch", "yaw")
LEAST_SEEDS = 20
TURN_SEEDS = 20
RATE_HZ = 100.0
HELD = "heading held at 170 deg, 180 s"
SHAKEN = "steady 20 deg/s yaw turn, 600 s, vibrating multicopter"
TURNS: dict[str, Trajectory] = {
    "steady 20 deg/s yaw turn, 180 s": steady_turn(20 * DPS, 180.0, RATE_HZ),
    SHAKEN: steady_turn(20 * DPS, 600.0, RATE_HZ),
    HELD: SineAttitude((0.0, 0.0, 170 * DEG), (0.0, 0.0, 1e-9), (0.0, 0.0, 0.5 * np.pi), 180.0, RATE_HZ),
    "full roll, pitch through 90 deg": full_roll_and_pitch(10.0, RATE_HZ),
}


@dataclass(frozen=True)
class AttitudeStudy:
    """All numbers of the study.

    ``cases`` by case and protocol; ``consistency`` of the mekf by case: statistic -> (test, values (runs, n));
    ``acquisition`` by case, noise and estimator: times (runs,) to one degree from a wide start [s];
    ``turns`` by manoeuvre and estimator: RMS of the total error [deg]; ``turn_errors`` the same over time (n,).
    """

    seeds: int
    seed: int
    cases: dict[str, dict[str, ProtocolResult]]
    consistency: dict[str, dict[str, tuple[Consistency, Array]]]
    acquisition: dict[str, dict[str, dict[str, Array]]]
    turns: dict[str, dict[str, float]]
    turn_errors: dict[str, tuple[Array, dict[str, Array]]]


def steps_of(seeds: int) -> int:
    """Return how often ``progress`` will be called."""
    return len(CASES) * seeds * (len(PROTOCOLS) * len(ESTIMATORS) + 5) + len(TURNS) * len(ESTIMATORS) * TURN_SEEDS


def attitude_study(seeds: int = 200, seed: int = 1, progress: Progress = lambda: None) -> AttitudeStudy:
    """Run the study.

    Parameters
    ----------
    seeds : independent runs a case, 20 or more.
    seed : fixes every random number.
    progress : called after every run, ``steps_of(seeds)`` times.

    Raises
    ------
    InputError : fewer than 20 seeds.
    """
    if seeds < LEAST_SEEDS:
        raise InputError("seeds", got=str(seeds), expected=f"{LEAST_SEEDS} or more")
    cases, consistency, times = {}, {}, {}
    for name, trajectory in CASES.items():
        batch = simulated(trajectory, seeds, seed)
        cases[name] = {p: run_protocol(trajectory, batch, p, seed, progress) for p in PROTOCOLS}
        consistency[name] = mekf_consistency(batch, seed, progress)
        shaken = simulated(trajectory, seeds, seed, vibrating_sensors(RATE_HZ))
        times[name] = {
            "data sheet": time_to_one_degree(batch, acquisition(RATE_HZ, noise(RATE_HZ)), seed, progress),
            "vibrating": time_to_one_degree(shaken, acquisition(RATE_HZ, vibrating_noise()), seed, progress),
        }
    turns, errors = {}, {}
    for name, motion in TURNS.items():
        vibrates = name == SHAKEN
        batch = simulated(motion, TURN_SEEDS, seed, vibrating_sensors(RATE_HZ) if vibrates else None)
        total = _turn(batch, lineup("warm", RATE_HZ, vibrating_noise() if vibrates else None), seed, progress)
        turns[name] = {k: float(np.sqrt(np.mean(v**2)) / DEG) for k, v in total.items()}
        errors[name] = (batch.t, {k: np.sqrt(np.mean(v**2, axis=0)) / DEG for k, v in total.items()})
    return AttitudeStudy(seeds, seed, cases, consistency, times, turns, errors)


def _turn(batch: Batch, line: Lineup, seed: int, progress: Progress) -> dict[str, Array]:
    """Return the total error (runs, n) [rad] of every estimator on a manoeuvre."""
    errors = start_errors(line.drawn, len(batch.runs), seed)
    out = {}
    for name, estimator in line.estimators.items():
        begin = starts(estimator.model, batch, line.told, errors)
        ensemble = run_ensemble(estimator, readings(batch), begin, progress=progress)
        q = attitudes(estimator.model, ensemble)
        out[name] = np.linalg.norm(rotation_error(q, np.broadcast_to(batch.q_nb, q.shape)), axis=-1)
    return out


def results(study: AttitudeStudy) -> dict[str, object]:
    """Return the study as the plain numbers of ``results.json``."""
    cases: dict[str, object] = {}
    for name, protocols in study.cases.items():
        entry: dict[str, object] = {}
        for protocol, result in protocols.items():
            rows: dict[str, object] = {
                k: {
                    "rms_deg": s.rms_deg,
                    "rms_low_deg": s.low_deg,
                    "rms_high_deg": s.high_deg,
                    "min_deg": s.min_deg,
                    "max_deg": s.max_deg,
                    "settle_1deg_s": float(np.median(s.settle_s)),
                    "ns_per_step": result.ns_per_step[k],
                }
                for k, s in result.scores.items()
            }
            if result.bound_deg is not None:
                rows["bound"] = {"rms_deg": result.bound_deg}
            entry[protocol] = rows
        tests = {k: vars(test) for k, (test, _) in study.consistency[name].items()}
        cases[name] = {"published": PUBLISHED[name], "protocols": entry, "mekf_consistency": tests}
    return {
        "study": "attitude",
        "seeds": study.seeds,
        "seed": study.seed,
        "axes": AXES,
        "protocols": PROTOCOLS,
        "cases": cases,
        "acquisition": acquisition_rows(study),
        "turns": {name: {k: {"rms_total_deg": v} for k, v in row.items()} for name, row in study.turns.items()},
        "assumptions": [a._asdict() for a in assumptions()],
    }


def rms_rows(study: AttitudeStudy, case: str, protocol: str) -> list[dict[str, object]]:
    """Return a row an estimator, the bound and the published figures below: RMS by axis, over the bound, time."""
    result = study.cases[case][protocol]
    rows: list[dict[str, object]] = []
    for name, score in result.scores.items():
        row = {"estimator": name} | _by_axis("deg", score.rms_deg)
        row["over_bound"] = None if result.bound_deg is None else float(np.max(score.rms_deg / result.bound_deg))
        rows.append(row | {"to_1deg_s": float(np.median(score.settle_s)), "step_ns": round(result.ns_per_step[name])})
    if result.bound_deg is not None:
        rows.append({"estimator": "bound"} | _by_axis("deg", result.bound_deg))
    return rows + [{"estimator": f"published {k}"} | _by_axis("deg", v["rms_deg"]) for k, v in PUBLISHED[case].items()]


def acquisition_rows(study: AttitudeStudy) -> list[dict[str, object]]:
    """Return a row a case and noise: median and 90 % time to one degree of h2 and mekf [s]; NaN: not reached."""
    rows: list[dict[str, object]] = []
    for case, by_noise in study.acquisition.items():
        for sensors, times in by_noise.items():
            row: dict[str, object] = {"case": case, "sensors": sensors}
            for name, values in times.items():
                reached = np.where(np.isnan(values), np.inf, values)
                row |= {
                    f"{name}_median_s": float(np.median(reached)),
                    f"{name}_90_percent_s": float(np.quantile(reached, 0.9)),
                }
            rows.append(row)
    return rows


def range_rows(study: AttitudeStudy, case: str, protocol: str) -> list[dict[str, object]]:
    """Return a row an estimator, published ones below: smallest and largest error by axis over all runs."""
    scores = study.cases[case][protocol].scores
    figures: dict[str, tuple[ArrayLike, ArrayLike]]
    figures = {name: (score.min_deg, score.max_deg) for name, score in scores.items()}
    figures |= {f"published {k}": (v["min_deg"], v["max_deg"]) for k, v in PUBLISHED[case].items()}
    return [{"estimator": name} | _by_axis("min", low) | _by_axis("max", high) for name, (low, high) in figures.items()]


def _by_axis(what: str, values: ArrayLike) -> dict[str, object]:
    return {f"{axis}_{what}": float(v) for axis, v in zip(AXES, np.asarray(values, float), strict=True)}
