"""Verbs on recordings: ``doctor``, ``run``, ``compare``, ``report``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from robustnav.cli.options import KIT, Flag, Kit, split
from robustnav.cli.show import note, progress, say, say_json, say_settings, say_table
from robustnav.cli.tracking import RANGING, Ranging, run_ranges

if TYPE_CHECKING:
    from robustnav.doctor.record import Diagnosis, Finding
    from robustnav.records import Log, Run, Score, Truth

Backend = Literal["auto", "c", "float", "numpy"]
MARKS = {"ok": "ok     ", "info": "note   ", "warning": "warning", "error": "ERROR  "}


def doctor(log: Path, *, mapping: Path | None = None, strict: Flag = False, json: Flag = False) -> int:
    """Say what is in a recording and what is suspicious: rates, gaps, units, signs, frames.

    Exits 2 when something would poison an estimator.

    Parameters
    ----------
    log
        PX4 .ulg, BROAD .mat or .csv.
    mapping
        TOML file naming columns, units and frames of a foreign table.
    strict
        Let warnings count as errors.
    json
        Print one JSON document.
    """
    recording = _read(log, mapping)
    diagnosis = _diagnosis(recording)
    bad = diagnosis.worst == "error" or (strict and diagnosis.worst == "warning")
    if json:
        say_json(diagnosis.to_dict())
        return 2 if bad else 0
    say(recording.source)
    for line in (*recording.conventions, *(f"skipped: {s}" for s in recording.skipped)):
        say(f"  {line}")
    say()
    for finding in diagnosis.findings:
        _say_finding(finding)
    counts = {level: len(diagnosis.at(level)) for level in ("error", "warning")}
    say(f"\n{counts['error']} errors, {counts['warning']} warnings")
    say(f"next: robustnav run {log} --estimator mekf" if not bad else "mend the errors before running a filter")
    return 2 if bad else 0


def run(
    log: Path,
    *,
    estimator: str = "h2",
    kit: Kit = KIT,
    ranging: Ranging = RANGING,
    mapping: Path | None = None,
    backend: Backend = "auto",
    out: Path | None = None,
    json: Flag = False,
) -> int:
    """Run one attitude estimator over a recording and score it; with --anchors, follow a tag through its ranges.

    It is scored against the recording's truth, or compared with the recorder's own estimate and called a difference.

    Parameters
    ----------
    log
        PX4 .ulg, BROAD .mat or .csv.
    estimator
        h2, mekf, ukf, h2-euler or ekf-euler.
    kit
        What recorded it.
    ranging
        Ranges instead of an inertial recording.
    mapping
        TOML file naming columns, units and frames of a foreign table.
    backend
        Compiled in double or float, NumPy, or what is there.
    out
        Folder for report.html, results.json and estimate.csv.
    json
        Print one JSON document.
    """
    if ranging.anchors is not None:
        return run_ranges(log, ranging, backend=backend, out=out, json=json)
    from robustnav.report import report as write_report
    from robustnav.report.verdict import innovation_rows, judge
    from robustnav.run.recorded import Sensors, run_recorded

    recording = _read(log, mapping)
    diagnosis = _diagnosis(recording)
    result = run_recorded(estimator, recording, Sensors(kit.imu, kit.magnetometer), backend=backend)
    score = _score(result, recording)
    verdict = judge(result, score, diagnosis)
    if out is not None:
        from robustnav.report.run_table import write_run

        page = write_report(result, score, out, log=recording, diagnosis=diagnosis)
        write_run(result, out / "estimate.csv")
        note(f"report: {page}")
    if json:
        say_json(_run_document(result, score, verdict.level))
        return 0
    for finding in diagnosis.at("error"):
        note(f"doctor: {finding.thing}: got {finding.got}, expected {finding.expected}")
    say(f"{result.estimator} on {recording.source}: {verdict.text}")
    if score is not None:
        say_table(f"{score.estimator} against the {score.reference}", [_score_row(score)])
        for line in score.notes:
            say(f"  {line}")
    say_table("Innovations", innovation_rows(result.innovations))
    for event in result.events:
        say(f"  {event}")
    say("\nSettings")
    say_settings(result.settings)
    if out is None:
        note(f"next: robustnav run {log} --estimator {estimator} --out out/run, for a page with figures")
    return 0


def compare(
    logs: list[Path],
    /,
    *,
    estimators: str = "h2,mekf",
    kit: Kit = KIT,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Run several estimators over several recordings and show their scores side by side.

    Parameters
    ----------
    logs
        Recordings.
    estimators
        Names with commas: h2, mekf, ukf, h2-euler, ekf-euler.
    kit
        What recorded it.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    from robustnav.run.recorded import Sensors, run_recorded

    names = split(estimators)
    rows: list[dict[str, object]] = []
    with progress("comparing", len(logs) * len(names), quiet=quiet) as step:
        for path in logs:
            recording = _read(path, None)
            for name in names:
                score = _score(run_recorded(name, recording, Sensors(kit.imu, kit.magnetometer)), recording)
                row: dict[str, object] = {"log": path.name, "estimator": name}
                rows.append(row | (_score_row(score) if score else {"reference": "none"}))
                step()
    if json:
        say_json({"rows": rows})
    else:
        say_table("Attitude, degrees", rows)


def report(log: Path, *, estimator: str = "h2", out: Path = Path("out/run"), kit: Kit = KIT, json: Flag = False) -> int:
    """Run one estimator over a recording and write its page: the same as ``run`` with ``--out``.

    Parameters
    ----------
    log
        PX4 .ulg, BROAD .mat or .csv.
    estimator
        h2, mekf, ukf, h2-euler or ekf-euler.
    out
        Folder for report.html, results.json and estimate.csv.
    kit
        What recorded it.
    json
        Print one JSON document.
    """
    return run(log, estimator=estimator, out=out, kit=kit, json=json)


def _read(path: Path, mapping: Path | None) -> Log:
    from robustnav.logs.reading import read

    return read(path, mapping)


def _diagnosis(log: Log) -> Diagnosis:
    from robustnav.doctor.examine import examine

    return examine(log)


def reference_of(log: Log) -> Truth | None:
    """Return what a run is held against: the truth, else the recorder's own estimate."""
    return log.truth if log.truth is not None and log.truth.q_nb is not None else log.estimate


