"""How far an estimated attitude is from the reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.reference import check_unit, reference_at
from robustnav.frames import (
    euler_from_quat,
    quat_conjugate,
    quat_from_euler,
    quat_multiply,
    rotvec_from_quat,
    wrap_angle,
)
from robustnav.records import Array, BoolArray, Run, Score, Truth
from robustnav.units import DEG

STEEP = 75 * DEG  # of pitch; beyond it a small rotation is a large difference of roll and yaw
NOT_AN_ERROR = "difference from another estimator, not an error"


@dataclass(frozen=True)
class AttitudeErrors:
    """Attitude errors of a run at its own times; NaN where the reference or the estimate is missing.

    Parameters
    ----------
    t : (n,) times of the run [s].
    rotvec_n : (n, 3) rotation vector of ``q_est * conj(q_ref)`` in navigation axes [rad].
    euler : (n, 3) differences of roll, pitch, yaw, wrapped [rad]; meaningless close to +-90 degrees of pitch.
    total, heading, inclination : (n,) whole angle, signed angle about down, angle of tilt [rad].
    referenced : (n,) where a reference exists.
    moving : (n,) which samples the reference marks as motion, or None.
    """

    t: Array
    rotvec_n: Array
    euler: Array
    total: Array
    heading: Array
    inclination: Array
    referenced: BoolArray
    moving: BoolArray | None


def attitude_errors(run: Run, truth: Truth) -> AttitudeErrors:
    """Return the attitude errors of a run against a reference interpolated to the run's times.

    Total, heading and inclination are those of the BROAD benchmark (Laidig et al., Data 6(7), 2021, section 4):
    the error is split into a turn about the vertical and one about a horizontal axis. The arc tangents of two
    arguments equal the published arc cosines and keep their accuracy near zero and near 180 degrees.

    Raises
    ------
    InputError : no attitude in the run or the truth, or quaternions that are not of unit norm.
    """
    q_est = attitude_of(run)
    reference = reference_at(truth, run.t)
    q_error = quat_multiply(q_est, quat_conjugate(reference.q_nb))
    w, x, y, z = q_error.T
    return AttitudeErrors(
        t=run.t,
        rotvec_n=rotvec_from_quat(q_error),
        euler=wrap_angle(euler_from_quat(q_est) - euler_from_quat(reference.q_nb)),
        total=2 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w)),
        heading=2 * np.arctan2(np.where(w < 0, -z, z), np.abs(w)),
        inclination=2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)),
        referenced=reference.valid,
        moving=reference.moving,
    )


def attitude_of(run: Run) -> Array:
    """Return ``q_nb`` (n, 4) of a run, from its block ``q_nb`` or else from ``euler`` (roll, pitch, yaw).

    Raises
    ------
    InputError : neither block, a wrong shape, or quaternions that are not of unit norm.
    """
    euler = run.state.get("euler")
    q_nb = run.state.get("q_nb", None if euler is None else quat_from_euler(euler))
    if q_nb is None or q_nb.shape != (len(run.t), 4):
        raise InputError(
            f"the run of {run.estimator} has no attitude",
            got=f"state blocks {', '.join(run.state) or 'none'}" if q_nb is None else f"shape {q_nb.shape}",
            expected=f"q_nb ({len(run.t)}, 4) or euler ({len(run.t)}, 3)",
        )
    check_unit(q_nb, f"q_nb of {run.estimator}")
    return q_nb


def evaluate(run: Run, truth: Truth, *, skip: float = 0.0) -> Score:
    """Return the attitude score of a run: root-mean-square errors in degrees and sample counts.

    Every sample with a reference counts. An estimate that is NaN there makes the score NaN and is counted in
    ``nan_estimates``; nothing is dropped because the estimator failed.

    Parameters
    ----------
    run : needs the state block ``q_nb`` or ``euler``.
    truth : reference attitude; one of kind ``estimate`` is scored, and the notes say what that means.
    skip : seconds left out after the run's first time.

    Returns
    -------
    Score with ``total_deg``, ``heading_deg``, ``inclination_deg`` (rms), ``roll_rms_deg``, ``roll_min_deg``,
    ``roll_max_deg`` and the same for pitch and yaw, ``run_samples``, ``nan_estimates``, and where the truth marks
    motion ``moving_share`` and ``moving_total_deg``, ``moving_heading_deg``, ``moving_inclination_deg``.

    Raises
    ------
    InputError : nothing to score, or as ``attitude_errors``.
    """
    errors = attitude_errors(run, truth)
    late = errors.t >= errors.t[0] + skip if len(errors.t) else errors.referenced
    scored = errors.referenced & late
    if not scored.any():
        raise InputError(
            f"nothing to score in the run of {run.estimator}",
            got=f"{len(run.t)} estimates, {int(errors.referenced.sum())} with a reference, {skip:g} s skipped",
            expected="at least one estimate with a reference attitude after the skipped time",
            do="compare the clocks of run and truth, or skip less",
        )
    missing = scored & np.isnan(errors.total)
    values = rms_deg(errors, scored) | _euler_deg(errors.euler[scored])
    values |= {"run_samples": float(len(run.t)), "nan_estimates": float(missing.sum())}
    if errors.moving is not None:
        moving = scored & errors.moving
        values["moving_share"] = float(moving.sum() / scored.sum())
        values |= {f"moving_{name}": value for name, value in rms_deg(errors, moving).items()}
    return Score(
        estimator=run.estimator,
        reference=truth.kind + (f", {truth.accuracy}" if truth.accuracy else ""),
        values=values,
        samples=int(scored.sum()),
        notes=_notes(errors.t, missing, int(scored.sum()), truth.kind, skip) + _steep(attitude_of(run)[scored]),
    )


def rms(values: Array) -> float:
    """Return the root mean square of ``values`` (n,); NaN if there are none or one of them is NaN."""
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else float("nan")


def rms_deg(errors: AttitudeErrors, scored: BoolArray) -> dict[str, float]:
    """Return ``total_deg``, ``heading_deg`` and ``inclination_deg``, rms over the samples ``scored`` (n,)."""
    return {f"{name}_deg": rms(getattr(errors, name)[scored]) / DEG for name in ("total", "heading", "inclination")}


def _euler_deg(euler: Array) -> dict[str, float]:
    values = {}
    for name, error in zip(("roll", "pitch", "yaw"), euler.T / DEG, strict=True):
        values[f"{name}_rms_deg"] = rms(error)
        values[f"{name}_min_deg"] = float(error.min())
        values[f"{name}_max_deg"] = float(error.max())
    return values


def _notes(t: Array, missing: BoolArray, scored: int, kind: str, skip: float) -> tuple[str, ...]:
    notes = []
    if kind == "estimate":
        notes.append(NOT_AN_ERROR)
    if missing.any():
        first = t[np.flatnonzero(missing)[0]]
        notes.append(f"{int(missing.sum())} of {scored} scored estimates are NaN, the first at {first:.3f} s: no score")
    if skip > 0:
        notes.append(f"the first {skip:g} s are left out")
    return tuple(notes)


def _steep(q_nb: Array) -> tuple[str, ...]:
    pitch = np.abs(euler_from_quat(q_nb)[:, 1])
    steepest = float(np.max(pitch[np.isfinite(pitch)], initial=0.0))
    if steepest < STEEP:
        return ()
    return (f"pitch reaches {steepest / DEG:.0f} deg: judge by total, heading and inclination, not by roll and yaw",)
