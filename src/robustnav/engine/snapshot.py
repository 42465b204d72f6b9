"""The snapshot solver compiled: the records of ``robustnav.snapshot``, and many epochs in one call.

Same numbers to rounding as the NumPy form; the verdict and its reason are put into words by the same code.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robustnav.engine import _kernel
from robustnav.errors import InputError
from robustnav.records import Array, BoolArray
from robustnav.snapshot import words
from robustnav.snapshot.core import distances
from robustnav.snapshot.honest import quantile
from robustnav.snapshot.readings import of_differences, of_ranges
from robustnav.snapshot.record import Candidate, Dop, Height, Options, Plane, Snapshot, Suspect, Verdict, Weak
from robustnav.snapshot.solve import solve_differences, solve_ranges

MAX_ANCHORS, MAX_FAULTS, MAX_OTHERS = 32, 4, 32
VERDICTS: tuple[Verdict, ...] = ("unique", "ambiguous", "degenerate", "inconsistent", "too few")
_CAUSES = ("", "singular", "unsettled", "on anchor", "merged", "bent", "gdop")
_REPAIRS = ("exclude", "student", "huber")
_ROW, _OTHER, _SUSPECT, _QUANTILES = 34, 10, 3, 36  # rn_snapshot_host.h
_PACKED = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


@dataclass(frozen=True)
class Layout:
    """What the epochs of one call share.

    Parameters
    ----------
    anchors : (k, 2) or (k, 3) surveyed positions [m], at most 32; for differences row 0 is the reference.
    noise : sd [m] of a range, or of one arrival for differences: a number or (k,).
    kind : what is measured, ``ranges`` or ``differences`` of ranges.
    height : known third coordinate of the tag, or None.
    real : number type of the kernel, ``double`` or ``float``.

    Raises
    ------
    InputError : shapes, numbers that are not finite, a noise that is not positive, a height in 2D, too many anchors.
    """

    anchors: ArrayLike
    noise: ArrayLike
    kind: Literal["ranges", "differences"] = "ranges"
    height: Height | None = None
    real: Literal["double", "float"] = "double"

    def __post_init__(self) -> None:
        for name, got, known in (
            ("kind", self.kind, ("ranges", "differences")),
            ("real", self.real, ("double", "float")),
        ):
            if got not in known:
                raise InputError(f"snapshot {name}", got=repr(got), expected=" or ".join(known))
        if np.ndim(self.noise) > 1:
            expected, do = "one sd or (k,) sds", "use robustnav.snapshot for correlated readings"
            raise InputError("snapshot noise", got=f"shape {np.shape(self.noise)}", expected=expected, do=do)
        anchors = np.array(self.anchors, float, order="C")
        count = len(anchors) if anchors.ndim else 0
        if count > MAX_ANCHORS:
            do = "use robustnav.snapshot, which has no limit"
            raise InputError("anchors", got=f"{count} rows", expected=f"at most {MAX_ANCHORS}", do=do)
        # the checks of the NumPy form, on readings that are all there
        (of_differences if self.kind == "differences" else of_ranges)(
            anchors, np.zeros(max(count - int(self.kind == "differences"), 0)), self.noise, self.height
        )
        object.__setattr__(self, "anchors", anchors)
        object.__setattr__(self, "noise", np.full(count, 1.0) * np.asarray(self.noise, float))

    @property
    def size(self) -> tuple[int, int]:
        """Number of readings in an epoch, and of coordinates."""
        k, d = np.shape(self.anchors)
        return k - int(self.kind == "differences"), d


class Snapshots(NamedTuple):
    """Solutions of n epochs; entries as those of ``Snapshot``.

    ``verdict`` (n,) are indices into ``VERDICTS``; ``alternatives`` (n,) counts the other positions, of which ``solve``
    gives each; ``weak_direction`` (n, d); ``dop`` arrays (n,).
    """

    verdict: Array
    position: Array
    covariance: Array
    cost: Array
    dof: Array
    weights: Array
    alternatives: Array
    dop: Dop
    weak_direction: Array
    weak_sd: Array
    isolated: BoolArray
    unseen_shift: Array
    iterations: Array

    @property
    def unique(self) -> BoolArray:
        """Which epochs (n,) are fixes to rely on."""
        out: BoolArray = self.verdict == VERDICTS.index("unique")
        return out


class _Details(NamedTuple):
    rows: Array
    weights: Array
    others: Array | None = None
    suspects: Array | None = None


def solve_many(layout: Layout, readings: ArrayLike, options: Options | None = None, judge: bool = True) -> Snapshots:
    """Solve many epochs over the same anchors.

    Parameters
    ----------
    layout : anchors, noise and what is measured.
    readings : (n, k) ranges or (n, k - 1) differences [m]; NaN where missing.
    options : levels of the tests; None for the defaults.
    judge : False finds one minimum from the closed form, and its first-order covariance, without a verdict on either:
        ``unique`` then only says that the descent settled.

    Returns
    -------
    snapshots : arrays over the epochs.

    Raises
    ------
    InputError : shapes, infinite numbers, more faults than the kernel leaves out together.
    """
    z = _readings(layout, readings)
    details = _Details(np.empty((len(z), _ROW)), np.empty((len(z), len(np.asarray(layout.noise)))))
    _call(layout, z, options or Options(), details, judge)
    r, d = details.rows, layout.size[1]
    return Snapshots(
        verdict=r[:, 0].astype(np.uint8),
        position=r[:, 10 : 10 + d],
        covariance=r[:, 13:19][:, _PACKED[:d, :d]],
        cost=r[:, 9],
        dof=r[:, 3].astype(int),
        weights=details.weights,
        alternatives=(r[:, 6] + r[:, 7]).astype(int),
        dop=Dop(r[:, 19], r[:, 20], r[:, 21]),
        weak_direction=r[:, 22 : 22 + d],
        weak_sd=r[:, 25],
        isolated=r[:, 5] > 0,
        unseen_shift=r[:, 26],
        iterations=r[:, 4].astype(int),
    )


def solve(layout: Layout, readings: ArrayLike, options: Options | None = None) -> Snapshot:
    """Solve one epoch; the record and the words of ``robustnav.snapshot``.

    Parameters
    ----------
    layout : anchors, noise and what is measured.
    readings : (k,) ranges or (k - 1,) differences [m]; NaN where missing.
    options : levels of the tests; None for the defaults.

    Returns
    -------
    snapshot : as from ``solve_ranges`` or ``solve_differences``; at most 32 alternatives.

    Raises
    ------
    InputError : as for ``solve_many``.
    """
    options = options or Options()
    z = _readings(layout, np.asarray(readings, float)[None])
    k = len(np.asarray(layout.noise))
    details = _Details(
        np.empty((1, _ROW)), np.empty((1, k)), np.empty((MAX_OTHERS, _OTHER)), np.empty((MAX_ANCHORS, _SUSPECT))
    )
    _call(layout, z, options, details, True)
    return _record(layout, z[0], options, details)


def _readings(layout: Layout, readings: ArrayLike) -> Array:
    out = np.ascontiguousarray(readings, float)
    if out.ndim != 2 or out.shape[1] != layout.size[0]:
        raise InputError(layout.kind, got=f"shape {out.shape}", expected=f"shape (epochs, {layout.size[0]})")
    bad = np.argwhere(np.isinf(out))
    if bad.size:
        place = f"epoch {bad[0, 0]}, row {bad[0, 1]}"
        raise InputError(layout.kind, place=place, got="infinity", expected="numbers in m, NaN where missing")
    return out


def _call(layout: Layout, z: Array, options: Options, out: _Details, judge: bool) -> None:
    if options.max_faults > MAX_FAULTS:
        do = "use robustnav.snapshot, which has no limit"
        raise InputError("snapshot option max_faults", got=str(options.max_faults), expected="at most 4", do=do)
    height = (0.0, 0.0) if layout.height is None else (float(layout.height.z), float(layout.height.sd))
    levels = np.array([quantile(options.confidence, dof) for dof in range(_QUANTILES)])
    repair = _REPAIRS.index(options.repair)
    _kernel.snapshot(
        layout.real,
        layout.kind == "differences",
        layout.anchors,
        z,
        layout.noise,
        height,
        levels,
        (options.max_gdop, repair, options.max_faults, judge),
        *out,
    )


def _candidate(numbers: Array, cost: float, d: int) -> Candidate:
    return Candidate(numbers[:d].copy(), numbers[3:9][_PACKED[:d, :d]], float(cost))


def _record(layout: Layout, z: Array, options: Options, found: _Details) -> Snapshot:
    row, d = found.rows[0], layout.size[1]
    verdict, judged, cause, dof, steps, isolated, others, rivals, named = (int(v) for v in row[:9])
    if VERDICTS[verdict] == "too few":
        whole = solve_differences if layout.kind == "differences" else solve_ranges
        return whole(layout.anchors, z, layout.noise, layout.height, options)  # nothing to compute, only to say
    best = _candidate(row[10:19], row[9], d)
    near = [_candidate(o, o[9], d) for o in np.asarray(found.others)[: others + rivals]]
    weak = Weak(row[22 : 22 + d].copy(), float(row[25]))
    plane = None if np.isnan(row[33]) else Plane(row[27 : 27 + d].copy(), row[30 : 30 + d].copy(), float(row[33]))
    dop = Dop(*row[19:22])
    suspects = tuple(Suspect(int(s[0]), float(s[1]), float(s[2])) for s in np.asarray(found.suspects)[:named])
    own = tuple(near[:others])
    if VERDICTS[verdict] == "inconsistent":
        reason = words.inconsistent(best.cost, quantile(options.confidence, dof), dof, suspects, bool(isolated))
        reason += f" Without: {VERDICTS[judged]}." if named else ""
    elif VERDICTS[verdict] == "degenerate":
        reason = words.degenerate(_CAUSES[cause], weak, own)
    elif VERDICTS[verdict] == "ambiguous":
        reason = words.ambiguous(best, own, plane)
    else:
        reason = words.unique(best, dop, dof)
    away = distances(best.position[None], np.asarray(layout.anchors, float))[0][0]
    return Snapshot(
        verdict=VERDICTS[verdict],
        reason=reason,
        position=best.position,
        covariance=best.covariance,
        alternatives=tuple(near),
        residuals=z - (away[1:] - away[0] if layout.kind == "differences" else away),
        used=found.weights[0] > 0,
        weights=found.weights[0],
        cost=best.cost,
        dof=dof,
        dop=dop,
        weak=weak,
        plane=plane,
        suspects=suspects,
        isolated=bool(isolated),
        unseen_shift=float(row[26]),
        iterations=steps,
    )
