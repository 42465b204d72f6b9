"""Verbs on ranging systems before they fly: ``calibrate uwb``, ``gdop``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from robustnav.cli.options import Flag
from robustnav.cli.show import note, say, say_json, say_table
from robustnav.errors import InputError

if TYPE_CHECKING:
    from robustnav.calibrate import BiasCurve, RangeLine
    from robustnav.survey.layout import Box

calibrate = App(name="calibrate", help="Fit sensor errors to recordings.")


@calibrate.command
def uwb(
    files: list[Path],
    /,
    *,
    per: Literal["all", "anchor", "link"] = "all",
    robust: Annotated[bool, Parameter(negative="--ols")] = True,
    curve: Flag = False,
    out: Path | None = None,
    report: Path | None = None,
    json: Flag = False,
) -> None:
    """Fit the range line r = a d + b, or a bias curve, to ranges with known true distances.

    Parameters
    ----------
    files
        Folders of the HYU static set, or tables with distance_m, distance_true_m and, if told, anchor and tag.
        Each table counts as recorded in one go.
    per
        One correction for all, for each anchor, or for each anchor and tag.
    robust
        Robust against gross errors (Huber), or the published least squares.
    curve
        Fit a bias curve, its knots chosen by files left out; needs several files.
    out
        TOML file for the calibration.
    report
        Folder for report.html, with a figure of the residuals, and results.json.
    json
        Print one JSON document.
    """
    from robustnav.calibrate import HUBER, LEAST_SQUARES, calibrate_ranges, choose_curve, fit_line, write_calibration
    from robustnav.calibrate.bias_curve import fit_curve
    from robustnav.cli.ranging_files import read_true_ranges
    from robustnav.report import ranging_report as pages

    found = read_true_ranges(files)
    chosen = HUBER if robust else LEAST_SQUARES
    source = f"{len(found.files)} file{'s' if len(found.files) > 1 else ''}: {', '.join(found.files[:3])}" + (
        " ..." if len(found.files) > 3 else ""
    )
    fit: partial[RangeLine] | partial[BiasCurve] = partial(fit_line, loss=chosen)
    if curve:
        # the same knots for every group, so that the error held out is that of one choice
        knots = choose_curve(found.pairs, chosen).curve.knots
        fit = partial(fit_curve, knots=knots, loss=chosen)
    calibration = calibrate_ranges(found.pairs, per, fit, source)
    command = (
        f"robustnav calibrate uwb {' '.join(map(str, files))} --per {per}"
        + " --ols" * (not robust)
        + " --curve" * curve
    )
    done = pages.Calibrated(found.pairs, calibration, fit, found.notes, command)
    rows = pages.calibration_rows(done)
    if out is not None:
        write_calibration(calibration, out)
        note(f"calibration: {out}")
    if report is not None:
        note(f"report: {pages.write_calibration_report(done, report)}")
    for line in found.notes:
        note(line)
    if json:
        say_json({"by": per, "loss": chosen.kind, "corrections": rows, "notes": found.notes})
        return
    say_table(f"{len(found.pairs)} ranges, {source}", pages.shown_calibration(rows))
    if found.pairs.file is None:
        note("one file: intervals are those of independent readings; give each set-up as a file of its own")
    if out is None:
        note("next: --out calibration.toml writes what a run takes")


@Parameter(name="*")
@dataclass(frozen=True)
class Place:
    """Where the tag is to be found, and how."""

    height: float
    """Height of the tag above the survey's zero, metres, upwards whichever way the file counts."""
    box: str | None = None
    """x0,x1,y0,y1 in metres in frame a (z down, y to the right of x); default: the anchors' rectangle."""
    grid: float = 0.25
    """Distance of the points of the map, metres."""
    sd: float = 0.1
    """Standard deviation of a range, metres, for the verdict on single fixes."""
    known_height: Flag = False
    """The height is measured by something else: only x and y are sought."""
    tdoa: Flag = False
    """Differences of ranges in place of ranges."""


def gdop(anchors: Path, place: Place, *, out: Path | None = None, json: Flag = False) -> None:
    """Say how good a layout of anchors is before flying: dilution of precision, mirror images, one anchor missing.

    Parameters
    ----------
    anchors
        Survey in TOML: z, and [[anchor]] tables.
    place
        Where the tag is to be found.
    out
        Folder for report.html, with the maps, and results.json.
    json
        Print one JSON document.
    """
    from robustnav.logs.uwb_survey import read_survey
    from robustnav.report import ranging_report as pages
    from robustnav.snapshot import Sensing
    from robustnav.survey.layout import Flight, plan_layout

    surveyed = read_survey(anchors)[0]
    sensing = Sensing("differences" if place.tdoa else "ranges", place.known_height)
    flight = Flight(-place.height, _box(place.box), place.grid, place.sd, sensing)
    plan = plan_layout(surveyed, flight)
    if out is not None:
        command = f"robustnav gdop {anchors} --height {place.height:g} --grid {place.grid:g} --sd {place.sd:g}"
        note(f"report: {pages.write_layout_report(surveyed, plan, flight, out, command)}")
    if json:
        say_json(pages.layout_document(plan, flight))
        return
    say(pages.layout_verdict(plan, flight)[1])
    say_table(f"Dilution of precision at {place.height:g} m", pages.layout_rows(plan))
    say()
    say(pages.extra_words(plan))
    if out is None:
        note(f"next: robustnav gdop {anchors} --height {place.height:g} --out out/layout, for the maps")


def _box(text: str | None) -> Box | None:
    from robustnav.survey.layout import Box

    if text is None:
        return None
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 4:
        raise InputError("--box", got=repr(text), expected="four numbers x0,x1,y0,y1 as in 0,10,0,8")
    return Box(*numbers)
