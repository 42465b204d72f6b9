"""What a study must show, and whether it does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from robustnav.report.page import Page


class Goal(NamedTuple):
    """What a study must show: a value and its limit; ``met`` where the value is not larger."""

    name: str
    value: float
    limit: float
    met: bool


def goal(name: str, value: float, limit: float) -> Goal:
    """Return a goal, met or not."""
    return Goal(name, value, limit, value <= limit)


def goal_rows(goals: Sequence[Goal]) -> list[dict[str, object]]:
    """Return a row a goal."""
    return [{"goal": g.name, "value": g.value, "limit": g.limit, "met": "yes" if g.met else "no"} for g in goals]


def goal_verdict(out: Page, goals: Sequence[Goal]) -> None:
    """Say first on a page how many goals are met, and which are not."""
    missed = [g for g in goals if not g.met]
    words = f"{len(goals) - len(missed)} of {len(goals)} goals are met."
    reasons = [f"Missed: {g.name}: {g.value:.3g}, limit {g.limit:.3g}." for g in missed]
    out.verdict("warning" if missed else "ok", words, reasons)
