"""Figures of the alignment study: each run is reduced to a few numbers at once, many runs to percentiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robustnav.evaluate.monte_carlo import settle_time
from robustnav.frames import Array
from robustnav.studies.alignment_errors import Followed
from robustnav.units import ARCMIN, DEG

TAIL = 150.0  # s, from which tilt is judged
SETTLED = 10.0  # arcmin
CLAIMED_SETTLE = 50.0  # s, of the published filter
AFTER, LASTING = 20.0, 30.0  # s: the stretch after a start or a change in which winds are compared
NEES_TIMES = (20.0, 30.0, 50.0, 100.0, 200.0)  # s
MIDDLE, HIGHEST = 50, 95  # percentiles reported
CURVES = 10  # every tenth instant is kept of an error's course
SPREADS = ("tilt_arcmin", "tilt_at_50_s_arcmin", "after_arcmin", "settle_s", "heading_deg", "heading_known_s")


@dataclass(frozen=True)
class Course:
    """Tilt over time of many runs: ``median``, ``p95``, and the sd a filter claims, ``claimed`` (n,) [arcmin]."""

    median: Array
    p95: Array
    claimed: Array


@dataclass(frozen=True)
class Reduced:
    """What is kept of runs of one method: ``figures`` by name (runs,) or (runs, k), tilt ``size`` and the claimed sd
    ``claimed`` (runs, n) [arcmin] at every tenth instant.
    """

    figures: dict[str, Array]
    size: Array
    claimed: Array


def reduced(t: Array, runs: Sequence[Followed], changed: float) -> Reduced:
    """Return what is kept of runs over times (n + 1,) [s], the wind's last part beginning at ``changed`` [s]."""
    size = np.array([np.hypot(*run.tilt.T) for run in runs]) / ARCMIN
    kept, since = slice(None, None, CURVES), t - changed
    at = [int(np.searchsorted(t, moment - 1e-6)) for moment in NEES_TIMES if moment <= t[-1]]
    known = np.array([run.known for run in runs])
    figures = {
        "tilt_arcmin": _rms(size[:, t > TAIL]),
        "tilt_at_50_s_arcmin": size[:, int(np.searchsorted(t, CLAIMED_SETTLE))],
        "after_arcmin": np.array([tilt_after(since, run.tilt) for run in runs]),
        "settle_s": settle_time(t, size, SETTLED),
        "heading_deg": np.abs([run.heading[-1] for run in runs]) / DEG,
        "heading_known_s": settle_time(t, np.where(known, 0.0, 1.0), 0.5),
        "heading_ever_known": known.any(axis=1).astype(float),
        "nees": np.array([_tilt_nees(run, at) for run in runs]),
        "heading_nees": np.array([run.heading[-1] ** 2 / run.heading_sd[-1] ** 2 for run in runs]),
    }
    claimed = np.array([run.tilt_sd[kept] for run in runs]) / ARCMIN
    return Reduced(figures, size[:, kept].astype(np.float32), claimed.astype(np.float32))


def tilt_after(since: Array, tilt: Array) -> float:
    """Return the rms tilt [arcmin] of (n, 2) [rad] over a stretch of the time ``since`` a start or change (n,) [s]."""
    stretch = (since >= AFTER) & (since <= AFTER + LASTING)
    return float(np.sqrt(np.mean(np.sum(tilt[stretch] ** 2, axis=1)))) / ARCMIN


def joined(parts: Sequence[Reduced]) -> Reduced:
    """Return the runs of all parts, in their order."""
    figures = {name: np.concatenate([part.figures[name] for part in parts]) for name in parts[0].figures}
    size, claimed = (np.concatenate([getattr(part, name) for part in parts]) for name in ("size", "claimed"))
    return Reduced(figures, size, claimed)


def course_of(runs: Reduced) -> Course:
    """Return percentiles of the tilt over time."""
    middle, high = np.percentile(runs.size, [MIDDLE, HIGHEST], axis=0)
    return Course(middle, high, np.median(runs.claimed, axis=0))


def summary(runs: Reduced) -> dict[str, object]:
    """Return the figures of a method: percentiles, mean NEES at the end and on the way, and counts.

    ``heading_known_s``: from when heading is said to be observable to the end.  ``heading_nees`` is over the runs that
    say so at the end, ``heading_known_runs`` of them; over all where none does.
    """
    found = runs.figures
    known = np.isfinite(found["heading_known_s"])
    nees = found["nees"].mean(axis=0)
    return {
        **{name: spread(found[name]) for name in SPREADS},
        "never_settled": int(np.isnan(found["settle_s"]).sum()),
        "heading_known_runs": int(known.sum()),
        "heading_latest_known_s": _or_never(np.max(np.where(known, found["heading_known_s"], np.inf))),
        "heading_ever_known": float(found["heading_ever_known"].mean()),
        "nees": float(nees[-1]),
        "nees_over_time": {f"{moment:g}": float(value) for moment, value in zip(NEES_TIMES, nees, strict=False)},
        "heading_nees": float(found["heading_nees"][known if known.any() else ~known].mean()),
    }


def bound_summary(runs: Reduced) -> dict[str, object]:
    """Return the figures of a bound, which claims nothing and has not to settle."""
    return {name: spread(runs.figures[name]) for name in ("tilt_arcmin", "heading_deg")}


def spread(values: Array) -> dict[str, float]:
    """Return median and 95 % of values (runs,); NaN counts as the worst."""
    ordered = np.where(np.isnan(values), np.inf, values)
    middle, high = np.percentile(ordered, [MIDDLE, HIGHEST], method="higher")
    return {"median": _or_never(middle), "p95": _or_never(high)}


def _rms(values: Array) -> Array:
    out: Array = np.sqrt(np.mean(values**2, axis=1))
    return out


def _tilt_nees(run: Followed, at: list[int]) -> Array:
    tilt = run.tilt[at]
    out: Array = np.einsum("ki,ki->k", tilt, np.linalg.solve(run.tilt_cov[at], tilt[:, :, None])[:, :, 0])
    return out


def _or_never(value: float) -> float:
    return float(value) if np.isfinite(value) else float("nan")
