"""What the alignment study must show, as values between limits: the published claim, ours, and how sure it may be."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from robustnav.evaluate.consistency import chi_square_band
from robustnav.studies.alignment import AlignmentStudy, value_of
from robustnav.studies.alignment_figures import CLAIMED_SETTLE
from robustnav.studies.alignment_setting import OURS, PUBLISHED, UNITS, Case, all_cases

SAME = 1.1  # largest ratio that counts as the same
START = "10-10-60"
TAIL = {"s": (0.9, 1.4), "h": (0.6, 1.1)}  # arcmin, median and 95 %
SETTLE = (14.0, 20.0)  # s
HEADING = (0.2, 0.55)  # deg
LATENCY = 45.0  # s until heading is known
PARTS = {"median": "median", "p95": "95 %"}
WORDS = {"tilt_arcmin": "tilt, arcmin", "settle_s": "settles, s", "heading_deg": "heading, deg"}


class Goal(NamedTuple):
    """What the study must show: a value between two limits; what never happens does so after infinity.

    ``told`` is the same figure of the filter that is told the wind, NaN where there is none.
    """

    name: str
    value: float
    low: float
    high: float
    met: bool
    told: float = float("nan")


def goals(study: AlignmentStudy) -> list[Goal]:
    """Return what the study must show, with its figures; of a selection, what its cases and methods can show."""
    parts = (_claim(study), _ours(study), _gusts(study), _winds(study), _honest(study))
    return [goal for part in parts for goal in part]


def best_fixed(study: AlignmentStudy, case: str, part: str) -> tuple[str, float]:
    """Return the single wind with the least tilt after a case's start or change, in hindsight, and that tilt."""
    fixed = study.cases[case].fixed
    name = min(fixed, key=lambda wind: fixed[wind][part])
    return name, fixed[name][part]


def tried_cases(study: AlignmentStudy) -> list[str]:
    """Return the cases in which single winds were tried, one start each: ``align`` is told of none."""
    return [name for name in our_cases(study) if study.cases[name].fixed]


def our_cases(study: AlignmentStudy) -> list[str]:
    """Return the cases with ``align``; those that differ in the start alone are the same to it."""
    cases = [case for case in all_cases() if case.name in study.cases and case.scenario.endswith(START)]
    return [case.name for case in cases if OURS in study.cases[case.name].figures]


def _claim(study: AlignmentStudy) -> Iterator[Goal]:
    for wind in (PUBLISHED, "printed"):
        case = Case(f"s-{START}", wind).name
        if not _has(study, case, ("ukf", "ukf-r1", "hinf")):
            continue
        apart = value_of(study, case, "hinf", "tilt_arcmin") - value_of(study, case, "ukf-r1", "tilt_arcmin")
        yield _goal(f"{case}, hinf settles, s", value_of(study, case, "hinf", "settle_s"), 0.0, CLAIMED_SETTLE)
        yield _goal(f"{case}, ukf settles, s", value_of(study, case, "ukf", "settle_s"), CLAIMED_SETTLE, np.inf)
        yield _goal(f"{case}, hinf less ukf-r1, tilt, arcmin", apart, -0.3, 0.3)


def _ours(study: AlignmentStudy) -> Iterator[Goal]:
    for unit in UNITS:
        case = Case(f"{unit}-{START}").name
        if not _has(study, case):
            continue
        limits = {"tilt_arcmin": TAIL[unit]} | ({"settle_s": SETTLE} if unit == "s" else {"heading_deg": HEADING})
        for figure, (middle, high) in limits.items():
            for part, limit in (("median", middle), ("p95", high)):
                name = f"{case}, align, {WORDS[figure]}, {PARTS[part]}"
                goal = _goal(name, value_of(study, case, OURS, figure, part), 0.0, limit)
                bound = figure != "settle_s" and _has(study, case, ("told",))
                yield goal._replace(told=value_of(study, case, "told", figure, part)) if bound else goal
        if unit == "s":
            share = value_of(study, case, OURS, "heading_ever_known")
            yield _goal(f"{case}, align, runs in which heading is ever called observable", share, 0.0, 0.0)
        else:
            latest = value_of(study, case, OURS, "heading_latest_known_s")
            yield _goal(f"{case}, align, heading called observable in every run from, s", latest, 0.0, LATENCY)


def _gusts(study: AlignmentStudy) -> Iterator[Goal]:
    """With gusts the same within a tenth."""
    for unit in UNITS:
        calm, blown = (Case(f"{unit}-{START}", wind).name for wind in (PUBLISHED, "gusts"))
        if not (_has(study, calm) and _has(study, blown)):
            continue
        for figure in ("tilt_arcmin", "settle_s" if unit == "s" else "heading_deg"):
            for part, words in PARTS.items():
                ratio = value_of(study, blown, OURS, figure, part) / value_of(study, calm, OURS, figure, part)
                yield _goal(f"{blown}, align, {WORDS[figure]}, over that without gusts, {words}", ratio, 0.0, SAME)


def _winds(study: AlignmentStudy) -> Iterator[Goal]:
    """No worse than the best single wind, chosen in hindsight."""
    for case in tried_cases(study):
        for part, words in PARTS.items():
            ratio = value_of(study, case, OURS, "after_arcmin", part) / best_fixed(study, case, part)[1]
            yield _goal(f"{case}, align over the best fixed wind, {words}", ratio, 0.0, SAME)


def _honest(study: AlignmentStudy) -> Iterator[Goal]:
    """Mean NEES within the 95 % band of its runs; of heading where it is called observable."""
    for case in our_cases(study):
        band = chi_square_band(2, study.seeds)
        yield _goal(f"{case}, align, NEES of tilt", value_of(study, case, OURS, "nees"), *band)
        known = int(value_of(study, case, OURS, "heading_known_runs"))
        if known:
            band = chi_square_band(1, known)
            yield _goal(f"{case}, align, NEES of heading", value_of(study, case, OURS, "heading_nees"), *band)


def _has(study: AlignmentStudy, case: str, methods: Iterable[str] = (OURS,)) -> bool:
    return case in study.cases and all(method in study.cases[case].figures for method in methods)


def _goal(name: str, value: float, low: float, high: float) -> Goal:
    value = np.inf if np.isnan(value) else value
    return Goal(name, value, low, high, bool(low <= value <= high))
