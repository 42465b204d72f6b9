"""The report of one alignment: ``report.html``, ``results.json`` and ``alignment.csv`` in a folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from robustnav.frames import euler_from_quat
from robustnav.report.alignment_course import (
    ONE_AXIS_95,
    RADIUS_95,
    Aligned,
    angle_rows,
    arcmin,
    bias_rows,
    gyro_unit,
    heading_words,
    judge,
    truth_row,
)
from robustnav.report.drawing import Plot
from robustnav.report.figures.alignment import bias_courses, heading_course, tilt_radius, wind_course
from robustnav.report.figures.route import route
from robustnav.report.page import Page, Tile
from robustnav.report.results import versions, write_results
from robustnav.units import ARCMIN, DEG

WIND_SECONDS = 60.0  # the last ones are drawn


def write_alignment(run: Aligned, out: str | Path) -> Path:
    """Write page, numbers and table of an alignment into a folder and return the page's path.

    Equal arguments give equal bytes.

    Raises
    ------
    InputError : ``out`` is a file, or a setting has no plain form.
    MissingExtra : matplotlib is not installed.
    """
    return write_results(out, document(run), page(run), {"alignment.csv": alignment_table(run)})


def document(run: Aligned) -> dict[str, object]:
    """Return the numbers of an alignment for JSON."""
    said, (level, text, reasons) = run.said, judge(run)
    final = {str(row["angle"]): {k: v for k, v in row.items() if k != "angle"} for row in angle_rows(run)}
    return {
        "source": run.source,
        "verdict": {"level": level, "text": text, "reasons": reasons},
        "aligned_after_s": run.waited,
        "aligned_at_s": said.aligned_at,
        "duration_s": run.duration,
        "tilt_goal_arcmin": said.tilt_goal / ARCMIN,
        "reference_readings": int((~np.isnan(run.reference).any(axis=1)).sum()),
        "final": {
            "t_s": said.t[-1],
            "q_nb": said.q_nb[-1],
            **final,
            "tilt_95_arcmin": said.tilt_radius[-1] / ARCMIN,
            "gyro_bias_rad_s": said.gyro_bias[-1],
            "accel_bias_m_s2": said.accel_bias[-1],
            **({"wind_m_s": said.wind[-1]} if run.route is None else {"p_n_m": run.route.p_n[-1]}),
        },
        "heading_observable": bool(said.heading_observable[-1]),
        "heading_floor_deg": run.heading_floor / DEG,
        "tilt_floor_95_arcmin": RADIUS_95 * run.tilt_floor / ARCMIN,
        "wind": run.wind or None,
        "errors": truth_row(run) or None,
        "events": run.events,
        "settings": run.settings,
        "versions": versions(),
    }


def alignment_table(run: Aligned) -> str:
    """Return what was said over time as CSV, one row a reading, the unit in every name; an empty cell is no answer."""
    said = run.said
    heading = np.where(said.heading_observable, said.heading_sd, np.nan)
    columns = {
        "t_s": said.t,
        **{f"q_nb_{axis}": said.q_nb[:, k] for k, axis in enumerate("wxyz")},
        **{
            f"{n}_deg": v / DEG for n, v in zip(("roll", "pitch", "heading"), euler_from_quat(said.q_nb).T, strict=True)
        },
        "tilt_95_arcmin": said.tilt_radius / ARCMIN,
        "heading_95_deg": ONE_AXIS_95 * heading / DEG,
        **{f"gyro_bias_{axis}_rad_s": said.gyro_bias[:, k] for k, axis in enumerate("xyz")},
        **{f"accel_bias_{axis}_m_s2": said.accel_bias[:, k] for k, axis in enumerate("xyz")},
    }
    if run.route is None:
        columns |= {f"wind_{axis}_m_s": said.wind[:, k] for k, axis in enumerate(("north", "east"))}
    else:
        columns |= {f"p_n_{axis}_m": run.route.p_n[:, k] for k, axis in enumerate("xyz")}
    rows = np.column_stack(list(columns.values()))
    lines = (",".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in rows)
    return ",".join(columns) + "\n" + "\n".join(lines) + "\n"


def page(run: Aligned) -> Page:
    """Return the page of an alignment: verdict, key figures, course, what was found, how to repeat it."""
    level, text, reasons = judge(run)
    readings = int((~np.isnan(run.reference).any(axis=1)).sum())
    out = Page(
        f"Alignment of {run.source}", f"{run.duration:.1f} s, {len(run.said.t)} periods, {readings} reference readings"
    )
    out.verdict(level, text[:1].upper() + text[1:], reasons)
    out.tiles(list(_tiles(run)))
    out.section("Attitude")
    out.table(
        angle_rows(run),
        "At the end, each within the second number with 95 %. A heading is given where it is observable.",
    )
    for plot in _attitude(run):
        out.figure(plot)
    if run.route is not None:
        out.section("Route")
        out.figure(route(run.route.p_n, run.route.fixes, run.route.p_true, "Where the carrier was, from above."))
    else:
        out.section("Reference velocity")
        out.text(run.wind_words or "Not described: no reference velocity, or less than twelve seconds of it.")
        if not np.isnan(run.reference).all():
            out.figure(_wind(run))
    out.section("Biases")
    out.table(bias_rows(run), "At the end, body axes.")
    out.figure(_biases(run))
    out.section("Events")
    out.notes(run.events)
    if not run.events:
        out.text("None: no gap, no repeated stamp, no reading left out.")
    out.section("Repeat")
    out.settings(run.settings, versions(), run.command)
    return out


def _tiles(run: Aligned) -> Iterator[Tile]:
    said, errors = run.said, truth_row(run)
    never = np.isnan(run.waited)
    name, remark = ("Aligned after", "tilt goal met") if run.route is None else ("Heading found after", "of motion")
    yield Tile(name, "never" if never else f"{run.waited:.1f}", "" if never else "s", remark)
    value, unit = arcmin(said.tilt_radius[-1]).split()
    yield Tile("Tilt within", value, unit, "95 %, at the end")
    if said.heading_observable[-1]:
        yield Tile(
            "Heading", f"{said.heading[-1] / DEG:.2f}", "deg", f"± {ONE_AXIS_95 * said.heading_sd[-1] / DEG:.2f}, 95 %"
        )
    else:
        yield Tile("Heading", "open", "", heading_words(run).partition(": ")[2])
    if errors:
        yield Tile("True tilt error", f"{errors['tilt_rms_arcmin']:#.3g}", "arcmin", "rms, last quarter")
    if "heading_rms_deg" in errors:
        yield Tile("True heading error", f"{errors['heading_rms_deg']:#.3g}", "deg", "rms, last quarter")


def _attitude(run: Aligned) -> Iterator[Plot]:
    said, truth = run.said, run.against
    yield tilt_radius(said.t, said.tilt_radius, said.tilt_goal, None if truth is None else truth.tilt)
    true = None if truth is None else truth.heading
    yield heading_course(said.t, said.heading, said.heading_sd, said.heading_observable, true)


def _wind(run: Aligned) -> Plot:
    late = run.said.t > run.said.t[-1] - WIND_SECONDS
    true = None if run.against is None or run.against.wind is None else run.against.wind[late]
    return wind_course(run.said.t[late], run.reference[late], run.said.wind[late], true)


def _biases(run: Aligned) -> Plot:
    said, truth = run.said, run.against
    gyro = said.gyro_bias, None if truth is None else truth.gyro_bias
    accel = said.accel_bias, None if truth is None else truth.accel_bias
    return bias_courses(said.t, gyro, accel, gyro_unit(run.gyro_bias_sd))
