"""What the range benchmarks share: figures of every method, failures beside successes, means, tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from robustnav.errors import InputError

Figures = dict[str, Any]
Results = dict[str, Any]
PUBLISHED = "published"


def scored(work: Callable[[], Figures]) -> Figures:
    """Return the figures of one method, with counts whole; one that fails has ``failed``, why, and no figures.

    A method that gives NaN after its first estimate, or no estimate at all, has NaN figures and says so as well.
    """
    try:
        figures = work()
    except (ArithmeticError, ValueError) as why:  # ours are ValueErrors: reported beside the others, never dropped
        return {"failed": str(why).replace("\n", "; ")}
    out = {name: int(value) if _is_count(name) else value for name, value in figures.items()}
    lost = max((value for name, value in out.items() if name.endswith("nan_estimates")), default=0)
    if lost:
        return out | {"failed": f"{lost} estimates are NaN"}
    none = any(value == 0 for name, value in out.items() if name.endswith("samples"))
    return out | ({"failed": "no estimate to score"} if none else {})


def rows_of(cases: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str, Figures]]:
    """Return case, method and figures of every row; published ones come first, named as such."""
    out = []
    for case, methods in cases.items():
        out += [(case, f"{PUBLISHED} {name}", figures) for name, figures in methods.get(PUBLISHED, {}).items()]
        out += [(case, name, figures) for name, figures in methods.items() if name != PUBLISHED]
    return out


def means(cases: Mapping[str, Mapping[str, Any]], keys: tuple[str, ...]) -> dict[str, Figures]:
    """Return by method the mean over cases of each figure, NaN if the method failed on one, and their number."""
    found: dict[str, list[Figures]] = {}
    for _, method, figures in rows_of(cases):
        found.setdefault(method, []).append(figures)
    return {
        method: {key: math.fsum(f.get(key, math.nan) for f in rows) / len(rows) for key in keys}
        | {"cases": len(rows), "failed": sum("failed" in f for f in rows)}
        for method, rows in found.items()
    }


def table(cases: Mapping[str, Mapping[str, Any]], columns: Mapping[str, str]) -> list[dict[str, object]]:
    """Return a table's rows; ``columns`` names the figure of each heading."""
    rows = rows_of(cases)
    failed = any("failed" in figures for *_, figures in rows)
    return [
        {"case": case, "method": method}
        | {heading: figures.get(key) for heading, key in columns.items()}
        | ({"failed": figures.get("failed", "")} if failed else {})
        for case, method, figures in rows
    ]


def mean_table(results: Mapping[str, Figures], columns: Mapping[str, str]) -> list[dict[str, object]]:
    """Return a table's rows of ``means``."""
    return [
        {"method": method} | {heading: figures[key] for heading, key in columns.items()}
        for method, figures in results.items()
    ]


def no_recordings(what: str, place: object, expected: str, *, is_there: bool) -> InputError:
    """Return the error for a folder in which nothing was found."""
    got = "none in it" if is_there else "no such file or folder"
    return InputError(f"no {what}", place=str(place), got=got, expected=expected, do="check the path")


def _is_count(name: str) -> bool:
    return name.endswith(("samples", "unstarted", "nan_estimates"))
