"""The report of one run: a folder with the page ``report.html`` and the numbers ``results.json``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from robustnav.evaluate.attitude import NOT_AN_ERROR, attitude_errors
from robustnav.records import Log, Run, Score, Truth
from robustnav.report import figures
from robustnav.report.drawing import Plot
from robustnav.report.page import Page, Tile
from robustnav.report.results import versions, write_results
from robustnav.report.verdict import Verdict, innovation_rows, judge

if TYPE_CHECKING:
    from robustnav.doctor.record import Diagnosis

ANGLES = ("roll", "pitch", "yaw")


def write_report(
    run: Run, score: Score | None, out: str | Path, log: Log | None = None, diagnosis: Diagnosis | None = None
) -> Path:
    """Write what ``robustnav.report.report`` promises."""
    verdict = judge(run, score, diagnosis)
    return write_results(out, _results(run, score, verdict, diagnosis), _page(run, score, verdict, log, diagnosis))


def _page(run: Run, score: Score | None, verdict: Verdict, log: Log | None, diagnosis: Diagnosis | None) -> Page:
    page = Page(f"{run.estimator} on {log.source if log else run.model}", _subtitle(run))
    page.verdict(verdict.level, verdict.text, verdict.reasons)
    page.tiles(_tiles(run, score))
    if diagnosis is not None:
        page.section("Recording")
        _add_diagnosis(page, diagnosis)
    page.section("Score")
    _add_score(page, run, score)
    page.section("Figures")
    for plot in _plots(run, log):
        page.figure(plot)
    page.section("Events")
    page.notes(run.events)
    if not run.events:
        page.text("None: no gap, no restart, no missing sample.")
    page.section("Repeat")
    settings = {name: value for name, value in run.settings.items() if name != "command"}
    page.settings(settings, versions(), str(run.settings.get("command", "")))
    return page


def _subtitle(run: Run) -> str:
    span = f", {run.t[0]:.2f} to {run.t[-1]:.2f} s" if len(run.t) else ""
    return f"Model {run.model}, {len(run.t)} samples{span}"


def _tiles(run: Run, score: Score | None) -> list[Tile]:
    tiles = []
    if score is not None:
        what = "difference" if NOT_AN_ERROR in score.notes else "error"
        for name in ("total", "heading", "inclination"):
            value = score.values.get(f"{name}_deg")
            if value is not None:
                tiles.append(Tile(f"{name.capitalize()} {what}", _three_digits(value), "deg", "RMS"))
        tiles.append(Tile("Samples scored", f"{score.samples}", "", f"of {len(run.t)}"))
    for row in innovation_rows(run.innovations):
        mean, expected = row["mean_nis"], row["expected"]
        if isinstance(mean, float):
            tiles.append(Tile(f"NIS of {row['sensor']}", _three_digits(mean), "", f"expected {expected}"))
    return tiles


def _three_digits(value: float) -> str:
    return f"{value:#.3g}".rstrip(".")


def _add_diagnosis(page: Page, diagnosis: Diagnosis) -> None:
    for level in ("error", "warning", "info"):
        rows = [
            {"finding": one.thing} | {k: getattr(one, k) for k in ("got", "expected", "do") if getattr(one, k)}
            for one in diagnosis.at(level)
        ]
        page.table(rows, {"error": "Failed checks", "warning": "Warnings", "info": "Worth knowing"}[level])
    page.text(f"Checks passed: {len(diagnosis.at('ok'))}.")


def _add_score(page: Page, run: Run, score: Score | None) -> None:
    if score is None:
        page.text("No reference: nothing is scored.")
    else:
        page.table(_score_rows(score), f"Against the reference ({score.reference}), {score.samples} samples")
        page.notes(score.notes)
    page.table(
        innovation_rows(run.innovations),
        "Innovations: NIS is their square over its prediction; a good filter has its mean near the expected value and "
        "95 % inside the two-sided band",
    )


def _score_rows(score: Score) -> list[dict[str, object]]:
    named = [(name, f"{name}_deg") for name in ("total", "heading", "inclination")]
    named += [(f"{name}, in motion", f"moving_{name}_deg") for name, _ in named]
    named += [(name, f"{name}_rms_deg") for name in ANGLES]
    rows: list[dict[str, object]] = []
    for name, key in named:
        if key in score.values:
            low, high = (score.values.get(f"{name}_{end}_deg") for end in ("min", "max"))
            rows.append({"error": name.capitalize(), "rms_deg": score.values[key], "min_deg": low, "max_deg": high})
    return rows


def _plots(run: Run, log: Log | None) -> Iterator[Plot]:
    truth = (log.truth or log.estimate) if log else None
    has_attitude = "q_nb" in run.state or "euler" in run.state
    if has_attitude:
        yield figures.attitude(run, truth)
    if has_attitude and truth is not None and truth.q_nb is not None:
        yield _error_plot(run, truth)
    for block in run.state:
        if block.endswith("_bias"):
            yield figures.bias(run, block)
    for sensor, data in run.innovations.items():
        yield figures.innovations(sensor, data, log.streams[sensor].unit if log and sensor in log.streams else "SI")
    if log and log.streams:
        yield figures.timeline(list(log.streams.values()))


def _error_plot(run: Run, truth: Truth) -> Plot:
    errors = attitude_errors(run, truth)
    if "q_nb" in run.state:
        return figures.error_band(run.t, errors.rotvec_n, run.sd.get("q_nb"))
    return figures.error_band(run.t, errors.euler, run.sd.get("euler"), tuple(name.capitalize() for name in ANGLES))


def _results(run: Run, score: Score | None, verdict: Verdict, diagnosis: Diagnosis | None) -> dict[str, object]:
    scored = None
    if score is not None:
        scored = {"reference": score.reference, "samples": score.samples, "values": score.values, "notes": score.notes}
    return {
        "estimator": run.estimator,
        "model": run.model,
        "verdict": {"level": verdict.level, "text": verdict.text, "reasons": verdict.reasons},
        "score": scored,
        "innovations": innovation_rows(run.innovations),
        "events": run.events,
        "diagnosis": diagnosis.to_dict() if diagnosis is not None else None,
        "settings": run.settings,
        "versions": versions(),
    }
