"""The reference brought to an estimator's times, without inventing what was not measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import quat_conjugate, quat_from_rotvec, quat_multiply, rotvec_from_quat
from robustnav.records import Array, BoolArray, Truth

MAX_GAP_INTERVALS = 3.0


@dataclass(frozen=True)
class Reference:
    """Reference attitude at chosen times.

    ``q_nb`` (n, 4), NaN rows where there is none; ``moving`` (n,) of the nearest reference sample, or None.
    """

    q_nb: Array
    moving: BoolArray | None

    @property
    def valid(self) -> BoolArray:
        """(n,) where a reference attitude exists."""
        return np.asarray(np.isfinite(self.q_nb).all(axis=1))


def reference_at(truth: Truth, t: Array) -> Reference:
    """Return the reference attitude at times ``t``.

    A time that is a reference time takes that sample as it is. Between two samples the attitude is interpolated
    along the shortest rotation (slerp). There is no reference (NaN) outside the truth's span, beside a NaN sample,
    and inside gaps longer than ``MAX_GAP_INTERVALS`` median intervals.

    Parameters
    ----------
    truth : the reference; needs ``q_nb``.
    t : (n,) times [s] on the clock of the truth.

    Raises
    ------
    InputError : the truth has no attitude, no samples, or an attitude that is not of unit norm.
    """
    if truth.q_nb is None or not len(truth.t):
        raise InputError(
            "the truth has no attitude", got=f"{len(truth.t)} samples", expected="q_nb (n, 4), body FRD to NED"
        )
    check_unit(truth.q_nb, "truth q_nb")
    if np.array_equal(t, truth.t):
        return Reference(truth.q_nb, truth.moving)
    before = np.clip(np.searchsorted(truth.t, t, side="right") - 1, 0, None)
    after = np.minimum(before + 1, len(truth.t) - 1)
    span = truth.t[after] - truth.t[before]
    share = np.divide(t - truth.t[before], span, out=np.zeros(len(t)), where=span > 0)
    exact = t == truth.t[before]
    inside = (t >= truth.t[0]) & (t <= truth.t[-1]) & (exact | (span <= longest_interval(truth.t)))
    turn_b = rotvec_from_quat(quat_multiply(quat_conjugate(truth.q_nb[before]), truth.q_nb[after]))
    between = quat_multiply(truth.q_nb[before], quat_from_rotvec(share[:, None] * turn_b))
    q_nb = np.where(exact[:, None], truth.q_nb[before], between)
    nearest = np.where(share < 0.5, before, after)
    return Reference(np.where(inside[:, None], q_nb, np.nan), None if truth.moving is None else truth.moving[nearest])


def check_unit(q: Array, thing: str) -> None:
    """Raise ``InputError`` naming the row unless every quaternion (n, 4) has unit norm to 1e-3 or is NaN."""
    bad = np.flatnonzero(np.abs(np.linalg.norm(q, axis=1) - 1.0) > 1e-3)
    if bad.size:
        raise InputError(
            thing,
            place=f"row {bad[0]}",
            got=f"norm {np.linalg.norm(q[bad[0]]):.6g}",
            expected="unit quaternions, or NaN where missing",
        )


def gaps(t: Array) -> Array:
    """Return start and end (k, 2) of the intervals of times ``t`` (n,) that are gaps [s]."""
    after = np.flatnonzero(np.diff(t) > longest_interval(t))
    return np.column_stack([t[after], t[after + 1]])


def longest_interval(t: Array) -> float:
    """Return the longest interval of times ``t`` (n,) [s] that is no gap; zero with no two distinct times."""
    steps = np.diff(t)
    steps = steps[steps > 0]
    # The small slack keeps three nominal intervals inside the limit in spite of rounding.
    return MAX_GAP_INTERVALS * float(np.median(steps)) * (1 + 1e-9) if steps.size else 0.0
