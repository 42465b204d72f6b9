"""The alignment study on paper: its page and its numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustnav.evaluate.consistency import chi_square_band
from robustnav.report.drawing import Plot
from robustnav.report.figures.alignment import disturbance, existence, misalignment, tilt_courses
from robustnav.report.page import Level, Page, Tile
from robustnav.report.results import versions, write_results
from robustnav.studies.alignment import AlignmentStudy, pair, rows_of, value_of
from robustnav.studies.alignment_figures import AFTER, LASTING, TAIL
from robustnav.studies.alignment_goals import Goal, best_fixed, goals, our_cases, tried_cases
from robustnav.studies.alignment_runs import Example
from robustnav.studies.alignment_setting import BOUNDS, INVARIANT, METHODS, OURS, PUBLISHED, WINDS, Case

FIRST = 60.0  # s of the wind that are drawn
FIGURES = {"tilt_arcmin": "tilt, arcmin", "heading_deg": "heading, deg"}


def page(study: AlignmentStudy, command: str) -> Page:
    """Return the study's page: what it says first, the published claim, ours, what the wind costs, other winds."""
    out = Page("Alignment study", "Initial alignment on a swaying carrier in the wind: the published filters and ours")
    _verdict(out, study)
    _claim(out, study)
    _ours(out, study)
    _near_bounds(out, study)
    _winds(out, study)
    _honesty(out, study)
    _existence(out, study)
    out.section("Every scenario and wind")
    out.table([{"wind": wind, "what": words} for wind, words in WINDS.items()], "Winds; the first has no suffix below.")
    for name, case in study.cases.items():
        out.table(rows_of(case.figures), f"{name}, median / 95 % of {study.seeds} seeds.")
    out.section("Goals")
    out.table(goal_rows(study), "What the study must show.")
    out.section("Repeat it")
    out.settings({"seeds": study.seeds, "seed": study.seed}, versions(), command)
    return out


def results(study: AlignmentStudy) -> dict[str, object]:
    """Return the study as the plain numbers of ``results.json``; a settle time that does not exist is NaN."""
    return {
        "study": "alignment",
        "seeds": study.seeds,
        "seed": study.seed,
        "scenarios": {name: case.figures for name, case in study.cases.items()},
        "fixed_winds": {name: study.cases[name].fixed for name in tried_cases(study)},
        "methods": METHODS,
        "bounds": BOUNDS,
        "winds": WINDS,
        "goals": [goal._asdict() for goal in goals(study)],
    }


def write_study(study: AlignmentStudy, folder: str | Path, command: str) -> Path:
    """Write ``results.json`` and ``report.html`` into a folder and return the page's path.

    Raises
    ------
    InputError : the folder is a file.
    """
    return write_results(folder, results(study), page(study, command))


def goal_rows(study: AlignmentStudy) -> list[dict[str, object]]:
    """Return a row a goal."""
    return [
        {"goal": g.name, "value": f"{g.value:.3g}", "from": f"{g.low:.3g}", "to": f"{g.high:.3g}", "met": _said(g.met)}
        for g in goals(study)
    ]


def bound_rows(study: AlignmentStudy) -> list[dict[str, object]]:
    """Return a row a case and figure: ``align`` beside what it would be without the wind, and how much larger it is."""
    rows: list[dict[str, object]] = []
    for case in our_cases(study):
        bounds = [name for name in BOUNDS if name in study.cases[case].figures]
        for figure, words in FIGURES.items() if bounds else ():
            if figure == "heading_deg" and not case.startswith("h"):
                continue
            row: dict[str, object] = {"case": case, "figure": words, OURS: _pair(study, case, OURS, figure)}
            for bound in bounds:
                ratios = {
                    part: value_of(study, case, OURS, figure, part) / value_of(study, case, bound, figure, part)
                    for part in ("median", "p95")
                }
                row |= {bound: _pair(study, case, bound, figure), f"{OURS} over {bound}": pair(ratios)}
            rows.append(row)
    return rows


