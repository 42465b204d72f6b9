"""Figures and one self-contained page from the numbers of a run: ``report(run, score, "out/flight")``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robustnav.doctor.record import Diagnosis
    from robustnav.records import Log, Run, Score

__all__ = ["report"]


def report(
    run: Run, score: Score | None, out: str | Path, *, log: Log | None = None, diagnosis: Diagnosis | None = None
) -> Path:
    """Write ``report.html`` and ``results.json`` of a run into a folder and return the page's path.

    Equal arguments give equal bytes.  ``run.settings["command"]``, if present, is shown as the command to repeat.

    Parameters
    ----------
    run : what the estimator said.
    score : its numbers, or None without a reference.
    out : folder, made if absent.
    log : the recording, for the reference, the units of the innovations and the time line.
    diagnosis : what the doctor found in the recording.

    Raises
    ------
    InputError : ``out`` is a file, or a setting has no plain form.
    MissingExtra : matplotlib is not installed.
    """
    from robustnav.report.run_report import write_report

    return write_report(run, score, out, log, diagnosis)
