"""Anchor layouts and simple carriers: a hall, a yard, a vehicle's rig, a ceiling; one that stands and one that drives.

Layouts are in frame a, z down, with the origin on the floor; they differ in what they can tell (see each).
"""

from __future__ import annotations

from math import pi

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Anchors
from robustnav.sim.ranging_path import Leg, Path, Rest
from robustnav.sim.trajectory import Vector
from robustnav.units import STANDARD_GRAVITY


def hall() -> Anchors:
    """Return eight anchors in the corners of a hall of 12 m x 10 m, 0.3 m and 4.2 m up: good in three dimensions."""
    return _anchors([(x, y, -h) for h in (0.3, 4.2) for x, y in ((6, 5), (6, -5), (-6, -5), (-6, 5))])


def yard() -> Anchors:
    """Return six anchors on masts around a yard of 40 m x 30 m, 1 m and 5 m up in turn: height is the weak axis."""
    places = ((20, 0), (12, 15), (-12, 15), (-20, 0), (-12, -15), (12, -15))
    return _anchors([(x, y, -(1.0 if k % 2 else 5.0)) for k, (x, y) in enumerate(places)])


def vehicle_rig() -> Anchors:
    """Return four anchors on a vehicle, 5 m x 2 m x 1.5 m: far from it the ranges are nearly parallel, GDOP is high."""
    return _anchors([(2.5, 1.0, -0.5), (2.5, -1.0, -2.0), (-2.5, -1.0, -0.5), (-2.5, 1.0, -2.0)])


def ceiling() -> Anchors:
    """Return four anchors in one plane 4 m up: ranges cannot tell above it from below."""
    return _anchors([(5, 4, -4), (5, -4, -4), (-5, -4, -4), (-5, 4, -4)])


LAYOUTS = {"hall": hall, "yard": yard, "vehicle_rig": vehicle_rig, "ceiling": ceiling}


def layout(name: str) -> Anchors:
    """Return a layout by its name in ``LAYOUTS``.

    Raises
    ------
    InputError : another name.
    """
    if name not in LAYOUTS:
        raise InputError("anchor layout", got=repr(name), expected=", ".join(LAYOUTS))
    return LAYOUTS[name]()


def standing(place: Vector, duration: float) -> Path:
    """Return a level carrier heading north that stays at ``place`` (3,) [m, NED] for ``duration`` [s]."""
    return Path(place, 0.0, (Rest(duration),), STANDARD_GRAVITY, tilts=False)


def approach() -> Path:
    """Return a level carrier at 1 m height that nears ``vehicle_rig`` from 45 m to 8 m, passes around it and leaves.

    180 s, 2.2 m/s at most.
    """
    stops = ((45.0, 6.0), (20.0, 4.0), (8.0, 0.0), (6.0, -6.0), (-6.0, -6.0), (-8.0, 5.0), (-30.0, 8.0))
    times, turns = (25.0, 25.0, 20.0, 30.0, 30.0, 40.0), (0.0, 0.0, pi / 4, pi / 4, pi / 2, -pi)
    legs = [Leg((x, y, -1.0), time, turn) for (x, y), time, turn in zip(stops[1:], times, turns, strict=True)]
    return Path((*stops[0], -1.0), pi, (*legs[:3], Rest(10.0), *legs[3:]), STANDARD_GRAVITY, tilts=False)


def _anchors(places: list[tuple[float, float, float]]) -> Anchors:
    ids = tuple(f"A{k}" for k in range(len(places)))
    return Anchors(ids, np.array(places, float))