def wind_rows(study: AlignmentStudy) -> list[dict[str, object]]:
    """Return a row a case in which single winds were tried: ``align``, and the best of them in hindsight."""
    rows = []
    for case in tried_cases(study):
        row: dict[str, object] = {"case": case, OURS: _pair(study, case, OURS, "after_arcmin")}
        for part, words in (("median", "median"), ("p95", "95 %")):
            name, tilt = best_fixed(study, case, part)
            ratio = value_of(study, case, OURS, "after_arcmin", part) / tilt
            row |= {f"best, {words}": f"{tilt:.2f}: {name}", f"ratio, {words}": f"{ratio:.2f}"}
        rows.append(row)
    return rows


def _pair(study: AlignmentStudy, case: str, method: str, figure: str) -> str:
    return pair({part: value_of(study, case, method, figure, part) for part in ("median", "p95")})


def _verdict(out: Page, study: AlignmentStudy) -> None:
    aims = goals(study)
    missed = [g for g in aims if not g.met]
    level: Level = "warning" if missed else "ok"
    words = f"{len(aims) - len(missed)} of {len(aims)} goals are met."
    out.verdict(level, words, [_missed(g) for g in missed])
    case = Case("s-10-10-60").name
    asked = [
        ("hinf", "settle_s", "s"),
        ("ukf", "settle_s", "s"),
        (OURS, "settle_s", "s"),
        (OURS, "tilt_arcmin", "arcmin"),
    ]
    tiles = [
        Tile(f"{method} {'settles' if figure == 'settle_s' else 'tilt'}", f"{value:.3g}", unit, f"median, {case}")
        for method, figure, unit in asked
        if case in study.cases and method in study.cases[case].figures
        for value in [value_of(study, case, method, figure)]
    ]
    out.tiles([*tiles, Tile("runs", str(study.seeds), "a case", "independent seeds")])
    described = {name: words for name, words in (METHODS | BOUNDS).items() if _ran(study, name)}
    out.table([{"method": name, "what": words} for name, words in described.items()], "Methods, and what bounds them.")


def _said(met: bool) -> str:
    return "yes" if met else "no"


def _missed(goal: Goal) -> str:
    told = "" if np.isnan(goal.told) else f"; told the wind: {goal.told:.3g}"
    return f"Missed: {goal.name}: {goal.value:.3g}{told}; {goal.low:.3g} to {goal.high:.3g} asked."


def _ran(study: AlignmentStudy, method: str) -> bool:
    return any(method in case.figures for case in study.cases.values())


def _claim(out: Page, study: AlignmentStudy) -> None:
    case, printed = Case("s-10-10-60").name, Case("s-10-10-60", "printed").name
    if not (case in study.cases and printed in study.cases and "hinf" in study.cases[case].figures):
        return
    out.section("The published claim, and its cause")
    out.text(
        "In its own setting the published H-infinity filter settles within 50 s and the UKF does not. The two differ "
        "in their measurement weight, 1 m/s and 0.1 m/s; with the H-infinity filter's weight the UKF does the same."
    )
    out.figure(_courses(study, case, [name for name in METHODS if name not in INVARIANT]))
    example = study.examples[printed]
    for name in ("ukf", "ukf-r1", "hinf", OURS):
        if name in example.followed:
            run = example.followed[name]
            said = ~np.isnan(run.tilt_sd)
            sd = run.tilt_sd[said] / np.sqrt(2)
            out.figure(misalignment(example.t[said], run.tilt[said], sd, f"{name}, {printed}"))


def _ours(out: Page, study: AlignmentStudy) -> None:
    name = Case("h-30-30-170").name
    if name not in study.cases or OURS not in study.cases[name].figures:
        return
    out.section("Gyros of 0.01 deg/h, start anywhere")
    out.figure(_courses(study, name, list(METHODS)))
    words = f"What align finds of the wind, the first {FIRST:g} s of one run of {name}."
    out.figure(_disturbance(study.examples[name], 0.0, words))


