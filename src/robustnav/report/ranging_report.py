"""Pages of the ranging verbs: a calibration of ranges, a layout of anchors; rows for their tables."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from robustnav.calibrate import BiasCurve, Pairs, RangeCalibration, RangeLine, held_out
from robustnav.calibrate.ranges import FIELDS
from robustnav.errors import InputError
from robustnav.evaluate.tables import plain
from robustnav.files import write_whole
from robustnav.records import Anchors, Array
from robustnav.report.figures.gdop_map import gdop_map
from robustnav.report.figures.residual_ranges import residual_ranges
from robustnav.report.page import Page, Tile
from robustnav.report.results import versions
from robustnav.survey.layout import BAD, POOR, Flight, Plan, figures_of

LEVEL = 0.95
FOLDS = 10


@dataclass(frozen=True)
class Calibrated:
    """A calibration with the pairs it was fitted to.

    Parameters
    ----------
    pairs, calibration : what was fitted to what.
    fit : the fit of one group, to repeat on files left out.
    notes : what was left out of the files.
    command : to repeat it.
    """

    pairs: Pairs
    calibration: RangeCalibration
    fit: partial[RangeLine] | partial[BiasCurve]
    notes: tuple[str, ...] = ()
    command: str = ""


def calibration_rows(done: Calibrated) -> list[dict[str, object]]:
    """Return one row for each correction: coefficients with 95 % intervals, variances, outliers, error held out."""
    rows = []
    for key, correction in done.calibration.corrections.items():
        here = done.pairs.where(rows_of(done.pairs, done.calibration.by, key))
        row: dict[str, object] = {"for": "-".join(key) or "all", "readings": len(here)}
        fitted = correction.fitted
        if isinstance(correction, RangeLine):
            row |= {"slope": correction.slope, "offset_m": correction.offset}
            ends = correction.intervals(LEVEL)
            row |= {f"{name}_interval": list(ends[name]) for name in ("slope", "offset", "range_variance")}
            row |= {"distance_variance_m2": correction.variance}
        else:
            row |= {"knots_m": list(correction.knots), "bias_m": list(correction.bias)}
        row |= {"range_variance_m2": correction.range_variance, "outliers": fitted.outliers if fitted else None}
        row |= {"raw_rms_m": float(np.sqrt(np.mean((here.measured - here.distance_true) ** 2)))}
        row |= {"held_out_rms_m": _held_out(here, done.fit)}
        rows.append(row)
    return rows


def shown_calibration(rows: list[dict[str, object]]) -> list[dict[str, object]]:
    """Return the rows of lines for people to read: digits as the intervals deserve them, sds in place of variances."""
    out = []
    for row in rows:
        shown: dict[str, object] = {"for": row["for"], "readings": row["readings"]}
        if "slope" in row:
            shown |= {"slope_a": f"{row['slope']:.5f}", "slope_95_%": _interval(row["slope_interval"], 5)}
            shown |= {"offset_b_m": f"{row['offset_m']:.4f}", "offset_95_%": _interval(row["offset_interval"], 3)}
            shown |= {"sigma²_m²": f"{row['range_variance_m2']:.3e}"}
            shown |= {"sigma²_95_%": _interval(row["range_variance_interval"], 5)}
            shown |= {"R_m²": f"{row['distance_variance_m2']:.3e}"}
        else:
            pairs = np.column_stack([np.asarray(row["knots_m"], float), np.asarray(row["bias_m"], float)])
            shown |= {"bias_at_knots_m": ", ".join(f"{r:.1f}: {b:+.3f}" for r, b in pairs)}
            shown |= {"sigma²_m²": f"{row['range_variance_m2']:.3e}"}
        shown |= {name: row[name] for name in ("outliers", "raw_rms_m", "held_out_rms_m")}
        out.append(shown)
    return out


def rows_of(pairs: Pairs, by: str, key: tuple[str, ...]) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return which pairs (n,) a key of a calibration is for."""
    keep = np.ones(len(pairs), bool)
    for field, name in zip(FIELDS[by], key, strict=True):
        keep &= getattr(pairs, field) == name
    return keep


def corrected(pairs: Pairs, calibration: RangeCalibration) -> Array:
    """Return the calibrated distances (n,) [m] of all pairs."""
    out = np.empty(len(pairs))
    for key, correction in calibration.corrections.items():
        rows = rows_of(pairs, calibration.by, key)
        out[rows] = correction.distance(pairs.measured[rows])
    return out


def write_calibration_report(done: Calibrated, out: str | Path) -> Path:
    """Write ``report.html`` and ``results.json`` of a calibration into a folder and return the page's path.

    Raises
    ------
    InputError : ``out`` is a file.
    MissingExtra : matplotlib is not installed.
    """
    rows = calibration_rows(done)
    count = len(done.calibration.corrections)
    title = f"Calibration of ranges: {count} correction{'s' if count > 1 else ''} by {done.calibration.by}"
    page = Page(title, f"{len(done.pairs)} ranges, {done.calibration.source}")
    rest = corrected(done.pairs, done.calibration) - done.pairs.distance_true
    raw = done.pairs.measured - done.pairs.distance_true
    page.tiles(
        [Tile("Before", f"{_rms(raw):.3f}", "m", "RMS"), Tile("After", f"{_rms(rest):.3f}", "m", "RMS, same ranges")]
    )
    page.table(shown_calibration(rows), "r = a d + b; sigma² of a range, R = sigma²/a² of a calibrated distance")
    page.figure(residual_ranges(done.pairs, rest + done.pairs.distance_true, done.calibration))
    page.notes(done.notes)
    page.settings({}, versions(), done.command)
    return _write(out, page, {"corrections": rows, "notes": done.notes})


