"""Position from ranges or range differences at one instant, with a verdict on whether to believe it.

``solve_ranges`` and ``solve_differences`` give a ``Snapshot``; ``dop_at``, ``gdop_map`` and ``best_extra_anchor`` judge
a layout before anything is measured.
"""

from __future__ import annotations

from robustnav.snapshot.geometry import Sensing
from robustnav.snapshot.planning import ExtraAnchor, Grid, best_extra_anchor, dop_at, gdop_map
from robustnav.snapshot.record import Candidate, Dop, Height, Options, Plane, Snapshot, Suspect, Weak
from robustnav.snapshot.solve import solve_differences, solve_ranges

__all__ = [
    "Candidate",
    "Dop",
    "ExtraAnchor",
    "Grid",
    "Height",
    "Options",
    "Plane",
    "Sensing",
    "Snapshot",
    "Suspect",
    "Weak",
    "best_extra_anchor",
    "dop_at",
    "gdop_map",
    "solve_differences",
    "solve_ranges",
]
