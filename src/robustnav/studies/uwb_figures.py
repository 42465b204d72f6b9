"""Figures of runs that started without a prior: errors, recovery, and which of them are lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robustnav.frames import Array
from robustnav.records import BoolArray
from robustnav.studies.uwb_setting import Scenario

LOST_M, LOST_S = 1.0, 2.0  # a run whose error is above one for longer than the other, while ranges come, is lost
FOUND_M, FOUND_S = 0.5, 1.0  # a filter has recovered when its error stays below the one for the other


@dataclass(frozen=True)
class Followed:
    """What one run of one method gave: ``t`` (n,), errors and standard deviations (n, 3) [m]; None where it refused."""

    t: Array
    error: Array
    sd: Array


def figures_of(found: Sequence[Followed | None], scenario: Scenario) -> dict[str, float]:
    """Return the figures of a method: errors from the first position on, recovery, lost and refused runs."""
    runs = [f for f in found if f is not None]
    out = {"runs": float(len(found)), "refused": float(len(found) - len(runs))}
    if not runs:
        return out | {"lost": float(len(found))}
    # where a tag was moved unseen, its error until it is found again is what recovery tells, not what the filter's does
    since = [_after(f, scenario) for f in runs]
    out |= position_figures([f.error[s] for f, s in zip(runs, since, strict=True)])
    normalised = np.concatenate([((f.error / f.sd)[s] ** 2).sum(axis=1) for f, s in zip(runs, since, strict=True)])
    recovery = np.array([recovery_of(f, scenario.returns) for f in runs])
    lost = [is_lost(f, scenario) for f in runs]
    out |= {"nees": float(np.mean(normalised)), "lost": float(sum(lost)) + out["refused"]}
    if scenario.returns is not None:
        out |= {"recovery_median_s": float(np.median(recovery)), "recovery_max_s": float(np.max(recovery))}
    return out


def position_figures(errors: Sequence[Array]) -> dict[str, float]:
    """Return rms in the plane and in space, and the 95th percentile, of errors (n, 3) of several runs [m]."""
    squares = np.vstack(errors) ** 2
    return {
        "rmse_2d": float(np.sqrt(squares[:, :2].sum(axis=1).mean())),
        "rmse_3d": float(np.sqrt(squares.sum(axis=1).mean())),
        "p95_3d": float(np.sqrt(np.percentile(squares.sum(axis=1), 95))),
    }


def _after(followed: Followed, scenario: Scenario) -> BoolArray:
    """Return which rows are judged: all, but for two seconds after ranges return or a tag was moved."""
    if scenario.returns is None:
        return np.ones(len(followed.t), bool)
    return (followed.t < scenario.returns) | (followed.t > scenario.returns + LOST_S)


def recovery_of(followed: Followed, returns: float | None) -> float:
    """Return how long after ranges return the error falls below ``FOUND_M`` and stays there for a second [s]."""
    if returns is None:
        return 0.0
    later = followed.t >= returns
    t = followed.t[later]
    far = t[np.linalg.norm(followed.error[later], axis=1) > FOUND_M]
    begins = np.concatenate([[returns], far])
    ends = np.concatenate([far, [t[-1]]])
    held = np.flatnonzero(ends - begins > FOUND_S)
    return float(begins[held[0]] - returns) if held.size else float("inf")


def is_lost(followed: Followed, scenario: Scenario) -> bool:
    """Return whether the error stays above a limit for too long while ranges come."""
    far = np.linalg.norm(followed.error, axis=1) > LOST_M
    change = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]]).astype(int)))
    for begin, stop in zip(change[::2], change[1::2] - 1, strict=True):
        start, end = followed.t[begin], followed.t[stop]
        if scenario.returns is not None and start <= scenario.returns <= end:
            start = scenario.returns
        if end - start > LOST_S:
            return True
    return False
