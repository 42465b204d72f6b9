"""What goes into a snapshot solution and what comes out of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array, BoolArray

Verdict = Literal["unique", "ambiguous", "degenerate", "inconsistent", "too few"]
Repair = Literal["exclude", "student", "huber"]
POOR_GDOP = 20.0


class Height(NamedTuple):
    """Known third coordinate of the tag: ``z`` [m] in the anchors' frame and its standard deviation ``sd`` [m]."""

    z: float
    sd: float


@dataclass(frozen=True)
class Options:
    """How a snapshot is judged.

    Parameters
    ----------
    confidence : level of the residual test, of the choice between two minima and of the ellipsoid that is checked.
    max_gdop : a geometry beyond this is called degenerate even where its ellipsoid is honest.
    repair : position given with the verdict ``inconsistent``: ``exclude`` leaves the named anchors out, ``student``
        and ``huber`` reweight all anchors.
    max_faults : largest number of anchors that may be left out together.

    Raises
    ------
    InputError : a number out of its range.
    """

    confidence: float = 0.999
    max_gdop: float = 50.0
    repair: Repair = "exclude"
    max_faults: int = 2

    def __post_init__(self) -> None:
        checks = (
            ("confidence", self.confidence, 0.5 <= self.confidence < 1.0, "a number from 0.5 to below 1"),
            ("max_gdop", self.max_gdop, self.max_gdop > 0.0, "a number above 0"),
            ("repair", self.repair, self.repair in ("exclude", "student", "huber"), "exclude, student or huber"),
            ("max_faults", self.max_faults, self.max_faults >= 0, "0, 1, 2, ..."),
        )
        for name, got, good, expected in checks:
            if not good:
                raise InputError(f"snapshot option {name}", got=repr(got), expected=expected)


class Dop(NamedTuple):
    """Dilution of precision: position sd per range sd, total, horizontal and vertical; infinite where not observable.

    ``hdop`` covers the first two coordinates.  ``vdop`` is NaN where the third is not estimated (2D, known height).
    For range differences the range sd is that of one arrival.
    """

    gdop: Array
    hdop: Array
    vdop: Array


class Candidate(NamedTuple):
    """One minimum: ``position`` (d,) m, ``covariance`` (d, d) m^2 (NaN where singular), ``cost`` = weighted squares."""

    position: Array
    covariance: Array
    cost: float


class Plane(NamedTuple):
    """The mirror between two solutions: ``point`` (d,) m, unit ``normal`` (d,), rms ``distance`` of the anchors [m]."""

    point: Array
    normal: Array
    distance: float


class Weak(NamedTuple):
    """The least observable direction: unit vector (d,) and sd along it [m], infinite where nothing bounds it."""

    direction: Array
    sd: float


class Suspect(NamedTuple):
    """An anchor (its row) that does not fit the others: by ``error`` [m], measured minus predicted, and ``sds`` sd."""

    anchor: int
    error: float
    sds: float


@dataclass(frozen=True)
class Snapshot:
    """A position from one instant and how far it can be trusted.  Only ``unique`` is a fix to rely on.

    Parameters
    ----------
    verdict : ``unique``, ``ambiguous``, ``degenerate``, ``inconsistent`` or ``too few``.
    reason : the verdict in a sentence, with numbers.
    position : (d,) best position in the anchors' frame [m]; NaN when there is none.
    covariance : (d, d) of ``position`` [m^2], to first order; NaN where not finite.
    alternatives : other positions that the readings do not exclude.
    residuals : measured minus predicted [m], in the order of the readings; NaN where a reading is missing.
    used : (k,) anchors that ``position`` rests on.
    weights : (k,) from 0 (left out or missing) to 1; between them only after reweighting.
    cost, dof : weighted sum of squared residuals of all readings and its degrees of freedom.
    dop : dilution of precision at ``position``.
    weak : least observable direction and its sd.
    plane : mirror plane (in 2D: line) of an ambiguous pair, or None.
    suspects : anchors that do not fit, worst first.
    isolated : whether the suspects are the only explanation.
    unseen_shift : the largest shift of ``position`` [m] by one wrong reading that would just pass the residual test
        (without noise); infinite without redundancy.
    iterations : damped Gauss-Newton steps to ``position``.
    """

    verdict: Verdict
    reason: str
    position: Array
    covariance: Array
    alternatives: tuple[Candidate, ...]
    residuals: Array
    used: BoolArray
    weights: Array
    cost: float
    dof: int
    dop: Dop
    weak: Weak
    plane: Plane | None = None
    suspects: tuple[Suspect, ...] = ()
    isolated: bool = False
    unseen_shift: float = float("inf")
    iterations: int = 0

    @property
    def poor(self) -> bool:
        """Whether the geometry multiplies the noise by more than 20: usable in a filter, hardly alone."""
        return not self.dop.gdop <= POOR_GDOP

    @property
    def sd(self) -> Array:
        """Standard deviation (d,) of each coordinate [m]."""
        out: Array = np.sqrt(np.diag(self.covariance))
        return out
