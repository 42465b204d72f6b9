"""What an alignment said, held against the truth: tilt free of heading, heading, and how sure it was of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.alignment import Alignment
from robustnav.frames import Array, matrix_from_quat, quat_conjugate, quat_multiply, rotate, wrap_angle
from robustnav.records import BoolArray
from robustnav.sim.alignment import AlignmentData

DOWN = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Followed:
    """What one run of one method gave at the n + 1 instants; NaN where it said nothing.

    ``tilt`` (n + 1, 2) true minus estimated about north and east [rad], ``tilt_cov`` (n + 1, 2, 2) its covariance
    [rad^2]; ``heading`` (n + 1,) error of the forward axis and ``heading_sd`` (n + 1,) [rad]; ``known`` (n + 1,)
    whether the method said that heading can be had.
    """

    tilt: Array
    tilt_cov: Array
    heading: Array
    heading_sd: Array
    known: BoolArray

    @property
    def tilt_sd(self) -> Array:
        """Standard deviation (n + 1,) of both axes together [rad]."""
        out: Array = np.sqrt(np.trace(self.tilt_cov, axis1=1, axis2=2))
        return out


def tilt_error(q_true: Array, q_est: Array) -> Array:
    """Return the rotation (..., 2) [rad] about the estimate's north and east that levels it; its heading is free."""
    up = rotate(quat_multiply(q_est, quat_conjugate(q_true)), DOWN)
    size = np.hypot(up[..., 0], up[..., 1])
    turn = np.arctan2(size, up[..., 2]) / np.maximum(size, 1e-300)
    return np.stack([turn * up[..., 1], -turn * up[..., 0]], axis=-1)


def heading_of(q_nb: Array) -> Array:
    """Return the heading of the forward axis (...,) [rad]."""
    C = matrix_from_quat(q_nb)
    out: Array = np.arctan2(C[..., 1, 0], C[..., 0, 0])
    return out


def heading_error(q_true: Array, q_est: Array) -> Array:
    """Return true minus estimated heading of the forward axis (...,) [rad]."""
    return wrap_angle(heading_of(q_true) - heading_of(q_est))


def additive_covariance(quaternion: Array, P: Array) -> Array:
    """Return the covariance (..., 3, 3) of the rotation about n axes from that of an additive quaternion (..., 4, 4).

    ``Q_true = Exp(theta) * Q^`` moves the quaternion by ``(0, theta / 2) * Q^``; lengths are taken off.
    """
    length2 = np.sum(quaternion**2, axis=-1)[..., None, None]
    back = quat_multiply(np.eye(4), quat_conjugate(quaternion)[..., None, :])[..., 1:]  # rows: unit dQ to theta / 2
    out: Array = 4 * np.swapaxes(back, -1, -2) @ P @ back / length2**2
    return out


def judged(data: AlignmentData, q_nb: Array, P: Array) -> Followed:
    """Hold attitudes (n + 1, 4) and covariances (n + 1, 3, 3) about n axes, of a method that never doubts heading."""
    return Followed(
        tilt=tilt_error(data.q_nb, q_nb),
        tilt_cov=P[:, :2, :2],
        heading=heading_error(data.q_nb, q_nb),
        heading_sd=np.sqrt(P[:, 2, 2]),
        known=np.ones(len(q_nb), bool),
    )


def aligned(data: AlignmentData, said: Alignment) -> Followed:
    """Hold what ``align`` said; it says nothing of the start, where its first row is NaN."""
    n = len(data.q_nb)
    tilt, heading, sd, trace = np.full((n, 2), np.nan), *np.full((3, n), np.nan)
    tilt[1:], heading[1:] = tilt_error(data.q_nb[1:], said.q_nb), heading_error(data.q_nb[1:], said.q_nb)
    sd[1:], trace[1:] = said.heading_sd, np.trace(said.tilt_cov, axis1=1, axis2=2)
    # The covariance is about axes of its own, not north and east: its mean radius stands for it.
    cov = trace[:, None, None] / 2 * np.eye(2)
    return Followed(tilt, cov, heading, sd, np.append(False, said.heading_observable))
