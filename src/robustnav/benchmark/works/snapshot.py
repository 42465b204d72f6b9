"""Positions from ranges, each by itself: what the verdict costs, beside a library's least squares without one."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from robustnav.benchmark.callbacks import few
from robustnav.benchmark.peer import require
from robustnav.benchmark.peer_scipy import RangeFit
from robustnav.benchmark.timing import Contender, Entry, Work
from robustnav.engine.snapshot import Layout, Snapshots, solve_many
from robustnav.frames import Array
from robustnav.snapshot import solve_ranges
from robustnav.snapshot.readings import of_ranges
from robustnav.snapshot.starts import starts

ROOM = np.array([[x, y, z] for x in (0.0, 10.0) for y in (0.0, 8.0) for z in (0.0, 3.0)])
SD = 0.1  # m
RIGHT = 0.3  # m, median over the epochs; 0.14 is what this room and noise allow


def _epochs(n: int) -> tuple[Array, Array]:
    """Return tags (n, 3) in the room and their ranges (n, 8) [m]."""
    random = np.random.default_rng(20)
    tags = random.uniform([0.5, 0.5, 0.3], [9.5, 7.5, 2.7], (n, 3))
    distances = np.sqrt(((ROOM - tags[:, None]) ** 2).sum(axis=2))
    return tags, distances + SD * random.normal(size=distances.shape)


def _fault(tags: Array) -> Callable[[Array], float]:
    return lambda p: float(np.median(np.sqrt(((p - tags) ** 2).sum(axis=1)))) / RIGHT


def _compiled(n: int, real: Literal["double", "float"] = "double", judge: bool = True) -> Contender:
    tags, ranges = _epochs(n)
    layout, fault = Layout(ROOM, SD, real=real), _fault(tags)

    def work() -> Snapshots:
        return solve_many(layout, ranges, judge=judge)

    return Contender(work, n, lambda out: fault(out.position))


def _one_by_one(n: int, solve: Callable[[Array], Array]) -> Contender:
    tags, ranges = _epochs(few(n))
    return Contender(lambda: np.array([solve(r) for r in ranges]), len(ranges), _fault(tags))


def _fit() -> RangeFit:
    return RangeFit(require("scipy.optimize"), ROOM, SD)


def _closed_forms(ranges: Array) -> Array:
    return starts(of_ranges(ROOM, ranges, SD, None).problem)


WORK = Work(
    "snapshot",
    "a position from ranges at one instant; with a verdict unless the name says less",
    "ranges to 8 anchors in the corners of a room of 10 x 8 x 3 m, sd 0.1 m, missing none; compiled rows take an array",
    {
        "snapshot": Entry(_compiled),
        "snapshot-float": Entry(lambda n: _compiled(n, "float")),
        "position-only": Entry(lambda n: _compiled(n, judge=False)),
        "numpy-snapshot": Entry(lambda n: _one_by_one(n, lambda r: solve_ranges(ROOM, r, SD).position), baseline=True),
        "scipy-position": Entry(lambda n: _one_by_one(n, _fit().defaults), needs="scipy.optimize", baseline=True),
        "scipy-position-fastest": Entry(
            lambda n: _one_by_one(n, _fit().fastest), needs="scipy.optimize", baseline=True
        ),
        "scipy-each-start": Entry(
            lambda n: _one_by_one(n, partial(_fit().from_each, _closed_forms)),
            needs="scipy.optimize",
            baseline=True,
        ),
    },
)
