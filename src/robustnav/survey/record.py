"""What goes into a survey of anchors and what comes out of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Anchors, Array, IntArray, check_names, check_time

Verdict = Literal["unique", "ambiguous", "degenerate", "inconsistent"]
Side = Literal["+z", "-z"]


@dataclass(frozen=True)
class Links:
    """Ranges between anchors.

    Parameters
    ----------
    first, second : (m,) rows of the two ends among the anchors' ids.
    distance : (m,) calibrated ranges [m].
    sd : (m,) standard deviations [m].

    Raises
    ------
    InputError : shapes differ, a number is not finite, or an anchor is ranged to itself.
    """

    first: IntArray
    second: IntArray
    distance: Array
    sd: Array

    def __post_init__(self) -> None:
        _columns(self, "links", ("first", "second"), ("distance", "sd"))
        own = np.flatnonzero(self.first == self.second)
        if own.size:
            raise InputError("links", place=f"row {own[0]}", got="one anchor at both ends", expected="two anchors")


@dataclass(frozen=True)
class TagRanges:
    """Ranges between a moving tag and anchors, in time order.

    Parameters
    ----------
    t : (n,) s, never decreasing.
    anchor : (n,) rows among the anchors' ids.
    distance : (n,) calibrated ranges [m].
    sd : (n,) standard deviations [m].

    Raises
    ------
    InputError : shapes differ, time goes backwards, or a number is not finite.
    """

    t: Array
    anchor: IntArray
    distance: Array
    sd: Array

    def __post_init__(self) -> None:
        _columns(self, "tag ranges", ("anchor",), ("t", "distance", "sd"))
        check_time(self.t, "tag ranges")


@dataclass(frozen=True)
class Known:
    """What is known before.

    Parameters
    ----------
    p_a : (k, 3) positions of anchors [m] in frame a, z down; NaN where a coordinate is not known.
    sd : (k, 3) their standard deviations [m], or None: exact.
    tag_z : z of the tag all along [m], or None; its ``tag_z_sd`` [m].
    """

    p_a: Array
    sd: Array | None = None
    tag_z: float | None = None
    tag_z_sd: float = 0.05

    def __post_init__(self) -> None:
        for name in ("p_a", "sd"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, np.ascontiguousarray(value, float))
        if self.p_a.ndim != 2 or self.p_a.shape[1] != 3 or np.isinf(self.p_a).any():
            raise InputError("known positions", got=f"shape {self.p_a.shape}", expected="(k, 3), finite or NaN")
        if self.sd is not None:
            good = self.sd.shape == self.p_a.shape and (self.sd[~np.isnan(self.p_a)] > 0).all()
            if not good:
                raise InputError("sd of known positions", got=f"shape {self.sd.shape}", expected="(k, 3), above 0 m")
        if self.tag_z is not None and not (np.isfinite(self.tag_z) and self.tag_z_sd > 0):
            raise InputError("height of the tag", got=f"{self.tag_z}, sd {self.tag_z_sd}", expected="finite, sd > 0 m")


@dataclass(frozen=True)
class Frame:
    """How the frame is laid where no x and y are known.

    Parameters
    ----------
    first : ids of three anchors: the origin, the direction of x, and the side of y > 0; None for the first three.
        With no height known all three have z = 0 and z follows by the right-hand rule.
    side : an id and ``+z`` or ``-z``: on which side of the plane of the three it stands; without it both mirror
        images are given.
    """

    first: tuple[str, str, str] | None = None
    side: tuple[str, Side] | None = None


@dataclass(frozen=True)
class Options:
    """How a survey is judged.

    Parameters
    ----------
    confidence : level of the residual test, of the choice between two minima and of the ellipsoid that is checked.
    loss : ``student`` or ``huber``: how ranges are reweighted to find those that do not fit.
    max_dilution : a direction whose sd is beyond this many sds of a range is called degenerate.
    knot_s : distance of the knots of a smooth track of the tag [s]; None: a free position for every stamp.
    acceleration_sd : of the tag between knots [m/s^2]; with ``knot_s``.

    Raises
    ------
    InputError : a number out of its range.
    """

    confidence: float = 0.999
    loss: Literal["student", "huber"] = "student"
    max_dilution: float = 20.0
    knot_s: float | None = None
    acceleration_sd: float = 1.0

    def __post_init__(self) -> None:
        checks = (
            ("confidence", self.confidence, 0.5 <= self.confidence < 1.0, "a number from 0.5 to below 1"),
            ("loss", self.loss, self.loss in ("student", "huber"), "student or huber"),
            ("max_dilution", self.max_dilution, self.max_dilution > 0, "a number above 0"),
            ("knot_s", self.knot_s, self.knot_s is None or self.knot_s > 0, "seconds above 0, or None"),
            ("acceleration_sd", self.acceleration_sd, self.acceleration_sd > 0, "m/s^2 above 0"),
        )
        for name, got, good, expected in checks:
            if not good:
                raise InputError(f"survey option {name}", got=repr(got), expected=expected)


@dataclass(frozen=True)
class Measured:
    """Everything ranged: ``ids`` (k,) of all anchors, known or not, ``links`` between them and ranges to a tag.

    Raises
    ------
    InputError : ids that are empty or stand twice, no range at all, or a row that names no anchor.
    """

    ids: tuple[str, ...]
    links: Links | None = None
    tag: TagRanges | None = None

    def __post_init__(self) -> None:
        check_names(self.ids, "anchors")
        ends = [] if self.links is None else [self.links.first, self.links.second]
        ends += [] if self.tag is None else [self.tag.anchor]
        if not sum(end.size for end in ends):
            raise InputError("survey", got="no range", expected="ranges between anchors, or to a tag")
        for end in ends:
            bad = np.flatnonzero((end < 0) | (end >= len(self.ids)))
            if bad.size:
                expected = f"0 to {len(self.ids) - 1}"
                raise InputError(
                    "survey, anchor of a range", place=f"row {bad[0]}", got=str(end[bad[0]]), expected=expected
                )


class Layout(NamedTuple):
    """Another layout that fits: ``p_a`` (k, 3) m, ``covariance`` (3k, 3k) m^2, NaN where singular."""

    p_a: Array
    covariance: Array


class Weak(NamedTuple):
    """The least observable motion: the ``anchor`` that moves most, its ``direction`` (3,), its ``sd`` along it [m]
    (infinite where nothing bounds it), and all ``moving`` anchors.
    """

    anchor: str
    direction: Array
    sd: float
    moving: tuple[str, ...]


class Suspect(NamedTuple):
    """A range that does not fit: ``kind`` ``link`` or ``tag``, its ``row`` there, its ``ends``, measured minus
    predicted ``error`` [m], and how many ``sds`` of the residual that is.
    """

    kind: str
    row: int
    ends: str
    error: float
    sds: float


@dataclass(frozen=True)
class AnchorSurvey:
    """Surveyed anchors and how far they can be trusted.  Only ``unique`` is a survey to rely on.

    Parameters
    ----------
    verdict : ``unique``; ``ambiguous``: other layouts fit as well; ``degenerate``: a motion of anchors is not bound;
        ``inconsistent``: ranges contradict each other.
    geometry : the verdict of the layout once ranges that do not fit are left out.
    reason : in words, with numbers.
    ids : (k,) of the anchors.
    p_a : (k, 3) m; NaN when there is no layout.
    covariance : (3k, 3k) m^2, to first order, in the frame as laid; NaN where singular.
    sd : (k, 3) m: where the frame was laid by three anchors, that of the shape alone (inner constraints).
    alternatives : other layouts that the ranges do not exclude.
    weak : the least observable motion, or None without a layout.
    suspects : ranges that do not fit, worst first.
    isolated : whether the suspects are the only explanation.
    cost, dof : weighted squared residuals of all ranges, and its degrees of freedom.
    scale : residuals of what is left over their sds; above 1 the covariance is already multiplied by its square.
    link_residuals, tag_residuals : measured minus predicted [m]; NaN where a stamp of the tag could not be used.
    """

    verdict: Verdict
    geometry: Verdict
    reason: str
    ids: tuple[str, ...]
    p_a: Array
    covariance: Array
    sd: Array
    alternatives: tuple[Layout, ...]
    weak: Weak | None
    suspects: tuple[Suspect, ...]
    isolated: bool
    cost: float
    dof: int
    scale: float
    link_residuals: Array
    tag_residuals: Array

    def anchors(self) -> Anchors:
        """Return the anchors for a recording; with ``sd`` where every anchor has one.

        Raises
        ------
        InputError : a survey without a layout.
        """
        return Anchors(self.ids, self.p_a, self.sd if (self.sd > 0).all() else None)


def _columns(record: Links | TagRanges, thing: str, rows: tuple[str, ...], numbers: tuple[str, ...]) -> None:
    """Turn the columns of a record into arrays and check them."""
    for name, kind in (*((n, np.int64) for n in rows), *((n, float) for n in numbers)):
        object.__setattr__(record, name, np.atleast_1d(np.asarray(getattr(record, name), kind)))
    size = getattr(record, rows[0]).shape
    for name in (*rows, *numbers):
        value = getattr(record, name)
        if value.shape != size or value.ndim != 1:
            raise InputError(f"{thing} {name}", got=f"shape {value.shape}", expected=f"shape {size}")
        bad = np.flatnonzero(~(np.isfinite(value) & ((value > 0) | (name != "sd"))))
        if bad.size:
            expected = "a finite number, an sd above 0 m"
            raise InputError(f"{thing} {name}", place=f"row {bad[0]}", got=str(value[bad[0]]), expected=expected)
