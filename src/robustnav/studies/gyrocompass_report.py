"""The gyrocompass study on paper: its page and its numbers."""

from __future__ import annotations

from pathlib import Path

from robustnav.evaluate.consistency import chi_square_band
from robustnav.report.figures.gyrocompass import heading_by_grade
from robustnav.report.page import Level, Page, Tile
from robustnav.report.results import versions, write_results
from robustnav.studies.gyrocompass import GyrocompassStudy, afloat_rows, outside_bands, results, standing_rows
from robustnav.units import DEG


def page(study: GyrocompassStudy, command: str) -> Page:
    """Return the study's page: what it says first, the base at rest, the boat with a compass."""
    out = Page("Gyrocompass study", "North by the Earth's rotation on a base at rest, and by a compass where it is not")
    _verdict(out, study)
    out.section("At rest")
    out.text(
        "align is told that the velocity is zero, nothing of attitude. Coarse gyrocompassing averages gyro and "
        "accelerometer: it is as good as can be where nothing turns, and of no use where an engine shakes the base."
    )
    for seconds in dict.fromkeys(row.seconds for row in study.standing):
        rows = [row for row in study.standing if row.seconds == seconds]
        values = {
            "align": [row.rms_deg for row in rows],
            "Claimed": [row.claimed_deg for row in rows],
            "Coarse": [row.peer_rms_deg for row in rows],
            "Bound, velocity zero": [row.velocity_bound_deg for row in rows],
        }
        words = f"Rms of the heading error after {seconds:g} s, {study.seeds} seeds a case."
        cases = [f"{row.grade}\n{row.base}" for row in rows]
        out.figure(heading_by_grade(cases, values, "Bound, velocity zero", words))
    out.table(standing_rows(study), f"Heading of a base at rest, {study.seeds} seeds a row.")
    out.section("A boat in the wind")
    out.text("With a compass of 2 degrees constant error and 1 degree of noise, and without.")
    out.table(afloat_rows(study), f"Heading after a minute, {study.seeds} seeds a row.")
    out.section("Repeat it")
    out.settings({"seeds": study.seeds, "seed": study.seed}, versions(), command)
    return out


def write_study(study: GyrocompassStudy, folder: str | Path, command: str) -> Path:
    """Write ``results.json`` and ``report.html`` into a folder and return the page's path; errors of both."""
    return write_results(folder, results(study), page(study, command))


def _verdict(out: Page, study: GyrocompassStudy) -> None:
    odd = outside_bands(study)
    level: Level = "warning" if odd else "ok"
    low, high = chi_square_band(1, study.seeds)
    many = len(study.standing) + len(study.afloat)
    words = f"{many - len({line.split(':')[0] for line in odd})} of {many} cases claim no more than is true."
    out.verdict(level, words, odd)
    best = min(study.standing, key=lambda row: row.rms_deg)
    out.tiles(
        [
            Tile("best heading", f"{best.rms_deg:.2f}", "deg", f"{best.grade}, {best.base}, {best.seconds:g} s"),
            Tile("its bound", f"{best.velocity_bound_deg:.2f}", "deg", "velocity zero, nothing else known"),
            Tile("NEES band", f"{low:.2f} to {high:.2f}", "", "heading, 95 %"),
            Tile("runs", str(study.seeds), "a case", f"half a radian is {0.5 / DEG:.0f} deg: not observable beyond"),
        ]
    )
