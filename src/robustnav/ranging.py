"""Anchors, and the ranges and range differences between them and the tags on a carrier."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robustnav.errors import InputError
from robustnav.streams import Array, BoolArray, IntArray, Stream, check_names, check_time


@dataclass(frozen=True)
class Anchors:
    """Ranging anchors at surveyed points.

    Parameters
    ----------
    ids : (k,) names, printable and all different.
    p_a : (k, 3) positions [m] in frame a: right-handed, z down, origin and direction of x as surveyed.
    sd : (k, 3) standard deviations of the survey [m], or None.

    Raises
    ------
    InputError : no anchor, a name that is empty or stands twice, a number that is missing, or a wrong shape.
    """

    ids: tuple[str, ...]
    p_a: Array
    sd: Array | None = None

    def __post_init__(self) -> None:
        check_names(self.ids, "anchors")
        for name, value in (("p_a", self.p_a), ("sd", self.sd)):
            if value is None:
                continue
            object.__setattr__(self, name, np.ascontiguousarray(value, float))
            checked = getattr(self, name)
            if checked.shape != (len(self.ids), 3) or not np.isfinite(checked).all():
                got = f"shape {checked.shape}, {np.count_nonzero(~np.isfinite(checked))} numbers not finite"
                raise InputError(f"anchors {name}", got=got, expected=f"finite numbers, shape ({len(self.ids)}, 3)")
        if self.sd is not None and not (self.sd > 0).all():
            raise InputError("anchors sd", got=f"{self.sd.min()}", expected="standard deviations > 0 m")


@dataclass(frozen=True)
class Ranges:
    """Ranges between tags and anchors, one row each, in time order.

    One table of events, not a ``Stream`` for each link: ranges arrive one at a time, a filter fuses them in the order
    of their stamps, and a model must not change with the number of anchors.  ``stream`` turns the rows into the
    readings of one sensor, each with the position of its anchor.

    Parameters
    ----------
    t : (n,) seconds since the recording's start, never decreasing; several rows may share a stamp.
    anchor, tag : (n,) which of ``anchors`` and ``tags``, from 0.
    distance : (n,) ranges [m], as reported or calibrated; always a number, a range that failed has no row.
    anchors : where the anchors stand.
    tags : names of the tags.
    lever_b : (tags, 3) where the tags sit on the body [m], FRD, or None.
    variance : (n,) reported or calibrated variance [m^2], or None.

    Raises
    ------
    InputError : shapes differ, time goes backwards, an index points nowhere, a distance is not finite.
    """

    t: Array
    anchor: IntArray
    tag: IntArray
    distance: Array
    anchors: Anchors
    tags: tuple[str, ...] = ("tag",)
    lever_b: Array | None = None
    variance: Array | None = None

    def __post_init__(self) -> None:
        _check_events(self, "ranges", "distance", ("anchor",))
        if self.variance is not None:
            object.__setattr__(self, "variance", np.ascontiguousarray(self.variance, float))
            good, expected = np.isfinite(self.variance) & (self.variance >= 0), "a finite variance >= 0 m^2"
            _check_column("ranges variance", self.variance, self.t, good, expected)

    def __len__(self) -> int:
        return len(self.t)

    def where(self, keep: BoolArray) -> Ranges:
        """Return the rows for which ``keep`` (n,) is true."""
        columns = {name: getattr(self, name) for name in ("t", "anchor", "tag", "distance", "variance")}
        return replace(self, **{name: value[keep] for name, value in columns.items() if value is not None})

    def stream(self, name: str = "range", *, slots: int = 0, lever: bool = False) -> Stream:
        """Return the rows as readings (n, 4) in metres: the distance, then the anchor's position in frame a.

        Parameters
        ----------
        name : of the stream, and of the sensor it is for.
        slots : append which anchor it is, as ``slots`` numbers of which one is 1, for models that estimate a bias each.
        lever : append where the tag sits on the body (3,) [m]; zero where the recording does not say.

        Raises
        ------
        InputError : more anchors than slots.
        """
        columns = [self.distance, self.anchors.p_a[self.anchor]]
        if slots:
            columns.append(_slots(self.anchors, slots)[self.anchor])
        return Stream(name, self.t, np.column_stack([*columns, *_levers(self, lever)]), "m", "a")


@dataclass(frozen=True)
class RangeDifferences:
    """Differences of the distances from a tag to two anchors, one row each, in time order.

    One table of events, as for ``Ranges``.

    Parameters
    ----------
    t : (n,) seconds since the recording's start, never decreasing; several rows may share a stamp.
    first, second : (n,) which two of ``anchors``, from 0, not the same.
    tag : (n,) which of ``tags``, from 0.
    difference : (n,) distance to ``second`` less distance to ``first`` [m], a number in every row.
    anchors : where the anchors stand.
    tags : names of the tags.
    lever_b : (tags, 3) where the tags sit on the body [m], FRD, or None.

    Raises
    ------
    InputError : shapes differ, time goes backwards, an index points nowhere, an anchor is paired with itself, a
        difference is not finite.
    """

    t: Array
    first: IntArray
    second: IntArray
    tag: IntArray
    difference: Array
    anchors: Anchors
    tags: tuple[str, ...] = ("tag",)
    lever_b: Array | None = None

    def __post_init__(self) -> None:
        _check_events(self, "range differences", "difference", ("first", "second"))
        expected = "two different anchors"
        _check_column("range differences second", self.second, self.t, self.first != self.second, expected)

    def __len__(self) -> int:
        return len(self.t)

    def where(self, keep: BoolArray) -> RangeDifferences:
        """Return the rows for which ``keep`` (n,) is true."""
        columns = ("t", "first", "second", "tag", "difference")
        return replace(self, **{name: getattr(self, name)[keep] for name in columns})

    def stream(self, name: str = "tdoa", *, slots: int = 0, lever: bool = False) -> Stream:
        """Return the rows as readings (n, 7) in metres: difference, position in frame a of the first, the second.

        Parameters and errors as of ``Ranges.stream``; the slots are 1 for the second and -1 for the first anchor.
        """
        columns = [self.difference, self.anchors.p_a[self.first], self.anchors.p_a[self.second]]
        if slots:
            one = _slots(self.anchors, slots)
            columns.append(one[self.second] - one[self.first])
        return Stream(name, self.t, np.column_stack([*columns, *_levers(self, lever)]), "m", "a")


def _slots(anchors: Anchors, slots: int) -> Array:
    """Return a row for each anchor (k, slots) with a 1 in its slot."""
    if len(anchors.ids) > slots:
        raise InputError(
            "anchors with a bias each",
            got=f"{len(anchors.ids)} anchors",
            expected=f"at most {slots}",
            do="leave out those never heard, or model ranges without biases",
        )
    return np.eye(len(anchors.ids), slots)


def _levers(record: Ranges | RangeDifferences, wanted: bool) -> list[Array]:
    """Return the lever arm of each row's tag (n, 3), if it is wanted."""
    if not wanted:
        return []
    levers = np.zeros((len(record.tags), 3)) if record.lever_b is None else record.lever_b
    return [levers[record.tag]]


