"""What was said of a carrier in motion, as pages and tables of an alignment take it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.frames import euler_from_quat
from robustnav.records import Array, BoolArray, Run
from robustnav.report.alignment_course import RADIUS_95
from robustnav.run.inertial_course import found_at


@dataclass(frozen=True)
class MovingCourse:
    """A ``Course`` of a carrier in motion, NaN before it was started; ``p_n`` (n, 3) is where it was [m].

    It counts as aligned when its heading was found, and has no goal for its tilt.
    """

    t: Array
    q_nb: Array
    tilt_radius: Array
    heading_sd: Array
    heading_observable: BoolArray
    gyro_bias: Array
    accel_bias: Array
    p_n: Array
    aligned_at: float
    tilt_goal: float = float("nan")

    @property
    def heading(self) -> Array:
        """Of the forward axis (n,) [rad]."""
        heading: Array = euler_from_quat(self.q_nb)[:, 2]
        return heading

    @property
    def wind(self) -> Array:
        """Not looked for (n, 2)."""
        return np.full((len(self.t), 2), np.nan)


def moving_course(run: Run, begin: float, period: float, found_sd: float) -> MovingCourse:
    """Return what a run of ``align_moving`` said, every ``period`` [s] from the recording's ``begin`` [s] on.

    The heading counts as observable where its standard deviation is at most ``found_sd`` [rad].
    """
    waiting = np.arange(begin + period, run.t[0] - period / 2, period)
    rows = np.searchsorted(run.t, np.arange(run.t[0], run.t[-1], period))
    rows = np.unique(np.append(rows, len(run.t) - 1))

    def told(values: Array) -> Array:
        nothing = np.full((len(waiting), *values.shape[1:]), np.nan)
        return np.concatenate([nothing, values[rows]])

    heading_sd = told(run.sd["q_nb"][:, 2])
    found = found_at(run.events)
    return MovingCourse(
        t=np.concatenate([waiting, run.t[rows]]),
        q_nb=told(run.state["q_nb"]),
        tilt_radius=told(RADIUS_95 * run.sd["q_nb"][:, :2].max(axis=1)),
        heading_sd=heading_sd,
        heading_observable=heading_sd <= found_sd,
        gyro_bias=told(run.state["gyro_bias"]),
        accel_bias=told(run.state["accel_bias"]),
        p_n=told(run.state["p_n"]),
        aligned_at=found[0] if found else np.nan,
    )
