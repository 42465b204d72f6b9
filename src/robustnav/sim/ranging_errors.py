"""What can be wrong with a range, as figures; ``None`` is an effect that is absent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array


@dataclass(frozen=True)
class LinkLine:
    """A range line r = slope d + offset for each link; links differ at random by the standard deviations.

    Parameters
    ----------
    slope, offset : a [1] and b [m]: one for all links, (anchors, 1) one for each anchor, (anchors, tags) for each link.
    slope_sd, offset_sd : spread over links and runs [1], [m]; 0 for lines that are the same in every run.

    Raises
    ------
    InputError : a number that is not finite, a slope that is not positive, a negative standard deviation.
    """

    slope: float | Array
    offset: float | Array
    slope_sd: float
    offset_sd: float

    def __post_init__(self) -> None:
        slope = np.asarray(self.slope, float)
        _require("link line, slope", slope, np.isfinite(slope) & (slope > 0), "positive numbers")
        _require("link line, offset", self.offset, np.isfinite(self.offset), "finite metres")
        for name in ("slope_sd", "offset_sd"):
            _require(f"link line, {name}", getattr(self, name), 0 <= getattr(self, name) < np.inf, "a number >= 0")


@dataclass(frozen=True)
class DistanceBias:
    """A bias over the true distance: straight between ``knots`` (k,) [m], level beyond them; ``bias`` (k,) [m].

    Raises
    ------
    InputError : knots that do not ascend, not one bias a knot, or a number that is not finite.
    """

    knots: tuple[float, ...]
    bias: tuple[float, ...]

    def __post_init__(self) -> None:
        numbers = np.isfinite([*self.knots, *self.bias]).all() and len(self.knots) == len(self.bias) > 0
        good = bool(numbers) and bool((np.diff(self.knots) > 0).all())
        _require("distance bias", (self.knots, self.bias), good, "ascending knots and a bias at each")

    def at(self, distance: Array) -> Array:
        """Return the bias [m] at true distances [m], any shape."""
        return np.interp(distance, self.knots, self.bias)


@dataclass(frozen=True)
class Colour:
    """A first-order Gauss-Markov error of each anchor: ``sd`` [m], time constant ``tau`` [s]; stationary throughout.

    Raises
    ------
    InputError : a number that is not positive and finite.
    """

    sd: float
    tau: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            _require(f"colour, {name}", value, 0 < value < np.inf, "a positive number")


@dataclass(frozen=True)
class Nlos:
    """Bursts of blocked sight of each anchor: a two-state Markov chain in time, stationary throughout.

    A burst makes ranges longer by an excess drawn once and held.  The chain is exact at the readings; an
    interruption that falls between two readings of an anchor goes unseen.

    Parameters
    ----------
    share : of the time that sight is blocked, above 0 and below 1.
    duration : mean of a burst [s].
    excess_mean : mean excess [m].
    excess : ``exponential``, or ``uniform`` between 0 and twice the mean.

    Raises
    ------
    InputError : a number out of its range, or another excess.
    """

    share: float
    duration: float
    excess_mean: float
    excess: Literal["exponential", "uniform"]

    def __post_init__(self) -> None:
        _require("nlos, share", self.share, 0 < self.share < 1, "a share above 0 and below 1")
        _require("nlos, duration", self.duration, 0 < self.duration < np.inf, "a positive number of seconds")
        _require("nlos, excess_mean", self.excess_mean, 0 < self.excess_mean < np.inf, "a positive number of metres")
        _require("nlos, excess", self.excess, self.excess in ("exponential", "uniform"), "exponential or uniform")


@dataclass(frozen=True)
class Outliers:
    """Gross errors of single readings: a ``share`` of them is off by a uniform number from ``low`` to ``high`` [m].

    Raises
    ------
    InputError : a share outside 0 to 1, or ``low`` not below ``high``.
    """

    share: float
    low: float
    high: float

    def __post_init__(self) -> None:
        _require("outliers, share", self.share, 0 <= self.share <= 1, "a share from 0 to 1")
        good = -np.inf < self.low < self.high < np.inf
        _require("outliers", (self.low, self.high), good, "low below high, both finite")


@dataclass(frozen=True)
class Outage:
    """No reading with ``start <= t < stop`` [s, true time] of ``anchors`` (their numbers), or of any with None.

    Raises
    ------
    InputError : ``stop`` not after ``start``, or a negative anchor.
    """

    start: float
    stop: float
    anchors: tuple[int, ...] | None

    def __post_init__(self) -> None:
        _require("outage", (self.start, self.stop), self.start < self.stop, "a start before the stop")
        if self.anchors is not None:
            good = len(self.anchors) > 0 and min(self.anchors) >= 0
            _require("outage, anchors", self.anchors, good, "numbers of anchors from 0, or None for all")


@dataclass(frozen=True)
class AnchorClocks:
    """Clocks of the anchors of a range-difference system: a clock ahead makes the arrival at its anchor look late.

    Parameters
    ----------
    offset_sd : at the first reading [s].
    drift_sd : fractional frequency [1].
    frequency_density : two-sided density of white frequency noise [1/sqrt(Hz)]; the time error walks at random.

    Raises
    ------
    InputError : a negative number, or one that is not finite.
    """

    offset_sd: float
    drift_sd: float
    frequency_density: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            _require(f"anchor clocks, {name}", value, 0 <= value < np.inf, "a number >= 0")


@dataclass(frozen=True)
class RangingErrors:
    """Every error of simulated ranging; ``None`` is absent.

    ``white_sd``, ``line``, ``distance_bias``, ``colour`` and ``nlos`` belong to an arrival, the way between one tag and
    one anchor: a two-way range has one, a difference of ranges two, so white noise of a difference has a standard
    deviation of sqrt(2) ``white_sd``.  Differences taken at one instant share the arrival of an anchor they have in
    common, with all its errors.

    Parameters
    ----------
    white_sd : standard deviation of white noise of an arrival [m].
    line, distance_bias, colour, nlos : see there.
    outliers : of single readings.
    dropout_share : of single readings that are missing.
    outages : times without readings.
    clocks : of the anchors, for range differences only.
    stamp_delay : how late the stamps are [s]: a reading at true time t is stamped t + stamp_delay.

    Raises
    ------
    InputError : a number out of its range.
    """

    white_sd: float | None = None
    line: LinkLine | None = None
    distance_bias: DistanceBias | None = None
    colour: Colour | None = None
    nlos: Nlos | None = None
    outliers: Outliers | None = None
    dropout_share: float | None = None
    outages: tuple[Outage, ...] = ()
    clocks: AnchorClocks | None = None
    stamp_delay: float | None = None

    def __post_init__(self) -> None:
        if self.white_sd is not None:
            _require("white_sd", self.white_sd, 0 <= self.white_sd < np.inf, "a number of metres >= 0")
        if self.dropout_share is not None:
            _require("dropout_share", self.dropout_share, 0 <= self.dropout_share <= 1, "a share from 0 to 1")
        if self.stamp_delay is not None:
            _require("stamp_delay", self.stamp_delay, abs(self.stamp_delay) < np.inf, "a finite number of seconds")


def _require(thing: str, got: object, good: ArrayLike, expected: str) -> None:
    if not np.all(good):
        raise InputError(thing, got=str(got), expected=expected)