def _check_events(record: Ranges | RangeDifferences, thing: str, value: str, anchors: tuple[str, ...]) -> None:
    """Give the columns their types and refuse a table whose times, values, indices or levers cannot be."""
    check_names(record.tags, "tags")
    for name in ("t", value):
        object.__setattr__(record, name, np.ascontiguousarray(getattr(record, name), float))
    check_time(record.t, thing)
    values = getattr(record, value)
    _check_column(f"{thing} {value}", values, record.t, np.isfinite(values), "a finite number of metres")
    sizes = {**dict.fromkeys(anchors, len(record.anchors.ids)), "tag": len(record.tags)}
    for name, size in sizes.items():
        index = np.asarray(getattr(record, name))
        object.__setattr__(record, name, index)
        if index.dtype.kind not in "iu":
            raise InputError(f"{thing} {name}", got=f"dtype {index.dtype}", expected="integers")
        _check_column(f"{thing} {name}", index, record.t, (index >= 0) & (index < size), f"0 to {size - 1}")
    if record.lever_b is not None:
        object.__setattr__(record, "lever_b", np.ascontiguousarray(record.lever_b, float))
        if record.lever_b.shape != (len(record.tags), 3):
            raise InputError("lever_b", got=f"shape {record.lever_b.shape}", expected=f"shape ({len(record.tags)}, 3)")


def _check_column(thing: str, values: Array | IntArray, t: Array, good: BoolArray, expected: str) -> None:
    if values.shape != t.shape:
        raise InputError(thing, got=f"shape {values.shape}", expected=f"shape {t.shape}")
    bad = np.flatnonzero(~good)
    if bad.size:
        raise InputError(thing, place=f"row {bad[0]}", got=str(values[bad[0]]), expected=expected)
