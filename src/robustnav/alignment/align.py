"""Alignment of a whole recording: attitude, how good it is, and whether heading can be had at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robustnav.alignment.bank import Aligner
from robustnav.alignment.readings import reading_rows, zero_velocity
from robustnav.alignment.setting import AlignSetup
from robustnav.engine import _kernel
from robustnav.errors import InputError
from robustnav.frames import Array, quat_from_rotvec, quat_multiply, quat_normalize, wrap_angle
from robustnav.records import BoolArray, check_time
from robustnav.strapdown.increments import Increments
from robustnav.units import ARCMIN

BACKENDS = ("compiled", "compiled-float", "numpy")
ANSWER = 22
HEADING_KNOWN = 0.88  # concentration of a heading known to half a radian
TILT_GOAL = 10.0 * ARCMIN  # rad
RADIUS_95 = 2.4477  # of a plane normal distribution, in standard deviations


@dataclass(frozen=True)
class Alignment:
    """What an alignment said after each reading; rows are NaN in the first two seconds.

    Parameters
    ----------
    t : (n,) [s].
    q_nb : (n, 4) attitude, heading included even where it is not observable.
    tilt_cov : (n, 2, 2) covariance of the tilt [rad^2] about two level axes fixed by the start, not north and east.
    heading, heading_sd : (n,) of the forward axis, and its standard deviation [rad].
    heading_observable : (n,) whether the heading is known to better than about half a radian.
    gyro_bias, accel_bias : (n, 3) [rad/s], [m/s^2].
    wind : (n, 2) what the reference velocity shows besides its noise, as the reference's axes have it [m/s].
    compass_bias, compass_bias_sd : (n,) constant error of the compass [rad]; NaN without one.
    tilt_goal : radius [rad] for ``aligned_at``.
    """

    t: Array
    q_nb: Array
    tilt_cov: Array
    heading: Array
    heading_sd: Array
    heading_observable: BoolArray
    gyro_bias: Array
    accel_bias: Array
    wind: Array
    compass_bias: Array
    compass_bias_sd: Array
    tilt_goal: float = TILT_GOAL

    @property
    def tilt_radius(self) -> Array:
        """Radius (n,) [rad] within which the tilt is with 95 %, or more for an uneven covariance."""
        trace = np.trace(self.tilt_cov, axis1=1, axis2=2)
        gap = np.hypot(self.tilt_cov[:, 0, 0] - self.tilt_cov[:, 1, 1], 2 * self.tilt_cov[:, 0, 1])
        out: Array = RADIUS_95 * np.sqrt(0.5 * (trace + gap))
        return out

    @property
    def aligned_at(self) -> float:
        """First time [s] at which the tilt radius is within the goal; NaN if never."""
        ready = np.flatnonzero(self.tilt_radius < self.tilt_goal)
        return float(self.t[ready[0]]) if ready.size else float("nan")


def align(
    increments: Increments,
    reference: ArrayLike | None,
    t: ArrayLike,
    setup: AlignSetup,
    backend: str = "compiled",
    *,
    field_b: ArrayLike | None = None,
) -> Alignment:
    """Align a unit on a swaying base in wind, causally, from any heading and tilt, without a prior of either.

    Parameters
    ----------
    increments : n of them, from ``strapdown.preintegrate``, of ``setup.period`` each.
    reference : (n, 2) velocity north and east at the end of each period [m/s]: base, wind and noise; NaN where missing.
        None for a base at rest: ``zero_velocity``, with ``setup.reference_sd`` the base's own tremble.
    t : (n,) end of each period [s], ``setup.period`` apart.
    setup : place, sensors and noise.
    backend : ``compiled``, ``compiled-float`` for the single-precision kernel, or ``numpy``.
    field_b : (n, 3) magnetic field in body axes, any unit, at the end of each period; NaN where missing.

    Raises
    ------
    InputError : shapes, increments of another length, times that are not the period apart, an unknown backend, a
        magnetic field without the setup's compass.

    Notes
    -----
    The base is at rest but for sway: its own velocity, up to about 1 m/s, counts as disturbance.
    """
    velocity = zero_velocity(increments) if reference is None else reference
    rows, times = reading_rows(increments, velocity, field_b), np.ascontiguousarray(t, float)
    check_time(times, "alignment")
    if times.shape != (len(rows),):
        raise InputError("time of alignment", got=f"shape {times.shape}", expected=f"shape ({len(rows)},)")
    if abs(increments.dt - setup.period) > 1e-6 * setup.period:
        raise InputError("increments", got=f"{increments.dt} s each", expected=f"{setup.period} s, the setup's period")
    late = np.flatnonzero(np.abs(np.diff(times) - setup.period) > 0.01 * setup.period)
    if late.size:
        raise InputError(
            "time of alignment",
            place=f"row {late[0] + 1}",
            got=f"{times[late[0] + 1] - times[late[0]]:.6f} s after the last",
            expected=f"{setup.period} s, the setup's period",
            do="pre-integrate without gaps; mark missing reference velocities with NaN",
        )
    if backend not in BACKENDS:
        raise InputError("backend", got=repr(backend), expected=" or ".join(map(repr, BACKENDS)))
    if field_b is None:
        setup = setup.without_compass()
    elif setup.compass is None:
        raise InputError(
            "magnetic field",
            got="an alignment setup without a compass",
            expected="declination, compass_sd and compass_bias_sd",
            do="state them in the setup, or leave the field out",
        )
    return _record(times, _numpy(rows, setup) if backend == "numpy" else _compiled(rows, setup, backend))


def _numpy(rows: Array, setup: AlignSetup) -> Array:
    aligner, out = Aligner(setup), np.full((len(rows), ANSWER), np.nan)
    for k, row in enumerate(rows):
        aligner.step(row)
        said = aligner.read()
        if said is not None:
            out[k] = said.row
    return out


def _compiled(rows: Array, setup: AlignSetup, backend: str) -> Array:
    out = np.empty((len(rows), ANSWER))
    state: Any = _kernel.align_begin("float" if backend == "compiled-float" else "double", setup.numbers)
    _kernel.align_run(state, rows, 1, out)
    return out


def _record(t: Array, rows: Array) -> Alignment:
    q = quat_multiply(quat_from_rotvec(np.column_stack([rows[:, 4:6], np.zeros(len(rows))])), rows[:, :4])
    # The wander attitude's own azimuth, then the turn that makes it the heading.
    azimuth = np.arctan2(2 * (q[:, 1] * q[:, 2] + q[:, 0] * q[:, 3]), 1 - 2 * (q[:, 2] ** 2 + q[:, 3] ** 2))
    turn = wrap_angle(rows[:, 9] - azimuth)
    q_nb = quat_multiply(quat_from_rotvec(np.outer(turn, [0.0, 0.0, 1.0])), q)
    return Alignment(
        t=t,
        q_nb=quat_normalize(q_nb),
        tilt_cov=rows[:, [6, 7, 7, 8]].reshape(-1, 2, 2),
        heading=rows[:, 9],
        heading_sd=np.sqrt(rows[:, 10]),
        heading_observable=rows[:, 11] > HEADING_KNOWN,
        gyro_bias=rows[:, 12:15],
        accel_bias=rows[:, 15:18],
        wind=rows[:, 18:20],
        compass_bias=rows[:, 20],
        compass_bias_sd=np.sqrt(rows[:, 21]),
    )