def _near_bounds(out: Page, study: AlignmentStudy) -> None:
    rows = bound_rows(study)
    if not rows:
        return
    out.section("What the wind costs on these seeds")
    out.text(
        "told is the same filter with the wind known exactly, floor what the sensors' own biases leave. A goal that "
        "told misses on these seeds is missed by the draw, not by the wind."
    )
    out.table(rows, f"Tilt from {TAIL:g} s on, heading at the end, median / 95 % of {study.seeds} seeds.")


def _winds(out: Page, study: AlignmentStudy) -> None:
    rows = wind_rows(study)
    if not rows:
        return
    out.section("Winds that are not lines, or change")
    out.text(
        "One filter of align is given one wind for the whole run: each of nine Gauss-Markov winds, or the true lines. "
        "The best of them is chosen afterwards, for each case and percentile."
    )
    words = f"Tilt {AFTER:g} to {AFTER + LASTING:g} s after the start, or after the change at 100 s, arcmin."
    out.table(rows, words)
    changing = [case for case in tried_cases(study) if study.examples[case].change > 0]
    if changing:
        first = study.cases[changing[0]]
        middle = {case: study.cases[case].courses[OURS].median for case in changing}
        high = {case: study.cases[case].courses[OURS].p95 for case in changing}
        out.figure(tilt_courses(first.t, middle, high, f"align, the wind changes at 100 s, {study.seeds} seeds."))
        example = study.examples[changing[0]]
        begin = example.change - FIRST / 2
        words = f"What align finds of a wind that changes, one run of {changing[0]}."
        out.figure(_disturbance(example, begin, words))


def _disturbance(example: Example, begin: float, words: str) -> Plot:
    t = example.t[1:]
    seen = (t >= begin) & (t <= begin + FIRST)
    return disturbance(t[seen], example.wind_n[seen, :2], example.wind_found[seen], words)


def _courses(study: AlignmentStudy, case: str, methods: list[str]) -> Plot:
    figures = study.cases[case]
    methods = [name for name in methods if name in figures.courses]
    middle = {name: figures.courses[name].median for name in methods}
    high = {name: figures.courses[name].p95 for name in methods}
    return tilt_courses(figures.t, middle, high, f"{case}: {WINDS[PUBLISHED]}, {study.seeds} seeds.")


def _honesty(out: Page, study: AlignmentStudy) -> None:
    """Mean NEES of tilt on the way."""
    rows = []
    for case in our_cases(study):
        over_time = study.cases[case].figures[OURS]["nees_over_time"]
        if isinstance(over_time, dict):
            rows.append({"case": case} | {f"{moment} s": f"{value:.2f}" for moment, value in over_time.items()})
    if rows:
        out.section("How sure align is")
        low, high = chi_square_band(2, study.seeds)
        words = f"Mean NEES of align's tilt: 2 expected, {low:.2f} to {high:.2f} with 95 % in {study.seeds} runs."
        out.table(rows, words)


def _existence(out: Page, study: AlignmentStudy) -> None:
    cases = {name: case for name, case in study.cases.items() if len(case.margin)}
    if not cases:
        return
    out.section("Existence of the H-infinity filter")
    out.text("The filter exists where its margin is above zero. Far above, it differs little from a Kalman filter.")
    name, case = next(iter(cases.items()))
    words = f"The least margin over {study.seeds} seeds at each reading, {name}, gamma 5, every state bounded."
    out.figure(existence(study.examples[name].t[1:], case.margin, words))
    rows = [
        {
            "case": name,
            "least margin": one.figures["hinf"]["least_margin"],
            "steps without a filter": one.figures["hinf"]["no_filter_steps"],
        }
        for name, one in cases.items()
    ]
    out.table(rows, "Existence in every case.")
