"""The study of moving carriers on paper: its page and its numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustnav.report.figures.courses import Judged, error_courses, nees_courses
from robustnav.report.page import Page, Tile
from robustnav.report.results import versions, write_results
from robustnav.studies.goals import goal_rows, goal_verdict
from robustnav.studies.moving import AXES, MovingOutcome, MovingStudy, error_rows, found_rows, goals, results
from robustnav.studies.moving_setting import DURATION, SECONDS
from robustnav.units import DEG

GROUPS = {
    "Velocities and positions": ("drone, MEMS", "car, MEMS", "drone, tactical", "car, tactical"),
    "Velocities or positions alone": (
        "drone, velocity only",
        "car, velocity only",
        "drone, position only",
        "car, position only",
    ),
    "Outliers, a compass, an antenna's arm": (
        "drone, 10 % outliers, 10 s outage",
        "car, compass 10 deg",
        "car, lever arm, 0.12 s late",
    ),
}


def page(study: MovingStudy, command: str) -> Page:
    """Return the study's page: what it says first, when headings were found, errors over time, how to repeat it."""
    out = Page("Alignment in motion", "A drone and a car with a satellite receiver, nothing known at the start")
    aims = goals(study)
    goal_verdict(out, aims)
    out.tiles(_tiles(study))
    out.section("When the heading is found")
    out.text(
        "The heading counts as found when its standard deviation over filters with headings all round is below 5 deg. "
        "Wrong: more than 20 deg off at that moment."
    )
    out.table(found_rows(study), f"Of {study.seeds} recordings of {DURATION:g} s, each on its own way.")
    for title, names in GROUPS.items():
        _group(out, study, title, [name for name in names if name in study.outcomes])
    out.section("Goals")
    out.table(goal_rows(aims), "What the study must show.")
    out.section("Repeat it")
    out.settings({"seeds": study.seeds, "seed": study.seed}, versions(), command)
    return out


def write_study(study: MovingStudy, folder: str | Path, command: str) -> Path:
    """Write ``results.json`` and ``report.html`` into a folder and return the page's path.

    Raises
    ------
    InputError : the folder is a file.
    """
    return write_results(folder, results(study), page(study, command))


def _tiles(study: MovingStudy) -> list[Tile]:
    tiles = [
        Tile(name, f"{one.figures['found_s']:.1f}", "s", "heading found, median")
        for name, one in study.outcomes.items()
        if name in GROUPS["Velocities and positions"]
    ]
    return [*tiles, Tile("runs", str(study.seeds), "a scenario", "independent seeds")]


def _group(out: Page, study: MovingStudy, title: str, names: list[str]) -> None:
    if not names:
        return
    chosen = {name: study.outcomes[name] for name in names}
    out.section(title)
    rows = [row for row in error_rows(study) if row["scenario"] in chosen]
    out.table(
        rows,
        "Root mean square over runs; over peer: as a multiple of the error of the same filter started at the truth; "
        "expected NEES 1.",
    )
    t, size = np.array(SECONDS), {name: np.abs(one.errors[:, :, 2]) / DEG for name, one in chosen.items()}
    middle, high = ({name: np.quantile(one, q, axis=0) for name, one in size.items()} for q in (0.5, 0.95))
    out.figure(error_courses(t, middle, high, "heading, deg", f"Error of heading, {study.seeds} runs a case."))
    parts = {what: _judged(chosen, axes) for what, axes in AXES.items()}
    words = f"Squared errors over their variances, mean of {study.seeds} runs, from when all of them had begun."
    out.figure(nees_courses(t, parts, words))


def _judged(chosen: dict[str, MovingOutcome], axes: slice) -> Judged:
    means = {name: one.squares[:, :, axes].mean(axis=(0, 2)) for name, one in chosen.items()}
    test = next(iter(chosen.values())).nees(SECONDS[-1], axes)
    return Judged(means, test.low, test.high)
