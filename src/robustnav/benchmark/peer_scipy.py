"""Positions from ranges by ``scipy.optimize.least_squares``, as a program would call it."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from robustnav.frames import Array

FASTEST = {"method": "lm", "xtol": 1e-6, "ftol": 1e-6}  # MINPACK, with the exact derivative


class RangeFit(NamedTuple):
    """A position from ranges to ``anchors`` (k, d) m of standard deviation ``sd`` [m]; ``optimize`` is the module."""

    optimize: ModuleType
    anchors: Array
    sd: float

    def residuals(self, p: Array, ranges: Array) -> Array:
        """Return predicted minus measured (k,) in standard deviations."""
        off = p - self.anchors
        out: Array = (np.sqrt((off * off).sum(axis=1)) - ranges) / self.sd
        return out

    def derivative(self, p: Array, _: Array) -> Array:
        """Return the derivative (k, d) of the residuals."""
        off = p - self.anchors
        out: Array = off / (np.sqrt((off * off).sum(axis=1))[:, None] * self.sd)
        return out

    def defaults(self, ranges: Array) -> Array:
        """Return the position (d,) from one start, every setting of the library as it comes."""
        start = self.anchors.mean(axis=0)
        return np.asarray(self.optimize.least_squares(self.residuals, start, args=(ranges,)).x)

    def fastest(self, ranges: Array) -> Array:
        """Return the same with the fastest settings found."""
        return np.asarray(self._from(self.anchors.mean(axis=0), ranges).x)

    def from_each(self, starts: Callable[[Array], Array], ranges: Array) -> Array:
        """Return the best position from all ``starts(ranges)`` (s, d), fastest settings: so a second one is found."""
        found = [self._from(start, ranges) for start in starts(ranges)]
        return np.asarray(min(found, key=lambda one: one.cost).x)

    def _from(self, start: Array, ranges: Array) -> Any:
        return self.optimize.least_squares(self.residuals, start, self.derivative, args=(ranges,), **FASTEST)
