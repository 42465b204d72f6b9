"""Ranges with the true distances they should have shown."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robustnav.errors import InputError
from robustnav.records import Array, BoolArray, IntArray, Ranges

Labels = NDArray[np.str_]


@dataclass(frozen=True)
class Pairs:
    """True distances and measured ranges, reading by reading.

    Parameters
    ----------
    distance_true, measured : (n,) m.
    anchor, tag : (n,) ids of the ends, or None.
    file : (n,) whole numbers, the same for what was recorded in one go, or None.  Errors of one file are alike: with
        files, intervals are those of independent files, not of independent readings.

    Raises
    ------
    InputError : shapes differ, or a number is missing, infinite, or a distance below zero.
    """

    distance_true: Array
    measured: Array
    anchor: Labels | None = None
    tag: Labels | None = None
    file: IntArray | None = None

    def __post_init__(self) -> None:
        for name in ("distance_true", "measured"):
            value = np.ascontiguousarray(getattr(self, name), float)
            object.__setattr__(self, name, value)
            self._check(name, value.shape, np.isfinite(value), value)
        self._check("distance_true", self.distance_true.shape, self.distance_true >= 0, self.distance_true)
        for name, kind in (("anchor", str), ("tag", str), ("file", None)):
            if getattr(self, name) is not None:
                label = np.asarray(getattr(self, name), kind)
                object.__setattr__(self, name, label)
                self._check(name, label.shape, np.ones(len(self), bool), self.measured)
        if self.file is not None and self.file.dtype.kind not in "iu":
            raise InputError("pairs file", got=f"dtype {self.file.dtype}", expected="whole numbers")

    def _check(self, name: str, shape: tuple[int, ...], good: BoolArray, values: Array) -> None:
        if shape != self.distance_true.shape or len(shape) != 1:
            raise InputError(f"pairs {name}", got=f"shape {shape}", expected="(n,) as distance_true")
        bad = np.flatnonzero(~good)
        if bad.size:
            expected = "finite metres, true distances not below zero"
            raise InputError(f"pairs {name}", place=f"row {bad[0]}", got=str(values[bad[0]]), expected=expected)

    @classmethod
    def of(cls, ranges: Ranges, distance_true: ArrayLike, file: IntArray | None = None) -> Pairs:
        """Return the ranges (n) of a recording with their true distances (n,) [m], by a reference or a survey."""
        anchor, tag = np.array(ranges.anchors.ids)[ranges.anchor], np.array(ranges.tags)[ranges.tag]
        return cls(np.asarray(distance_true, float), ranges.distance, anchor, tag, file)

    def __len__(self) -> int:
        return len(self.distance_true)

    def where(self, keep: BoolArray) -> Pairs:
        """Return the pairs for which ``keep`` (n,) is true."""
        values = {name: value[keep] for name, value in vars(self).items() if value is not None}
        return replace(self, **values)
