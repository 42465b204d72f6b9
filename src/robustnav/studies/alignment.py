"""The alignment study: the published comparison repeated, explained by its measurement weight, and ours beside it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.studies.alignment_figures import CURVES, Course, bound_summary, course_of, spread, summary
from robustnav.studies.alignment_runs import Example, Outcome, Progress, Work, run_work
from robustnav.studies.alignment_setting import BOUNDS, METHODS, OURS, all_cases, stations

LEAST_SEEDS = 4
COLUMNS = {
    "tilt_arcmin": "tilt, 150 to 200 s, arcmin",
    "tilt_at_50_s_arcmin": "tilt at 50 s, arcmin",
    "settle_s": "below 10 arcmin from, s",
    "heading_deg": "heading at 200 s, deg",
    "nees": "NEES tilt (2)",
    "heading_nees": "NEES heading (1)",
}


@dataclass(frozen=True)
class CaseFigures:
    """Figures of one case by method or bound; ``fixed``: tilt after the start or the change by single wind [arcmin].

    ``t`` (n,) [s] of the ``courses``; the least existence margin over runs (n,), empty where ``hinf`` did not run.
    """

    figures: dict[str, dict[str, object]]
    fixed: dict[str, dict[str, float]]
    t: Array
    courses: dict[str, Course]
    margin: Array


@dataclass(frozen=True)
class AlignmentStudy:
    """All numbers of the study by case, and the first run of each case in detail."""

    seeds: int
    seed: int
    cases: dict[str, CaseFigures]
    examples: dict[str, Example]


@dataclass(frozen=True)
class Selection:
    """What runs: names of cases and of methods or bounds, all where none is given.

    Raises
    ------
    InputError : a name that does not exist.
    """

    cases: Sequence[str] = ()
    methods: Sequence[str] = ()

    def __post_init__(self) -> None:
        _known("case", self.cases, [case.name for case in all_cases()])
        _known("method", self.methods, METHODS | BOUNDS)

    def work(self) -> list[Work]:
        """Return the selected cases by place and gyros, with the methods to run."""
        chosen = [case for case in all_cases() if not self.cases or case.name in self.cases]
        methods = frozenset(self.methods or METHODS | BOUNDS)
        return [Work(group, methods) for group in stations(case for case in chosen if methods & set(case.methods))]

    def steps(self, seeds: int) -> int:
        """Return how often ``progress`` will be called."""
        return seeds * sum(len(one.cases) for one in self.work())


def alignment_study(
    seeds: int = 100, seed: int = 0, progress: Progress = lambda: None, selection: Selection | None = None
) -> AlignmentStudy:
    """Run the study.

    Parameters
    ----------
    seeds : independent runs a scenario and wind.
    seed : the first of them.
    progress : called after every seed of every case, ``selection.steps(seeds)`` times, from two threads.
    selection : cases and methods; everything without.

    Raises
    ------
    InputError : fewer than 4 seeds, a negative seed, or nothing selected.
    """
    if seeds < LEAST_SEEDS:
        raise InputError("seeds", got=str(seeds), expected=f"{LEAST_SEEDS} or more")
    work = (selection or Selection()).work()
    if not work:
        raise InputError(
            "alignment study", got="no case for these methods", expected=f"a case where they run, or {OURS}"
        )
    outcomes = run_work(work, range(seed, seed + seeds), progress)
    found = {
        c.name: (c, o) for one, row in zip(work, outcomes, strict=True) for c, o in zip(one.cases, row, strict=True)
    }
    ordered = [found[case.name] for case in all_cases() if case.name in found]
    return AlignmentStudy(
        seeds,
        seed,
        {case.name: case_figures(outcome) for case, outcome in ordered},
        {case.name: outcome.example for case, outcome in ordered if outcome.example is not None},
    )


def case_figures(outcome: Outcome) -> CaseFigures:
    """Return the figures of a case."""
    runs = outcome.runs
    figures = {name: bound_summary(one) if name in BOUNDS else summary(one) for name, one in runs.items()}
    if len(outcome.margins):
        figures["hinf"]["no_filter_steps"] = float(outcome.without_filter.mean())
        figures["hinf"]["least_margin"] = float(outcome.margins.min())
    fixed = {name: spread(one) for name, one in outcome.fixed.items()}
    courses = {name: course_of(one) for name, one in runs.items() if name not in BOUNDS}
    margin = outcome.margins.min(axis=0) if len(outcome.margins) else np.empty(0)
    return CaseFigures(figures, fixed, outcome.t[::CURVES], courses, margin)


def value_of(study: AlignmentStudy, case: str, method: str, name: str, part: str = "median") -> float:
    """Return a figure, or one percentile of it."""
    figure = study.cases[case].figures[method][name]
    value = figure[part] if isinstance(figure, dict) else figure
    return float(value) if isinstance(value, float | int) else float("nan")


def rows_of(figures: Mapping[str, Mapping[str, object]]) -> list[dict[str, object]]:
    """Return a row a method, median and 95 % beside each other."""
    rows = []
    for method, row in figures.items():
        cells: dict[str, object] = {"method": method}
        for name, words in COLUMNS.items():
            figure = row.get(name)
            cells[words] = pair(figure) if isinstance(figure, dict) else "-" if figure is None else f"{figure:.2f}"
        rows.append(cells)
    return rows


def pair(figure: Mapping[str, float]) -> str:
    """Return median and 95 % as text."""
    return " / ".join("never" if np.isnan(v) else f"{v:.2f}" for v in figure.values())


def _known(thing: str, given: Iterable[str], names: Iterable[str]) -> None:
    wrong = [name for name in given if name not in names]
    if wrong:
        raise InputError(f"unknown {thing} {wrong[0]!r}", expected=f"one of {', '.join(names)}")
