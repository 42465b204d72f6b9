"""The ranging study: filters against their bound, robustness, recovery, and layouts that leave doubt."""

from __future__ import annotations

from dataclasses import dataclass

from robustnav.errors import InputError
from robustnav.sim.quadcopter import assumptions
from robustnav.studies.goals import Goal, goal
from robustnav.studies.uwb_own import Bounded, Progress, run_bounded, run_coloured
from robustnav.studies.uwb_runs import Outcome, run_doubtful, run_scenario, seeds_of
from robustnav.studies.uwb_setting import HARD, doubtful, scenarios

LEAST_SEEDS = 4
OWN_FILTERS = 3 + 2  # of the two scenarios on tracks of the filters' own model
PART_OF_DOUBT = 0.1  # share of the seeds for each layout that leaves doubt
OWN, COLOURED = "own motion", "lasting errors"
RECOVERING = ("outage", "kidnapped", "jump")


@dataclass(frozen=True)
class UwbStudy:
    """All numbers of the study; ``own`` and ``coloured`` are on tracks of the filters' own model."""

    seeds: int
    seed: int
    own: Bounded
    coloured: Bounded
    scenarios: dict[str, Outcome]
    doubtful: dict[str, dict[str, float]]


def doubtful_seeds(seeds: int) -> int:
    """Return how many runs a doubtful layout has."""
    return max(int(PART_OF_DOUBT * seeds), min(seeds, 10))


def steps_of(seeds: int) -> int:
    """Return how often ``progress`` will be called."""
    tracked = sum(seeds_of(s, seeds) * len(s.methods) for s in scenarios().values())
    return tracked + OWN_FILTERS * seeds + len(doubtful()) * doubtful_seeds(seeds)


def uwb_study(seeds: int = 500, seed: int = 1, progress: Progress = lambda: None) -> UwbStudy:
    """Run the study.

    Parameters
    ----------
    seeds : independent runs a scenario; the long flight has a tenth of them, so has each doubtful layout.
    seed : fixes every random number.
    progress : called after every run, ``steps_of(seeds)`` times.

    Raises
    ------
    InputError : fewer than 4 seeds.
    """
    if seeds < LEAST_SEEDS:
        raise InputError("seeds", got=str(seeds), expected=f"{LEAST_SEEDS} or more")
    own, coloured = run_bounded(seeds, seed, progress), run_coloured(seeds, seed, progress)
    outcomes = {name: run_scenario(name, one, seeds, seed, progress) for name, one in scenarios().items()}
    doubts = {name: run_doubtful(one, doubtful_seeds(seeds), seed, progress) for name, one in doubtful().items()}
    return UwbStudy(seeds, seed, own, coloured, outcomes, doubts)


def goals(study: UwbStudy) -> list[Goal]:
    """Return what the study must show, with its figures."""
    own, figures = study.own.figures, {name: outcome.figures for name, outcome in study.scenarios.items()}
    clean = figures["clean"]["student"]
    out = [
        goal("EKF over its bound, Gaussian ranges", own["ekf"]["rmse_3d"] / own["bound"]["rmse_3d"], 1.1),
        goal("steps outside the NEES band, EKF", 1 - study.own.tests["ekf"].inside, 0.1),
        goal(
            "student over outlier-free, 20 % outliers",
            figures["outliers"]["student"]["rmse_3d"] / clean["rmse_3d"],
            1.5,
        ),
        goal("student, runs lost, 20 % outliers", figures["outliers"]["student"]["lost"], 0.0),
        goal(
            "steps outside the NEES band, biased model, lasting errors", 1 - study.coloured.tests["biased"].inside, 0.1
        ),
    ]
    for name in RECOVERING:
        for method in ("gate", "student"):
            worst = figures[name][method].get("recovery_max_s", float("inf"))
            out.append(goal(f"{method}, slowest recovery, {name}, s", worst, 2.0))
            out.append(goal(f"{method}, runs lost, {name}", figures[name][method]["lost"], 0.0))
    wrong = sum(row["wrong"] for name, row in study.doubtful.items() if name not in HARD)
    return [*out, goal("runs confidently wrong in doubtful layouts", wrong, 0.0)]


def results(study: UwbStudy) -> dict[str, object]:
    """Return the study as the plain numbers of ``results.json``."""
    entries: dict[str, object] = {
        OWN: study.own.figures,
        COLOURED: study.coloured.figures,
        **{name: outcome.figures for name, outcome in study.scenarios.items()},
    }
    return {
        "study": "uwb",
        "seeds": study.seeds,
        "seed": study.seed,
        "scenarios": entries,
        "consistency": {
            name: {method: vars(test) for method, test in one.tests.items()}
            for name, one in ((OWN, study.own), (COLOURED, study.coloured))
        },
        "doubtful": study.doubtful,
        "goals": [one._asdict() for one in goals(study)],
        "assumptions": [a._asdict() for a in assumptions()],
    }


def rows_of(figures: dict[str, dict[str, float]]) -> list[dict[str, object]]:
    """Return a row a method; figures in metres and seconds."""
    names = {"rmse_2d": "rmse_2d_m", "rmse_3d": "rmse_3d_m", "p95_3d": "p95_3d_m", "nees": "nees", "lost": "lost"}
    names |= {"recovery_median_s": "found_s", "recovery_max_s": "slowest_s"}
    used = [key for key in names if any(key in row for row in figures.values())]
    return [{"method": m} | {names[key]: row.get(key, float("nan")) for key in used} for m, row in figures.items()]


def doubt_rows(study: UwbStudy) -> list[dict[str, object]]:
    """Return a row a doubtful layout: how often it was refused, named, and confidently wrong."""
    return [{"layout": name, **row} for name, row in study.doubtful.items()]
