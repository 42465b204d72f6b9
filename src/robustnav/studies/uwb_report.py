"""The ranging study on paper: its page and its numbers."""

from __future__ import annotations

from pathlib import Path

from robustnav.report.figures.consistency import consistency_band
from robustnav.report.figures.ranging_error import ranging_error
from robustnav.report.figures.ranging_gates import ranging_gates
from robustnav.report.figures.ranging_histogram import ranging_histogram
from robustnav.report.figures.trajectory import Travelled, trajectory
from robustnav.report.page import Page, Tile
from robustnav.report.results import versions, write_results
from robustnav.sim.quadcopter import assumptions
from robustnav.sim.rig import hall
from robustnav.studies.goals import goal_rows, goal_verdict
from robustnav.studies.uwb import UwbStudy, doubt_rows, doubtful_seeds, goals, results, rows_of
from robustnav.studies.uwb_runs import SHARE_OF_WRONG, seeds_of
from robustnav.studies.uwb_setting import FLIGHT, scenarios


def page(study: UwbStudy, command: str) -> Page:
    """Return the study's page: what it says first, tables, figures, assumptions."""
    out = Page("Ranging study", "A quadcopter among ultra-wideband anchors: bound, outliers, outages, doubt")
    _verdict(out, study)
    _flight(out, study)
    _bound(out, study)
    _lasting(out, study)
    _robust(out, study)
    _doubt(out, study)
    rows = [{"name": a.name, "value": a.value, "why": a.why} for a in assumptions()]
    out.section("What the publication does not state")
    out.table(rows, "Every value taken beyond the published text.")
    out.section("Repeat it")
    out.settings({"seeds": study.seeds, "seed": study.seed}, versions(), command)
    return out


def write_study(study: UwbStudy, folder: str | Path, command: str) -> Path:
    """Write ``results.json`` and ``report.html`` into a folder and return the page's path.

    Raises
    ------
    InputError : the folder is a file.
    """
    return write_results(folder, results(study), page(study, command))


def _verdict(out: Page, study: UwbStudy) -> None:
    aims = goals(study)
    goal_verdict(out, aims)
    own, flight = study.own.figures, study.scenarios[FLIGHT].figures
    kidnapped = study.scenarios["kidnapped"].figures
    out.tiles(
        [
            Tile("EKF", f"{own['ekf']['rmse_3d'] / own['bound']['rmse_3d']:.3f}", "x bound", "Gaussian ranges"),
            Tile("20 % outliers", f"{aims[2].value:.2f}", "x outlier-free", "student"),
            Tile(
                "kidnapped", f"{kidnapped['student'].get('recovery_max_s', 0.0):.2f}", "s", "slowest recovery, student"
            ),
            Tile("flight", f"{flight['student']['rmse_3d']:.3f}", "m", "RMS in space, student"),
            Tile("runs", str(study.seeds), "a scenario", "independent seeds"),
        ]
    )
    out.table(goal_rows(aims), "What the study must show.")


def _flight(out: Page, study: UwbStudy) -> None:
    outcome, scenario = study.scenarios[FLIGHT], scenarios()[FLIGHT]
    out.section("The flight")
    out.text(
        "The published system is a range line fitted beforehand, a filter on position and velocity, and a test of "
        "each range against 8.8 predicted variances; it never starts again. Trilateration solves each round by itself."
    )
    out.table(rows_of(outcome.figures), f"{scenario.words}; {seeds_of(scenario, study.seeds)} seeds; expected NEES 3.")
    run, truth = outcome.examples["student"]
    sd = run.sd["p_n"]
    way = Travelled(run.state["p_n"], truth, sd, hall().p_a)
    out.figure(trajectory(way, "One flight, student, started without a prior."))
    out.figure(ranging_gates(run.innovations["range"], "What the student filter made of each range of the flight."))
    out.figure(ranging_histogram(run.innovations["range"], "Innovations of the same flight."))


def _bound(out: Page, study: UwbStudy) -> None:
    own = study.own
    out.section("Gaussian ranges, tracks of the filter's own model")
    out.table(
        rows_of(own.figures), f"{study.seeds} seeds, 10 s in the hall, known start distribution; expected NEES 3."
    )
    words = "RMS over seeds and the posterior Cramer-Rao bound, averaged over the true tracks."
    out.figure(ranging_error(own.t, own.rms, own.bound, words))
    out.figure(consistency_band(own.t, own.values["ekf"], 3, "NEES of the position, ekf"))


def _lasting(out: Page, study: UwbStudy) -> None:
    out.section("Ranges whose errors last")
    out.text(
        "Antennas and multipath make errors that stay for seconds. A filter that takes them for white noise of the "
        "same size is nearly as accurate, but believes itself too much; one that estimates them is consistent."
    )
    out.table(rows_of(study.coloured.figures), f"{study.seeds} seeds, sd 0.12 m with a time constant of 3 s.")
    for name in ("white noise", "biased"):
        out.figure(consistency_band(study.coloured.t, study.coloured.values[name], 3, f"NEES of the position, {name}"))


def _robust(out: Page, study: UwbStudy) -> None:
    out.section("Outliers, outages, a kidnapped tag")
    out.text(
        "All filters start without a prior. Lost: an error above 1 m for more than 2 s while ranges come. "
        "Recovery: from the return of ranges until the error stays below 0.5 m for a second. The two seconds after the "
        "return are not in the RMS. Found and slowest: the median and the largest recovery."
    )
    for name, outcome in study.scenarios.items():
        if name != FLIGHT:
            out.table(rows_of(outcome.figures), f"{name}: {scenarios()[name].words}; {study.seeds} seeds.")


def _doubt(out: Page, study: UwbStudy) -> None:
    out.section("Layouts that leave doubt")
    out.text(
        "Where ranges do not tell a position, a filter must refuse or say so. Wrong: a run whose error exceeds "
        f"{SHARE_OF_WRONG:g} of its own standard deviations at any time. The last layout is beyond what is promised."
    )
    out.table(doubt_rows(study), f"{doubtful_seeds(study.seeds)} seeds a layout, Gaussian ranges.")
