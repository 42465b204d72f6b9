"""Two-way ranges and range differences along a track, for many runs at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array, rotate
from robustnav.records import BoolArray, RangeDifferences, Ranges, Stream
from robustnav.sim.batch import run_numbers
from robustnav.sim.ranging_arrivals import Arrivals, arrival_errors
from robustnav.sim.ranging_draws import RangingDraws
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.ranging_setup import Events, RangingSetup


class Track(Protocol):
    """Where a carrier is at ``t`` (n,) [s]: ``p_n`` (n, 3) or (runs, n, 3) [m], ``q_nb`` (n, 4) or None if unknown."""

    @property
    def t(self) -> Array:
        """Times (n,) [s]."""
        ...

    @property
    def p_n(self) -> Array:
        """Positions (n, 3), or (runs, n, 3) where runs differ [m]."""
        ...

    @property
    def q_nb(self) -> Array | None:
        """Attitude (n, 4), or None."""
        ...


@dataclass(frozen=True)
class RangingBatch:
    """Simulated ranging.

    Parameters
    ----------
    runs : numbers of the runs, in the order of the first axis below.
    setup : what was simulated.
    t : (n,) stamps [s], the same in every run.
    values : (runs, n) readings [m], NaN where a reading was lost.
    nlos : (runs, n) readings whose sight was blocked, on either side of a difference.
    """

    runs: range
    setup: RangingSetup
    t: Array
    values: Array
    nlos: BoolArray

    def ranges(self, run: int) -> Ranges:
        """Return one run's two-way ranges, without the lost ones.

        Raises
        ------
        InputError : ``run`` is not among ``runs``, or differences were simulated.
        """
        events, keep, values = self._kept(run)
        if events.first is not None:
            raise InputError("ranges of a batch", got="range differences", expected="two-way ranges")
        setup = self.setup
        return Ranges(
            self.t[keep], events.second[keep], events.tag[keep], values, setup.anchors, setup.tags, setup.lever_b
        )

    def differences(self, run: int) -> RangeDifferences:
        """Return one run's range differences, without the lost ones.

        Raises
        ------
        InputError : ``run`` is not among ``runs``, or two-way ranges were simulated.
        """
        events, keep, values = self._kept(run)
        if events.first is None:
            raise InputError("range differences of a batch", got="two-way ranges", expected="range differences")
        sides = events.first[keep], events.second[keep], events.tag[keep]
        return RangeDifferences(self.t[keep], *sides, values, self.setup.anchors, self.setup.tags, self.setup.lever_b)

    def stream(self, run: int) -> Stream:
        """Return one run's readings as ``Ranges.stream`` or ``RangeDifferences.stream`` gives them."""
        return (self.ranges(run) if self.setup.events.first is None else self.differences(run)).stream()

    def readings(self) -> Array:
        """Return all runs' readings (runs, n, 4 or 7) [m] as ``stream`` orders them, NaN where one was lost."""
        events, p_a = self.setup.events, self.setup.anchors.p_a
        places = [p_a[side] for side in (events.first, events.second) if side is not None]
        shape = (*self.values.shape, 3)
        return np.concatenate([self.values[..., None], *(np.broadcast_to(place, shape) for place in places)], axis=2)

    def _kept(self, run: int) -> tuple[Events, BoolArray, Array]:
        if run not in self.runs:
            raise InputError("run of a batch", got=f"{run}", expected=f"{self.runs[0]} to {self.runs[-1]}")
        values = self.values[self.runs.index(run)]
        keep = ~np.isnan(values)
        return self.setup.events, keep, values[keep]


def simulate_ranging(track: Track, setup: RangingSetup, *, runs: int | range, seed: int) -> RangingBatch:
    """Simulate ranging along a track.

    Parameters
    ----------
    track : the carrier at ``setup.events.t``, such as ``path.at(setup.events.t)``.
    setup : what is measured, when, and how well.
    runs : how many, numbered from 0, or the numbers themselves; run i is the same however many are drawn.
    seed : not negative.  Every effect of every run has a stream of its own (``RangingDraws``), so one effect more or
        less leaves the random numbers of the others as they are.

    Raises
    ------
    InputError : no runs, a negative seed or run number, a track at other times or of other runs, a lever arm without
        an attitude.
    """
    draws = RangingDraws(seed, run_numbers(runs, seed))
    events, arrivals = setup.events, Arrivals.of(setup)
    distance = _distances(_tag_positions(track, setup, len(draws.runs)), setup, arrivals)
    wrong = arrival_errors(arrivals, distance, setup.errors, draws)
    measured, nlos = distance + wrong.total(), wrong.nlos[:, arrivals.second]
    values = measured[:, arrivals.second]
    if arrivals.first is not None:
        values = values - measured[:, arrivals.first]
        nlos = nlos | wrong.nlos[:, arrivals.first]
    values = values + outlier_errors(len(events), setup.errors, draws)
    values[lost(events, setup.errors, draws)] = np.nan
    delay = setup.errors.stamp_delay
    return RangingBatch(draws.runs, setup, events.t if delay is None else events.t + delay, values, nlos)


def outlier_errors(n: int, errors: RangingErrors, draws: RangingDraws) -> Array:
    """Return gross errors (runs, n) [m], zero where a reading has none."""
    if errors.outliers is None:
        return np.zeros((len(draws.runs), n))
    gross = errors.outliers
    size = gross.low + (gross.high - gross.low) * draws.uniform("outlier_size", (n,))
    return np.where(draws.uniform("outlier", (n,)) < gross.share, size, 0.0)


def lost(events: Events, errors: RangingErrors, draws: RangingDraws) -> BoolArray:
    """Return which readings (runs, n) are missing."""
    out = np.zeros((len(draws.runs), len(events)), bool)
    if errors.dropout_share is not None:
        out |= draws.uniform("dropout", (len(events),)) < errors.dropout_share
    sides = [side for side in (events.first, events.second) if side is not None]
    for outage in errors.outages:
        during = (events.t >= outage.start) & (events.t < outage.stop)
        if outage.anchors is not None:
            during &= np.any([np.isin(side, outage.anchors) for side in sides], axis=0)
        out |= during
    return out


def _tag_positions(track: Track, setup: RangingSetup, runs: int) -> Array:
    """Return the position of each reading's tag (runs or 1, n, 3) [m]."""
    events = setup.events
    if np.shape(track.t) != events.t.shape or not np.array_equal(track.t, events.t):
        expected, do = f"the {len(events)} times of the setup", "sample the track at setup.events.t"
        raise InputError("track, t", got=f"{np.size(track.t)} other times", expected=expected, do=do)
    p_n = np.asarray(track.p_n)
    p_n = p_n[None] if p_n.ndim == 2 else p_n
    if p_n.shape not in ((1, len(events), 3), (runs, len(events), 3)):
        expected = f"shape ({len(events)}, 3) or ({runs}, {len(events)}, 3)"
        raise InputError("track, p_n", got=f"shape {np.shape(track.p_n)}", expected=expected)
    if setup.lever_b is None:
        return p_n
    if track.q_nb is None:
        raise InputError("track, q_nb", got="none", expected="an attitude, for the lever arm")
    return p_n + rotate(track.q_nb, setup.lever_b[events.tag])


def _distances(tag_n: Array, setup: RangingSetup, arrivals: Arrivals) -> Array:
    """Return the true distances (runs or 1, m) [m] of arrivals."""
    out: Array = np.linalg.norm(tag_n[:, arrivals.event] - setup.anchors.p_a[arrivals.anchor], axis=2)
    return out
