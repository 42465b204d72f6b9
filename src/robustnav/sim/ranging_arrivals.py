"""The errors of arrivals, one function an effect, for many runs at once.

An arrival is what passes between one tag and one anchor at one time; readings are made of one arrival or of two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.frames import Array
from robustnav.records import BoolArray, IntArray
from robustnav.sim.ranging_draws import RangingDraws
from robustnav.sim.ranging_errors import AnchorClocks, Colour, LinkLine, Nlos, RangingErrors
from robustnav.sim.ranging_setup import RangingSetup

SPEED_OF_LIGHT = 299792458.0  # m/s


@dataclass(frozen=True)
class Arrivals:
    """Arrivals in time order, each once.

    Parameters
    ----------
    t, anchor, tag : (m,) when [s], at which anchor, of which tag.
    event : (m,) a reading that it belongs to.
    first, second : (n,) arrivals that the readings are made of; ``first`` is None for two-way ranges.
    previous : (m,) the arrival before it at the same anchor, -1 without.
    links : numbers of anchors and tags.
    """

    t: Array
    anchor: IntArray
    tag: IntArray
    event: IntArray
    first: IntArray | None
    second: IntArray
    previous: IntArray
    links: tuple[int, int]

    @classmethod
    def of(cls, setup: RangingSetup) -> Arrivals:
        """Return the arrivals of all readings; those that share time, anchor and tag share the arrival."""
        events = setup.events
        sides = [events.second] if events.first is None else [events.first, events.second]
        rows = np.concatenate([np.stack([events.t, side, events.tag], axis=1) for side in sides])
        unique, where, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        anchor = unique[:, 1].astype(np.int64)
        previous = np.full(len(unique), -1)
        for one in np.unique(anchor):
            own = np.flatnonzero(anchor == one)
            previous[own[1:]] = own[:-1]
        parts = inverse.reshape(len(sides), len(events))
        first = None if events.first is None else parts[0]
        tag = unique[:, 2].astype(np.int64)
        links = len(setup.anchors.ids), len(setup.tags)
        return cls(unique[:, 0], anchor, tag, where % len(events), first, parts[-1], previous, links)

    @property
    def since(self) -> Array:
        """Time since the arrival before it at the same anchor (m,) [s]; since the first of all without."""
        return self.t - np.where(self.previous < 0, self.t[0], self.t[self.previous])


@dataclass(frozen=True)
class ArrivalErrors:
    """Errors of arrivals: ``parts`` by effect, (runs or 1, m) [m], and which were blocked, ``nlos`` (runs, m)."""

    parts: dict[str, Array]
    nlos: BoolArray

    def total(self) -> Array:
        """Return the sum of all effects (runs, m) [m]."""
        out = np.zeros(self.nlos.shape)
        for part in self.parts.values():
            out += part
        return out


def arrival_errors(arrivals: Arrivals, distance: Array, errors: RangingErrors, draws: RangingDraws) -> ArrivalErrors:
    """Return every effect on arrivals of true ``distance`` (runs or 1, m) [m]; an absent one has no part."""
    parts: dict[str, Array] = {}
    nlos = np.zeros((len(draws.runs), len(arrivals.t)), bool)
    if errors.white_sd is not None:
        parts["white"] = errors.white_sd * draws.normal("white", arrivals.t.shape)
    if errors.line is not None:
        parts["line"] = line_bias(arrivals, distance, errors.line, draws)
    if errors.distance_bias is not None:
        parts["distance_bias"] = errors.distance_bias.at(distance)
    if errors.colour is not None:
        parts["colour"] = colour(arrivals, errors.colour, draws)
    if errors.nlos is not None:
        parts["nlos"], nlos = nlos_excess(arrivals, errors.nlos, draws)
    if errors.clocks is not None:
        parts["clocks"] = SPEED_OF_LIGHT * clock_error(arrivals, errors.clocks, draws)
    return ArrivalErrors(parts, nlos)


def line_bias(arrivals: Arrivals, distance: Array, line: LinkLine, draws: RangingDraws) -> Array:
    """Return (slope - 1) d + offset (runs, m) [m] of each arrival's link."""
    spread = draws.normal("line", (2, *arrivals.links))
    slope = line.slope + line.slope_sd * spread[:, 0]
    offset = line.offset + line.offset_sd * spread[:, 1]
    out: Array = (slope[:, arrivals.anchor, arrivals.tag] - 1) * distance + offset[:, arrivals.anchor, arrivals.tag]
    return out


def colour(arrivals: Arrivals, figures: Colour, draws: RangingDraws) -> Array:
    """Return a Gauss-Markov error of each anchor (runs, m) [m], exact for uneven times."""
    # An anchor's first arrival remembers nothing and draws from the lasting distribution.
    pole = np.where(arrivals.previous < 0, 0.0, np.exp(-arrivals.since / figures.tau))
    drive = figures.sd * np.sqrt(1 - pole**2) * draws.normal("colour", pole.shape)
    return _follow(arrivals, pole, drive)


def clock_error(arrivals: Arrivals, clocks: AnchorClocks, draws: RangingDraws) -> Array:
    """Return the time errors of the anchors' clocks (runs, m) [s] at their arrivals."""
    start = draws.normal("clock", (2, arrivals.links[0]))[:, :, arrivals.anchor]
    ramp = clocks.offset_sd * start[:, 0] + clocks.drift_sd * start[:, 1] * (arrivals.t - arrivals.t[0])
    steps = clocks.frequency_density * np.sqrt(arrivals.since) * draws.normal("clock_walk", arrivals.t.shape)
    out: Array = ramp + _follow(arrivals, np.ones_like(arrivals.t), steps)
    return out


def nlos_excess(arrivals: Arrivals, nlos: Nlos, draws: RangingDraws) -> tuple[Array, BoolArray]:
    """Return the excess [m] of blocked arrivals and which are blocked, both (runs, m).

    With a share s and bursts of mean T the chain forgets with the time constant T (1 - s):
    P(blocked | blocked before or not, 1 or 0) = s + (before - s) exp(-dt / (T (1 - s))).
    """
    before, since = arrivals.previous, arrivals.since
    memory = np.where(before < 0, 0.0, np.exp(-since / (nlos.duration * (1 - nlos.share))))
    chance = draws.uniform("nlos", memory.shape).T
    fresh = (draws.exponential if nlos.excess == "exponential" else draws.uniform)("nlos_excess", memory.shape).T
    fresh = nlos.excess_mean * (fresh if nlos.excess == "exponential" else 2 * fresh)
    blocked, excess = np.zeros(chance.shape, bool), np.zeros(chance.shape)
    for k, back in enumerate(before):
        blocked[k] = chance[k] < nlos.share + (blocked[back] - nlos.share) * memory[k]
        excess[k] = blocked[k] * np.where(blocked[back] & (back >= 0), excess[back], fresh[k])
    return excess.T, blocked.T


def _follow(arrivals: Arrivals, pole: Array, drive: Array) -> Array:
    """Return x[k] = pole[k] x[previous of k] + drive[k] for ``drive`` (runs, m), 0 where there is no previous one."""
    x = np.ascontiguousarray(drive.T)  # a row an arrival, so that a step works on neighbours in memory
    for k, back in enumerate(arrivals.previous):
        if back >= 0:
            x[k] += pole[k] * x[back]
    out: Array = x.T
    return out
