"""Corrections of all links of a ranging system, fitted at once and applied to recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from robustnav.calibrate.bias_curve import BiasCurve
from robustnav.calibrate.pairs import Labels, Pairs
from robustnav.calibrate.range_line import RangeLine, fit_line
from robustnav.errors import InputError, RobustnavError
from robustnav.records import IntArray, Ranges

Key = tuple[str, ...]
FIELDS: dict[str, tuple[str, ...]] = {"all": (), "anchor": ("anchor",), "link": ("anchor", "tag")}


@dataclass(frozen=True)
class RangeCalibration:
    """Corrections by key, and what to say about them.

    Parameters
    ----------
    by : ``all``: one correction, key (); ``anchor``: keys (anchor,); ``link``: keys (anchor, tag), ids of both.
    corrections : ``RangeLine`` or ``BiasCurve`` by key.
    source : a line on the recording they came from, or empty.

    Raises
    ------
    InputError : another grouping, no correction, or a key of another length.
    """

    by: str
    corrections: Mapping[Key, RangeLine | BiasCurve]
    source: str = ""

    def __post_init__(self) -> None:
        size = len(_fields(self.by))
        wrong = [key for key in self.corrections if len(key) != size]
        if wrong or not self.corrections:
            got = f"key {wrong[0]}" if wrong else "no correction"
            raise InputError("calibration", got=got, expected=f"one of {size} names for each {self.by}")

    def apply(self, ranges: Ranges) -> Ranges:
        """Return calibrated ranges with their variances; reported variances are replaced.

        Raises
        ------
        InputError : an anchor or link that has ranges and no correction.
        """
        distance, variance = np.empty(len(ranges)), np.empty(len(ranges))
        names = {"anchor": np.array(ranges.anchors.ids)[ranges.anchor], "tag": np.array(ranges.tags)[ranges.tag]}
        for key, rows in _rows([names[field] for field in _fields(self.by)], len(ranges)).items():
            if key not in self.corrections:
                known = ", ".join("-".join(k) for k in self.corrections)
                do = "calibrate it, or leave its ranges out"
                raise InputError(f"no correction for {'-'.join(key)}", expected=f"one of {known[:200]}", do=do)
            correction = self.corrections[key]
            distance[rows] = correction.distance(ranges.distance[rows])
            variance[rows] = correction.distance_variance(ranges.distance[rows])
        return replace(ranges, distance=distance, variance=variance)


def calibrate_ranges(
    pairs: Pairs,
    by: str = "all",
    fit: Callable[[Pairs], RangeLine | BiasCurve] = fit_line,
    source: str = "",
) -> RangeCalibration:
    """Fit a correction to all pairs, to those of each anchor, or to those of each link.

    Parameters
    ----------
    pairs : with ``anchor`` and ``tag`` as far as ``by`` needs them.
    by : ``all``, ``anchor`` or ``link``.
    fit : the fit of one group: ``fit_line``, or a function of its loss or knots.
    source : a line on the recording, kept with the result.

    Raises
    ------
    InputError : another grouping, pairs without the ids it needs, or what the fit refuses, with the group's name.
    EstimatorError : a fit that does not converge.
    """
    labels = []
    for field in _fields(by):
        if getattr(pairs, field) is None:
            raise InputError(f"calibration by {by}", got=f"pairs without {field}", expected=f"{field} of every pair")
        labels.append(getattr(pairs, field))
    corrections: dict[Key, RangeLine | BiasCurve] = {}
    for key, rows in _rows(labels, len(pairs)).items():
        keep = np.zeros(len(pairs), bool)
        keep[rows] = True
        try:
            corrections[key] = fit(pairs.where(keep))
        except RobustnavError as why:
            place = "-".join(key)
            raise type(why)(why.thing, place=place, got=why.got, expected=why.expected, do=why.do) from why
    return RangeCalibration(by, corrections, source)


def _fields(by: str) -> tuple[str, ...]:
    if by not in FIELDS:
        raise InputError("calibration", got=f"by {by!r}", expected=f"one of {', '.join(FIELDS)}")
    return FIELDS[by]


def _rows(labels: list[Labels], count: int) -> dict[Key, IntArray]:
    """Return the rows of each key among ``count`` rows labelled by the parts of their key."""
    if not count:
        return {}
    if not labels:
        return {(): np.arange(count)}
    names, number = np.unique(np.stack(labels, axis=1), axis=0, return_inverse=True)
    return {tuple(name.tolist()): np.flatnonzero(number == k) for k, name in enumerate(names)}
