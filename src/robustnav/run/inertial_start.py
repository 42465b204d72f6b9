"""Where an inertial filter starts without a prior: tilt from specific force, place from ranges, every heading."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.frames import (
    Array,
    matrix_from_quat,
    quat_conjugate,
    quat_from_euler,
    quat_from_rotvec,
    quat_multiply,
    rotate,
    skew,
)
from robustnav.model.blocks import Model
from robustnav.records import IntArray
from robustnav.run.acquisition import Acquisition
from robustnav.run.loop import Start
from robustnav.run.task import Task
from robustnav.run.tracking_task import RANGING, TrackingTask
from robustnav.snapshot.window import Minimum
from robustnav.units import DEG

_MOST_TILT = 30 * DEG  # standard deviation beyond which a linearised filter is not worth starting


@dataclass(frozen=True)
class InertialStart:
    """How an inertial filter is started, and restarted when it is lost.

    Parameters
    ----------
    headings : filters that begin with headings all round.
    average : tilt comes from the specific force of this time before the start [s].
    found_sd : the heading counts as found once its standard deviation over all filters is below this [rad].
    acquisition : of the position.  Its ``speed`` is also the standard deviation of the start's velocity on each axis.

    Raises
    ------
    InputError : fewer than four headings, or a number that is not positive.
    """

    headings: int = 12
    average: float = 1.0
    found_sd: float = 5 * DEG
    acquisition: Acquisition = field(default_factory=Acquisition)

    def __post_init__(self) -> None:
        check_start(self.headings, average=self.average, found_sd=self.found_sd)


def check_start(headings: int, **positive: float) -> None:
    """Raise ``InputError`` for fewer than four headings, or a number that is not above zero."""
    if headings < 4:
        raise InputError("inertial start headings", got=str(headings), expected="4 or more")
    for name, value in positive.items():
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"inertial start {name}", got=str(value), expected="a number above zero")


def turned_to_last(task: Task, rows: IntArray) -> tuple[Array, Array]:
    """Return the specific force (m, 3) [m/s^2] of whole rows, turned to the body axes of the last one.

    With it the quaternions (m, 4) from the body axes of each row to those of the last one, by the gyro.
    """
    feed, names = task.feed, [b.name for b in task.estimator.model.inputs]
    gyro, accel = (feed.u[rows, 3 * k : 3 * k + 3] for k in (names.index("gyro"), names.index("accel")))
    steps = quat_from_rotvec(gyro[1:] * np.diff(feed.t[rows])[:, None])
    back = np.vstack([[1.0, 0.0, 0.0, 0.0], quat_conjugate(steps)[::-1]])
    reach = 1
    while reach < len(back):  # products of all steps so far, twice as many each time
        back[reach:] = quat_multiply(back[:-reach], back[reach:])
        reach *= 2
    turns = back[::-1]
    return rotate(turns, accel), turns


@dataclass(frozen=True)
class Level:
    """Which way is down at one instant: median specific force ``f_b`` (3,) there, and what motion adds to it [m/s^2].

    At rest ``unsteady`` is the noise; a carrier that accelerates shows it by readings that change while it turns and
    by a middle that is not as large as gravity.  A knock leaves the median alone.
    """

    f_b: Array
    unsteady: float

    @classmethod
    def at(cls, task: TrackingTask, row: int, seconds: float) -> Level:
        """Take the median of the last ``seconds`` before a row, turned by the gyro to the axes there.

        Raises
        ------
        EstimatorError : no input there.
        """
        feed = task.feed
        rows = np.flatnonzero(feed.whole[: row + 1] & (feed.t[: row + 1] >= feed.t[row] - seconds))
        if not rows.size:
            place = f"{seconds:g} s before {feed.t[row]:.3f} s"
            raise EstimatorError("no inertial reading to level on", place=place, expected="finite gyro and accel")
        turned, _ = turned_to_last(task, rows)
        f_b = np.median(turned, axis=0)
        spread = float(np.sqrt(np.mean(np.sum((turned - f_b) ** 2, axis=1))))
        return cls(f_b, float(np.hypot(spread, np.linalg.norm(f_b) - task.estimator.model.parameters["gravity"])))

    def q_nb(self, yaw: float) -> Array:
        """Return the attitude (4,) at a heading [rad] if the carrier were at rest."""
        down = -self.f_b / np.linalg.norm(self.f_b)
        return quat_from_euler([np.arctan2(down[1], down[2]), -np.arcsin(np.clip(down[0], -1.0, 1.0)), yaw])


def heading_starts(task: TrackingTask, row: int, found: Minimum, settings: InertialStart) -> list[Start]:
    """Return a start for each heading, with all that its errors have in common: tilt, accelerometer bias and place.

    The tilt errs by what motion and the accelerometer's bias add to gravity, and the carrier stands off the tag by the
    lever arm of the readings, turned by an attitude that errs.  Written as errors ``e = M z`` of independent ``z``:
    the tag's place, motion, heading, and the rest of the state.
    """
    level = Level.at(task, row, settings.average)
    lever_b = _lever(task)
    spacing = 2 * np.pi / settings.headings
    return [_start(task, found, level, lever_b, k * spacing, spacing / 2) for k in range(settings.headings)]


def _start(task: TrackingTask, found: Minimum, level: Level, lever_b: Array, yaw: float, yaw_sd: float) -> Start:
    model, settings = task.estimator.model, task.settings
    gravity, part = model.parameters["gravity"], model.error_slices
    turn, place = part["q_nb"], part["p_n"]
    x, q_nb = model.nominal_state(), level.q_nb(yaw)
    C_nb = matrix_from_quat(q_nb)
    x[model.state_slices["q_nb"]] = q_nb
    x[model.state_slices["p_n"]] = found.p - C_nb @ lever_b
    Z = model.start_covariance()
    Z[part["v_n"], part["v_n"]] = settings.speed**2 * np.eye(3)
    Z[place, place] = found.P + (settings.speed * task.tau / 2) ** 2 * np.eye(3)
    tilt_sd = min(level.unsteady / gravity, _MOST_TILT)
    Z[turn, turn] = np.diag([tilt_sd, tilt_sd, yaw_sd]) ** 2
    tilted = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]) @ C_nb / gravity  # by the bias
    return Start(x, correlated(model, Z, tilted, C_nb @ lever_b))


def correlated(model: Model, Z: Array, tilted: Array, lever_n: Array) -> Array:
    """Return the covariance (ne, ne) of a start's errors ``e = M z`` of those ``z`` with covariance ``Z``.

    The accelerometer's bias turns the attitude by ``tilted`` (3, 3) [rad per m/s^2], the attitude moves the place by
    the lever arm ``lever_n`` (3,) [m].
    """
    turn, place, bias = (model.error_slices[name] for name in ("q_nb", "p_n", "accel_bias"))
    M = np.eye(len(Z))
    M[turn, bias] = tilted
    M[place, turn] = skew(lever_n)
    M[place, bias] = skew(lever_n) @ tilted
    out: Array = M @ Z @ M.T
    return out


def _lever(task: TrackingTask) -> Array:
    """Return the lever arm (3,) [m] that travels with the ranging readings, the last of what does."""
    for sensor, data in zip(task.estimator.model.sensors, task.feed.sensors, strict=True):
        if data is not None and sensor.name in RANGING:
            lever_b: Array = data.z[0, -3:]
            return lever_b
    return np.zeros(3)
