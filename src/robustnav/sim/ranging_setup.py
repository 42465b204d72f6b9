"""Which ranges or range differences are taken, and when."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.records import Anchors, IntArray, check_names
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.trajectory import check_times, even_times


@dataclass(frozen=True)
class Schedule:
    """Rounds of readings, each link once a round.

    Parameters
    ----------
    rounds_hz : rounds a second.
    duration : [s]; rounds begin at time 0.
    simultaneous : True takes a round at once; False takes its links in turn, evenly spaced over the round.

    Raises
    ------
    InputError : a number that is not positive, or a duration of less than a round.
    """

    rounds_hz: float
    duration: float
    simultaneous: bool

    def __post_init__(self) -> None:
        check_times(self.duration, self.rounds_hz)

    def events(self, links: int) -> tuple[Array, IntArray]:
        """Return times (n,) [s] and which of the links (n,) is read, in time order."""
        if not self.simultaneous:
            t = even_times(self.duration, self.rounds_hz * links)
            return t, np.arange(len(t)) % links
        t = even_times(self.duration, self.rounds_hz)
        return np.repeat(t, links), np.tile(np.arange(links), len(t))


@dataclass(frozen=True)
class Events:
    """Readings at true times ``t`` (n,) [s]: ``second`` and, for range differences, ``first`` anchor, and ``tag``."""

    t: Array
    first: IntArray | None
    second: IntArray
    tag: IntArray

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True)
class RangingSetup:
    """Anchors, tags, what is measured between them, when, and how well.

    Frame a of the anchors is taken to be the navigation frame of the carrier.

    Parameters
    ----------
    anchors : where they stand.
    schedule : when readings are taken.
    errors : of the readings.
    pairs : None for two-way ranges to every anchor; for range differences the pairs (first, second) of anchors, see
        ``star_pairs`` and ``ring_pairs``.
    tags : names; a round takes each link of one tag, then those of the next.
    lever_b : (tags, 3) where the tags sit on the body [m], FRD; None at its reference point.

    Raises
    ------
    InputError : a pair that is none, levers of another shape, clocks without pairs, an error of an anchor that is not
        there, or a line that fits no link.
    """

    anchors: Anchors
    schedule: Schedule
    errors: RangingErrors
    pairs: tuple[tuple[int, int], ...] | None = None
    tags: tuple[str, ...] = ("tag",)
    lever_b: Array | None = None

    def __post_init__(self) -> None:
        check_names(self.tags, "tags")
        if self.pairs is not None:
            self._check_pairs(self.pairs)
        if self.lever_b is not None:
            object.__setattr__(self, "lever_b", np.asarray(self.lever_b, float))
            if self.lever_b.shape != (len(self.tags), 3) or not np.isfinite(self.lever_b).all():
                expected = f"finite numbers, shape ({len(self.tags)}, 3)"
                raise InputError("lever_b", got=str(self.lever_b), expected=expected)
        self._check_errors()

    def _check_pairs(self, pairs: tuple[tuple[int, int], ...]) -> None:
        size = len(self.anchors.ids)
        wrong = [pair for pair in pairs if len(set(pair)) != 2 or min(pair) < 0 or max(pair) >= size]
        if wrong or not pairs:
            got = str(wrong[0]) if wrong else "none"
            raise InputError("pairs of anchors", got=got, expected=f"two different anchors, 0 to {size - 1}")

    def _check_errors(self) -> None:
        errors, size = self.errors, len(self.anchors.ids)
        if errors.clocks is not None and self.pairs is None:
            do = "leave them out, or give pairs"
            raise InputError(
                "anchor clocks", got="two-way ranges, which need none", expected="range differences", do=do
            )
        for outage in errors.outages:
            if outage.anchors is not None and max(outage.anchors) >= size:
                raise InputError("outage, anchors", got=str(outage.anchors), expected=f"0 to {size - 1}")
        shapes = [] if errors.line is None else [np.shape(errors.line.slope), np.shape(errors.line.offset)]
        for shape in shapes:
            if shape not in ((), (1, 1), (size, 1), (1, len(self.tags)), (size, len(self.tags))):
                expected = f"a number, or shape ({size}, 1) or ({size}, {len(self.tags)})"
                raise InputError("link line", got=f"shape {shape}", expected=expected)

    @cached_property
    def events(self) -> Events:
        """The readings of one run, before any is lost."""
        size = len(self.anchors.ids)
        links = np.array(self.pairs if self.pairs is not None else [(i, i) for i in range(size)], np.int64)
        t, link = self.schedule.events(len(links) * len(self.tags))
        tag, row = np.divmod(link, len(links))
        return Events(t, None if self.pairs is None else links[row, 0], links[row, 1], tag)


def star_pairs(anchors: int, reference: int = 0) -> tuple[tuple[int, int], ...]:
    """Return the pairs (reference, i) of every other anchor i."""
    return tuple((reference, i) for i in range(anchors) if i != reference)


def ring_pairs(anchors: int) -> tuple[tuple[int, int], ...]:
    """Return the pairs (0, 1), (1, 2) ... of neighbours, the last with the first."""
    return tuple((i, (i + 1) % anchors) for i in range(anchors))