def layout_rows(plan: Plan) -> list[dict[str, object]]:
    """Return the numbers of a layout's maps, one row each."""
    maps = {"GDOP": plan.dop.gdop, "HDOP": plan.dop.hdop, "VDOP": plan.dop.vdop}
    if plan.one_out is not None:
        maps |= {"GDOP, worst anchor missing": plan.one_out.gdop, "HDOP, worst anchor missing": plan.one_out.hdop}
    rows = []
    for name, values in maps.items():
        if not np.isnan(values).all():
            of = figures_of(values)
            row = {"map": name, "median": of.median, "worst": of.worst}
            row |= {f"beyond_{POOR:g}_percent": 100 * of.beyond_20, f"beyond_{BAD:g}_percent": 100 * of.beyond_50}
            rows.append(row | {"blind_percent": 100 * of.blind})
    return rows


def layout_verdict(plan: Plan, flight: Flight) -> tuple[str, str]:
    """Return the level and the words of the verdict on a layout."""
    shares = ", ".join(f"{100 * share:.0f} % {verdict}" for verdict, share in plan.verdicts.items())
    unique = plan.verdicts.get("unique", 0.0)
    level = "ok" if unique == 1.0 else "warning" if unique >= 0.5 else "error"
    words = f"A single fix with a range sd of {flight.sd:g} m is {shares}"
    if plan.verdicts.get("ambiguous") and not flight.sensing.height_known:
        words += f"; the anchors lie within {plan.flatness:.2f} m rms of a plane, which mirrors the tag"
    return level, words + "."


def extra_words(plan: Plan) -> str:
    """Say where one more anchor helps most."""
    x, y, z = plan.extra
    before, after = plan.extra_gdop
    place = f"x {x:.1f}, y {y:.1f} m in frame a, {0.0 - z:.1f} m high"
    blind = plan.extra_blind
    seen = f", blind {100 * blind[0]:.0f} to {100 * blind[1]:.0f} %" if blind[0] else ""
    return f"One more anchor helps most at {place}: mean GDOP {before:.1f} to {after:.1f}{seen}."


def layout_document(plan: Plan, flight: Flight) -> dict[str, object]:
    """Return the numbers of a layout for JSON."""
    level, words = layout_verdict(plan, flight)
    return {
        "height_m": -flight.z,
        "range_sd_m": flight.sd,
        "verdict": {"level": level, "text": words, "shares": plan.verdicts},
        "maps": [{k: _finite(v) for k, v in row.items()} for row in layout_rows(plan)],
        "flatness_m": plan.flatness,
        "one_more_anchor": {
            "p_a_m": plan.extra,
            "mean_gdop_before": _finite(plan.extra_gdop[0]),
            "mean_gdop_with": _finite(plan.extra_gdop[1]),
            "blind_before": plan.extra_blind[0],
            "blind_with": plan.extra_blind[1],
        },
    }


def write_layout_report(anchors: Anchors, plan: Plan, flight: Flight, out: str | Path, command: str = "") -> Path:
    """Write ``report.html`` and ``results.json`` of a layout into a folder and return the page's path.

    Raises
    ------
    InputError : ``out`` is a file.
    MissingExtra : matplotlib is not installed.
    """
    page = Page(f"Layout of {len(anchors.ids)} anchors at a height of {-flight.z:g} m", _sensed(flight))
    level, words = layout_verdict(plan, flight)
    page.verdict("ok" if level == "ok" else "warning" if level == "warning" else "error", words, [extra_words(plan)])
    page.table(layout_rows(plan), "Dilution of precision over the map")
    maps = {"GDOP": plan.dop.gdop, "HDOP": plan.dop.hdop, "VDOP": plan.dop.vdop}
    if plan.one_out is not None:
        maps["GDOP with the worst anchor missing"] = plan.one_out.gdop
    for name, values in maps.items():
        if not np.isnan(values).all():
            extra = plan.extra if name == "GDOP" else None
            page.figure(gdop_map((plan.x, plan.y), values, anchors, f"{name} at {-flight.z:g} m", extra))
    page.settings({"range_sd_m": flight.sd, "grid_m": flight.grid}, versions(), command)
    return _write(out, page, layout_document(plan, flight))


def _sensed(flight: Flight) -> str:
    kind = "Ranges" if flight.sensing.kind == "ranges" else "Range differences"
    return f"{kind}, height {'known' if flight.sensing.height_known else 'not known'}"


def _write(out: str | Path, page: Page, results: Mapping[str, object]) -> Path:
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise InputError("report", place=str(out), got="a file", expected="a folder, or a name that is free")
    # both texts are made before either is written: a failure leaves no half report
    text, html = json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False), page.html()
    write_whole(folder / "results.json", text + "\n")
    return write_whole(folder / "report.html", html)


def _held_out(pairs: Pairs, fit: partial[RangeLine] | partial[BiasCurve]) -> float | None:
    """Return the error on files left out of the fit [m], or None where there are too few."""
    if pairs.file is None:
        return None
    try:
        return held_out(pairs, fit, folds=FOLDS).rms
    except InputError:  # too few files for a fit without some of them
        return None


def _interval(ends: object, digits: int) -> str:
    low, high = np.asarray(ends, float)
    return f"{low:.{digits}f} .. {high:.{digits}f}"


def _finite(value: object) -> object:
    """Return None for an infinite number, which JSON does not know."""
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _rms(e: Array) -> float:
    return float(np.sqrt(np.mean(e**2)))