def _score(result: Run, log: Log) -> Score | None:
    from robustnav.evaluate.attitude import evaluate

    reference = reference_of(log)
    return None if reference is None else evaluate(result, reference)


def _score_row(score: Score) -> dict[str, object]:
    names = ("total_deg", "heading_deg", "inclination_deg", "roll_rms_deg", "pitch_rms_deg", "yaw_rms_deg")
    row: dict[str, object] = {name: score.values.get(name) for name in names}
    if "moving_total_deg" in score.values:
        row["moving_total_deg"] = score.values["moving_total_deg"]
    return row | {"samples": score.samples, "reference": score.reference.split(",")[0]}


def _run_document(result: Run, score: Score | None, verdict: str) -> dict[str, object]:
    from robustnav.report.verdict import innovation_rows

    return {
        "estimator": result.estimator,
        "model": result.model,
        "verdict": verdict,
        "samples": len(result.t),
        "score": None if score is None else {**score.values, "samples": score.samples, "reference": score.reference},
        "notes": [] if score is None else score.notes,
        "innovations": innovation_rows(result.innovations),
        "events": result.events,
        "settings": result.settings,
        "final": {name: values[-1] for name, values in result.state.items()},
    }


def _say_finding(finding: Finding) -> None:
    say(f"{MARKS[finding.level]} {finding.check}  {finding.thing}: {finding.got}")
    if finding.level in ("warning", "error"):
        for label, text in (("expected", finding.expected), ("do", finding.do)):
            if text:
                say(f"             {label:<9}{text}")
