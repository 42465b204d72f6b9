"""The alignment study: the published comparison repeated, explained by its measurement weight, and ours beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.monte_carlo import settle_time
from robustnav.frames import Array
from robustnav.studies.alignment_runs import Followed, Outcome, Progress, run_cases
from robustnav.studies.alignment_setting import METHODS, PUBLISHED, WINDS, Case, groups
from robustnav.units import ARCMIN, DEG

LEAST_SEEDS = 4
TAIL = 150.0  # s, from which tilt is judged
SETTLED = 10.0  # arcmin
CLAIMED_SETTLE = 50.0  # s, of the published filter
MIDDLE, HIGHEST = 50, 95  # percentiles reported
COLUMNS = {
    "tilt_arcmin": "tilt, 150 to 200 s, arcmin",
    "tilt_at_50_s_arcmin": "tilt at 50 s, arcmin",
    "settle_s": "below 10 arcmin from, s",
    "heading_deg": "heading at 200 s, deg",
    "nees": "NEES tilt (2)",
    "heading_nees": "NEES heading (1)",
}
CURVES = 10  # every tenth instant is kept of an error's course


@dataclass(frozen=True)
class Course:
    """Tilt over time of many runs: ``median``, ``p95``, and the sd a filter claims, ``claimed`` (n,) [arcmin]."""

    median: Array
    p95: Array
    claimed: Array


@dataclass(frozen=True)
class CaseFigures:
    """Figures of one case by method; ``t`` (n,) [s] and ``courses``; the least existence margin over runs (n,)."""

    figures: dict[str, dict[str, object]]
    t: Array
    courses: dict[str, Course]
    margin: Array


@dataclass(frozen=True)
class AlignmentStudy:
    """All numbers of the study by case, and the first run of each case of the published wind in detail."""

    seeds: int
    seed: int
    cases: dict[str, CaseFigures]
    examples: dict[str, Outcome]


class Goal(NamedTuple):
    """What the study must show: a value between two limits; a filter that never settles does so after infinity."""

    name: str
    value: float
    low: float
    high: float
    met: bool


def steps_of(seeds: int) -> int:
    """Return how often ``progress`` will be called."""
    return len(groups()) * seeds


def alignment_study(seeds: int = 100, seed: int = 0, progress: Progress = lambda: None) -> AlignmentStudy:
    """Run the study.

    Parameters
    ----------
    seeds : independent runs a scenario and wind.
    seed : the first of them.
    progress : called after every seed, ``steps_of(seeds)`` times.

    Raises
    ------
    InputError : fewer than 4 seeds, or a negative seed.
    """
    if seeds < LEAST_SEEDS:
        raise InputError("seeds", got=str(seeds), expected=f"{LEAST_SEEDS} or more")
    out, examples = {}, {}
    for cases in groups():
        for case, outcome in zip(cases, run_cases(cases, range(seed, seed + seeds), progress), strict=True):
            out[case.name] = case_figures(outcome)
            if case.wind in (PUBLISHED, "printed"):
                examples[case.name] = outcome.first()
    return AlignmentStudy(seeds, seed, out, examples)


def case_figures(outcome: Outcome) -> CaseFigures:
    """Return the figures of a case."""
    figures: dict[str, dict[str, object]] = {}
    courses = {}
    for name, runs in outcome.followed.items():
        size = np.array([np.hypot(*run.tilt.T) for run in runs]) / ARCMIN
        figures[name] = method_figures(outcome.t, size, runs)
        kept = slice(None, None, CURVES)
        middle, high = np.percentile(size[:, kept], [MIDDLE, HIGHEST], axis=0)
        claimed = np.median([run.tilt_sd[kept] for run in runs], axis=0) / ARCMIN
        courses[name] = Course(middle, high, claimed)
    figures["hinf"]["no_filter_steps"] = float(np.mean(~(outcome.margins > 0)))
    figures["hinf"]["least_margin"] = float(outcome.margins.min())
    return CaseFigures(figures, outcome.t[::CURVES], courses, outcome.margins.min(axis=0))


def method_figures(t: Array, size: Array, runs: list[Followed]) -> dict[str, object]:
    """Return the figures of a method from sizes of the tilt (runs, n) [arcmin] and all else of its runs."""
    tail = np.sqrt(np.mean(size[:, t > TAIL] ** 2, axis=1))
    settled = settle_time(t, size, SETTLED)
    heading = np.abs([run.heading[-1] for run in runs]) / DEG
    return {
        "tilt_arcmin": _spread(tail),
        "tilt_at_50_s_arcmin": _spread(size[:, int(np.searchsorted(t, CLAIMED_SETTLE))]),
        "settle_s": _spread(settled),
        "never_settled": int(np.isnan(settled).sum()),
        "heading_deg": _spread(heading),
        "nees": float(np.mean([run.tilt_nees for run in runs])),
        "heading_nees": float(np.mean([run.heading_nees for run in runs])),
    }


def goals(study: AlignmentStudy) -> list[Goal]:
    """Return what the study must show, with its figures."""
    tilt, settle = "tilt_arcmin", "settle_s"
    out = []
    for wind in (PUBLISHED, "printed"):
        case = Case("s-10-10-60", wind).name
        late = value_of(study, case, "ukf", settle)
        apart = value_of(study, case, "hinf", tilt) - value_of(study, case, "ukf-r1", tilt)
        out += [
            _goal(f"{case}, hinf settles, s", value_of(study, case, "hinf", settle), 0.0, CLAIMED_SETTLE),
            _goal(f"{case}, ukf settles, s", np.inf if np.isnan(late) else late, CLAIMED_SETTLE, np.inf),
            _goal(f"{case}, hinf less ukf-r1, tilt, arcmin", apart, -0.3, 0.3),
        ]
    fine, coarse = "h-30-30-170", "s-10-10-60"
    return [
        *out,
        _goal(f"{coarse}, align, tilt, arcmin", value_of(study, coarse, "align", tilt), 0.0, 1.0),
        _goal(f"{coarse}, align settles, s", value_of(study, coarse, "align", settle), 0.0, 15.0),
        _goal(f"{fine}, align, tilt, arcmin", value_of(study, fine, "align", tilt), 0.0, 0.6),
        _goal(f"{fine}, align, heading, 95 %, deg", value_of(study, fine, "align", "heading_deg", "p95"), 0.0, 0.55),
    ]


def value_of(study: AlignmentStudy, case: str, method: str, name: str, part: str = "median") -> float:
    """Return one percentile of a figure."""
    figure = study.cases[case].figures[method][name]
    return float(figure[part]) if isinstance(figure, dict) else float("nan")


def results(study: AlignmentStudy) -> dict[str, object]:
    """Return the study as the plain numbers of ``results.json``; a settle time that does not exist is NaN."""
    return {
        "study": "alignment",
        "seeds": study.seeds,
        "seed": study.seed,
        "scenarios": {name: case.figures for name, case in study.cases.items()},
        "methods": METHODS,
        "winds": WINDS,
        "goals": [goal._asdict() for goal in goals(study)],
    }


def rows_of(figures: Mapping[str, Mapping[str, object]]) -> list[dict[str, object]]:
    """Return a row a method, median and 95 % beside each other."""
    rows = []
    for method, row in figures.items():
        cells: dict[str, object] = {"method": method}
        for name, words in COLUMNS.items():
            figure = row[name]
            cells[words] = _pair(figure) if isinstance(figure, dict) else f"{figure:.2f}"
        rows.append(cells)
    return rows


def _pair(figure: Mapping[str, float]) -> str:
    return " / ".join("never" if np.isnan(v) else f"{v:.2f}" for v in figure.values())


def _spread(values: Array) -> dict[str, float]:
    """Return median and 95 % of values (runs,); NaN counts as the worst."""
    ordered = np.where(np.isnan(values), np.inf, values)
    middle, high = np.percentile(ordered, [MIDDLE, HIGHEST], method="higher")
    return {"median": _or_never(middle), "p95": _or_never(high)}


def _or_never(value: float) -> float:
    return float(value) if np.isfinite(value) else float("nan")


def _goal(name: str, value: float, low: float, high: float) -> Goal:
    return Goal(name, value, low, high, bool(low <= value <= high))
