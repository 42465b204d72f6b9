"""The alignment study on paper: its page and its numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.tables import plain
from robustnav.files import write_whole
from robustnav.report.drawing import Plot
from robustnav.report.figures.alignment import disturbance, existence, misalignment, tilt_courses
from robustnav.report.page import Level, Page, Tile
from robustnav.report.run_report import versions
from robustnav.studies.alignment import AlignmentStudy, goals, results, rows_of
from robustnav.studies.alignment_setting import INVARIANT, METHODS, PUBLISHED, WINDS, Case

FIRST = 60.0  # s of the wind that are drawn


def page(study: AlignmentStudy, command: str) -> Page:
    """Return the study's page: what it says first, the published claim, ours, other winds."""
    out = Page("Alignment study", "Initial alignment on a swaying carrier in the wind: the published filters and ours")
    _verdict(out, study)
    _claim(out, study)
    _ours(out, study)
    _existence(out, study)
    out.section("Every scenario and wind")
    out.table([{"wind": wind, "what": words} for wind, words in WINDS.items()], "Winds; the first has no suffix below.")
    for name, case in study.cases.items():
        out.table(rows_of(case.figures), f"{name}, median / 95 % of {study.seeds} seeds.")
    out.section("Repeat it")
    out.settings({"seeds": study.seeds, "seed": study.seed}, versions(), command)
    return out


def write_study(study: AlignmentStudy, folder: str | Path, command: str) -> Path:
    """Write ``results.json`` and ``report.html`` into a folder and return the page's path.

    Raises
    ------
    InputError : the folder is a file.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError("output folder", place=str(folder), got="a file", expected="a folder, or a name that is free")
    text = json.dumps(plain(results(study)), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    html = page(study, command).html()
    write_whole(folder / "results.json", text)
    write_whole(folder / "report.html", html)
    return folder / "report.html"


def goal_rows(study: AlignmentStudy) -> list[dict[str, object]]:
    """Return a row a goal."""
    return [
        {"goal": g.name, "value": g.value, "from": g.low, "to": g.high, "met": "yes" if g.met else "no"}
        for g in goals(study)
    ]


def _verdict(out: Page, study: AlignmentStudy) -> None:
    aims = goals(study)
    missed = [g for g in aims if not g.met]
    level: Level = "warning" if missed else "ok"
    words = f"{len(aims) - len(missed)} of {len(aims)} goals are met."
    out.verdict(level, words, [f"Missed: {g.name}: {g.value:.3g}, {g.low:g} to {g.high:g} asked." for g in missed])
    by_name = {g.name: g.value for g in aims}
    tiles = [("hinf settles", "s-10-10-60, hinf settles, s", "s"), ("ukf settles", "s-10-10-60, ukf settles, s", "s")]
    tiles += [("align settles", "s-10-10-60, align settles, s", "s")]
    tiles += [("align tilt", "s-10-10-60, align, tilt, arcmin", "arcmin")]
    shown = [Tile(name, f"{by_name[key]:.3g}", unit, "median, s-10-10-60") for name, key, unit in tiles]
    out.tiles([*shown, Tile("runs", str(study.seeds), "a case", "independent seeds")])
    out.table(goal_rows(study), "What the study must show.")
    out.table([{"method": name, "what": words} for name, words in METHODS.items()], "Methods.")


def _claim(out: Page, study: AlignmentStudy) -> None:
    case, printed = Case("s-10-10-60", PUBLISHED).name, Case("s-10-10-60", "printed").name
    out.section("The published claim, and its cause")
    out.text(
        "In its own setting the published H-infinity filter settles within 50 s and the UKF does not. The two differ "
        "in their measurement weight, 1 m/s and 0.1 m/s; with the H-infinity filter's weight the UKF does the same."
    )
    out.figure(_courses(study, case, tuple(name for name in METHODS if name not in INVARIANT)))
    example = study.examples[printed]
    for name in ("ukf", "ukf-r1", "hinf", "align"):
        run = example.followed[name][0]
        said = ~np.isnan(run.tilt_sd)
        out.figure(misalignment(example.t[said], run.tilt[said], run.tilt_sd[said] / np.sqrt(2), f"{name}, {printed}"))


def _ours(out: Page, study: AlignmentStudy) -> None:
    out.section("Gyros of 0.01 deg/h, start anywhere")
    name = Case("h-30-30-170", PUBLISHED).name
    out.figure(_courses(study, name, tuple(METHODS)))
    example = study.examples[name].example
    t = study.examples[name].t[1:]
    early = t <= FIRST
    words = f"What align finds of the wind, the first {FIRST:g} s of one run of {name}."
    out.figure(disturbance(t[early], example.wind_n[early, :2], example.wind_found[early], words))


def _courses(study: AlignmentStudy, case: str, methods: tuple[str, ...]) -> Plot:
    figures = study.cases[case]
    middle = {name: figures.courses[name].median for name in methods}
    high = {name: figures.courses[name].p95 for name in methods}
    return tilt_courses(figures.t, middle, high, f"{case}: {WINDS[PUBLISHED]}, {study.seeds} seeds.")


def _existence(out: Page, study: AlignmentStudy) -> None:
    out.section("Existence of the H-infinity filter")
    out.text("The filter exists where its margin is above zero. Far above, it differs little from a Kalman filter.")
    case = study.cases["s-10-10-60"]
    t = study.examples["s-10-10-60"].t[1:]
    words = f"The least margin over {study.seeds} seeds at each reading, s-10-10-60, gamma 5, every state bounded."
    out.figure(existence(t, case.margin, words))
    rows = [
        {
            "case": name,
            "least margin": one.figures["hinf"]["least_margin"],
            "steps without a filter": one.figures["hinf"]["no_filter_steps"],
        }
        for name, one in study.cases.items()
    ]
    out.table(rows, "Existence in every case.")
