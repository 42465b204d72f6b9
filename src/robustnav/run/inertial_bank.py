"""Filters with headings all round, side by side until the readings know the heading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import SensorSeen
from robustnav.filter.steps import pack, unpack
from robustnav.frames import Array, euler_from_quat, rotation_error
from robustnav.model.blocks import Model
from robustnav.records import IntArray
from robustnav.run.feed import Feed
from robustnav.run.hypotheses import Way, evidence
from robustnav.run.loop import Start
from robustnav.run.task import Task

HOPELESS = 40.0  # a filter whose readings cost this much more than the best one's is given up
AGREED = 1.5  # the heading's sd over all filters, in that of the best one, below which one Gaussian says it all
CHUNK = 2.0  # s that all filters are run for before they are compared
Piece = tuple[int, tuple[SensorSeen | None, ...]]  # a row, and what the readings behind it said


@dataclass(frozen=True)
class Search:
    """What came of a bank begun at a row: its rows up to ``end``, where its filters agree or the recording ends.

    The heading was ``found`` at that row, None where it was not.
    ``x`` (m, nx) and packed ``P`` are of the best filter so far, its covariance reaching to the others; ``pieces`` are
    what the readings said to it.  ``start`` is where the chosen one began, ``last`` what all of them say at ``end``, in
    one state and covariance.  ``headings`` (k,) [rad] are those left, their ``shares`` (k,) how likely each is.
    """

    x: Array
    P: Array
    end: int
    found: int | None
    start: Start
    last: Start
    pieces: tuple[Piece, ...]
    headings: Array
    shares: Array


def search(task: Task, row: int, starts: Sequence[Start], found_sd: float) -> Search:
    """Follow filters from several starts at a row until their heading is known to ``found_sd`` [rad] and they agree.

    Each is charged the Student-t cost of its readings; how likely it is follows from that, and with all of them the
    mean square of the heading about the best one's.  Nothing looks ahead: a row is what its past says.
    """
    t, model = task.feed.t, task.estimator.model
    begins, alive, costs, begin = list(starts), list(starts), np.zeros(len(starts)), row
    parts: list[tuple[Array, Array]] = []
    pieces: list[Piece] = []
    found: int | None = None
    while True:
        stop = min(int(np.searchsorted(t, t[begin] + CHUNK)) + 1, len(t))
        chunk = replace(task, feed=Feed(t[:stop], task.feed.u[:stop], task.feed.sensors))
        ways = [Way.follow(chunk, begin, one) for one in alive]
        totals = costs[:, None] + np.array([evidence(chunk, begin, way) for way in ways])
        best, shares = np.argmin(totals, axis=0), _shares(totals)
        x, P = _mixed(model, ways, best, shares)
        own = np.stack([way.P for way in ways])[best, np.arange(len(best))]
        sd = _heading_sd(model, P)
        known, agree = sd < found_sd, sd < AGREED * _heading_sd(model, own)
        done = np.flatnonzero((known & agree)[1:])
        last = int(done[0]) + 1 if done.size else stop - begin - 1
        if found is None and known[1 : last + 1].any():
            found = begin + 1 + int(np.argmax(known[1 : last + 1]))
        rows = slice(min(len(parts), 1), last + 1)  # a chunk's first row is the last one's end
        parts.append((x[rows], P[rows]))
        pieces += _said(ways, best[: last + 1], begin)
        ends = [Start(way.x[last], unpack(way.P[last])) for way in ways]
        if done.size or stop == len(t):
            chosen = int(best[last])
            return Search(
                x=np.vstack([one for one, _ in parts]),
                P=np.vstack([one for _, one in parts]),
                end=begin + last,
                found=found,
                start=begins[chosen],
                last=_merged(task, ends, chosen, shares[:, last]),
                pieces=tuple(pieces),
                headings=np.array([euler_from_quat(end.x[model.state_slices["q_nb"]])[2] for end in ends]),
                shares=shares[:, last],
            )
        kept = np.flatnonzero(totals[:, -1] < totals[:, -1].min() + HOPELESS)
        alive, begins = [ends[k] for k in kept], [begins[k] for k in kept]
        costs, begin = totals[kept, -1], stop - 1


def _shares(costs: Array) -> Array:
    """Return how likely each filter is (k, m), by the costs of what it was to explain."""
    likely = np.exp(costs.min(axis=0) - costs)
    out: Array = likely / likely.sum(axis=0)
    return out


def _said(ways: Sequence[Way], best: IntArray, begin: int) -> list[Piece]:
    """Return rows and what the readings behind each said to the filter that was the best from there on."""
    changes = [0, *(np.flatnonzero(np.diff(best)) + 1)]
    return [(begin + int(k), ways[best[k]].seen) for k in changes]


def _mixed(model: Model, ways: Sequence[Way], best: IntArray, shares: Array) -> tuple[Array, Array]:
    """Return states (m, nx) of the best filters and packed covariances about them of all."""
    rows = np.arange(len(best))
    x = np.stack([way.x for way in ways])[best, rows]
    total = np.zeros((len(rows), model.error_size, model.error_size))
    for way, share in zip(ways, shares, strict=True):
        d = _difference(model, way.x, x)
        total += share[:, None, None] * (unpack(way.P) + d[:, :, None] * d[:, None, :])
    return x, np.array([pack(one) for one in total])


def _merged(task: Task, ends: Sequence[Start], chosen: int, shares: Array) -> Start:
    """Return the mean of what filters say, and the covariance about it."""
    model, x = task.estimator.model, ends[chosen].x
    d = _difference(model, np.stack([end.x for end in ends]), np.tile(x, (len(ends), 1)))
    mean = shares @ d
    P = sum(share * (end.P + np.outer(e - mean, e - mean)) for share, end, e in zip(shares, ends, d, strict=True))
    return Start(functions_of(model, task.backend).inject(x, mean), P)


def _difference(model: Model, x: Array, reference: Array) -> Array:
    """Return the errors (m, ne) that take reference states to ``x`` (m, nx)."""
    parts = []
    for block in model.state:
        part = model.state_slices[block.name]
        turned = block is model.rotation
        parts.append(rotation_error(x[:, part], reference[:, part]) if turned else x[:, part] - reference[:, part])
    return np.hstack(parts)


def _heading_sd(model: Model, P: Array) -> Array:
    """Return the standard deviation (m,) of the error about the vertical of packed covariances (m, ...)."""
    down = model.error_slices["q_nb"].start + 2
    out: Array = np.sqrt(unpack(P)[:, down, down])
    return out
