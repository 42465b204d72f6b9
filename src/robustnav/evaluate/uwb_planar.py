"""Planar pose against motion capture: where a body that stays level is, and which way it heads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.position import distance_figures, effective_samples, position_at
from robustnav.evaluate.reference import reference_at
from robustnav.frames import euler_from_quat, wrap_angle
from robustnav.records import Array, Stream, Truth
from robustnav.units import DEG


@dataclass(frozen=True)
class PlanarPose:
    """Poses at ``t`` (n,) [s]: ``xy`` (n, 2) [m] and ``yaw`` (n,) [rad] about z down, frame a; NaN where unknown."""

    t: Array
    xy: Array
    yaw: Array


@dataclass(frozen=True)
class PoseReference:
    """Motion capture and how it relates to the estimates.

    Parameters
    ----------
    position, attitude : (n, 3) [m] and ``q_ab`` (n, 4) at common times, frame a, level within a few degrees.
    clock : an estimate of time t is compared with the reference of t + clock [s].
    yaw : of the estimates' body axes in the reference's [rad].
    """

    position: Stream
    attitude: Stream
    clock: float = 0.0
    yaw: float = 0.0

    def at(self, t: Array) -> PlanarPose:
        """Return the pose that estimates of times ``t`` (n,) [s] should have; NaN where there is no reference."""
        later = t + self.clock
        xy = position_at(self.position.t, self.position.values, later)[:, :2]
        q_ab = reference_at(Truth(self.attitude.t, self.attitude.values), later).q_nb
        return PlanarPose(t, xy, euler_from_quat(q_ab)[:, 2] + self.yaw)


def planar_figures(pose: PlanarPose, reference: PoseReference) -> dict[str, float]:
    """Return the figures of planar poses over all times with a reference.

    Returns
    -------
    ``rmse_2d`` with interval, ``median_2d``, ``p95_2d``, ``max_2d`` [m]; ``yaw_rmse_deg``, ``yaw_mean_deg``;
    ``samples``, ``independent``, ``nan_estimates``, which make the figures NaN.

    Raises
    ------
    InputError : shapes that do not fit, a reference that is empty or no attitude, or nothing to score.
    """
    n = len(pose.t)
    if pose.xy.shape != (n, 2) or pose.yaw.shape != (n,):
        got = f"xy {pose.xy.shape}, yaw {pose.yaw.shape}"
        raise InputError("planar pose", got=got, expected=f"xy ({n}, 2), yaw ({n},)")
    true = reference.at(pose.t)
    there = np.isfinite(true.xy).all(axis=1) & np.isfinite(true.yaw)
    if not there.any():
        expected = "poses on the clock of the reference"
        raise InputError("nothing to score", got=f"{n} poses, none with a reference", expected=expected)
    squares = np.sum((pose.xy - true.xy)[there] ** 2, axis=1)
    yaw = wrap_angle(pose.yaw - true.yaw)[there]
    return distance_figures(squares, "2d") | {
        "yaw_rmse_deg": float(np.sqrt(np.mean(yaw**2))) / DEG,
        "yaw_mean_deg": float(np.mean(yaw)) / DEG,
        "samples": float(len(yaw)),
        "independent": effective_samples(squares),
        "nan_estimates": float(np.count_nonzero(np.isnan(squares + yaw))),
    }
