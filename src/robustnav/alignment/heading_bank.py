"""The rival that knows the wind: filters with headings all round, the likeliest kept, the record filtered again.

Every filter has oscillators at the lines of the wind, whose frequencies must be told.  Each runs for a few seconds, is
carried back to the start with the attitude it found, and is judged by the likelihood of the record up to ``judged``;
the best is carried back once more and filters everything.  Until ``judged`` there is no answer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robustnav.alignment.setting import AlignSetup
from robustnav.alignment.wahba import wahba_attitude
from robustnav.engine.filters import Output, SensorData
from robustnav.errors import InputError
from robustnav.filter.steps import unpack
from robustnav.frames import Array, quat_from_rotvec, quat_multiply
from robustnav.models.alignment import AlignmentNoise
from robustnav.models.alignment_so3 import alignment_so3
from robustnav.run.estimators import EKF
from robustnav.run.loop import Start, stream
from robustnav.strapdown.increments import Increments
from robustnav.strapdown.static import Place, backtrack
from robustnav.units import DEG

COARSE_SD = (30 * DEG, 30 * DEG, 15 * DEG)
JUDGED_SD = (2 * DEG, 2 * DEG, 15 * DEG)
FINAL_SD = (1 * DEG, 1 * DEG, 15 * DEG)


@dataclass(frozen=True)
class HeadingBank:
    """How a bank is run.

    Parameters
    ----------
    lines : frequencies of the wind's lines [rad/s], or ones that cover their band.
    headings : filters all round.
    levelled : time each has to find the tilt [s].
    judged : time of the choice [s].
    velocity_sd : weight of a reading [m/s].
    """

    lines: tuple[float, ...]
    headings: int = 12
    levelled: float = 5.0
    judged: float = 60.0
    velocity_sd: float = 0.05


@dataclass(frozen=True)
class BankRun:
    """Attitude ``q_nb`` (n + 1, 4) and covariance ``P`` (n + 1, 3, 3) about n [rad^2]; NaN before the choice.

    ``costs`` (headings,) are minus log likelihood of each filter at the choice.
    """

    q_nb: Array
    P: Array
    costs: Array


def heading_bank(increments: Increments, velocity_n: ArrayLike, setup: AlignSetup, bank: HeadingBank) -> BankRun:
    """Align with a bank of headings, from no attitude at all: levelled by ``wahba_attitude``.

    Parameters
    ----------
    increments : n of them.
    velocity_n : (n, 3) reference velocity at the end of each [m/s].
    setup : place and sensors; its reference noise is not used.
    bank : how.

    Raises
    ------
    InputError : a recording shorter than ``judged``, and as ``alignment_so3`` and ``wahba_attitude``.
    """
    z = np.asarray(velocity_n, float)
    levelled, judged = round(bank.levelled / increments.dt), round(bank.judged / increments.dt)
    if not 2 <= levelled <= judged <= len(increments) == len(z):
        got = f"{len(increments)} increments, {len(z)} readings"
        raise InputError("heading bank", got=got, expected=f"as many of both, {judged} at least")
    place, runs = Place.at(setup.latitude), _Runs(increments, z, bank_estimator(setup, bank), setup)
    first = backtrack(
        wahba_attitude(increments.between(0, levelled), np.vstack([z[:1], z[:levelled]]), place),
        increments.between(0, levelled),
        place,
    )
    starts, costs = [], []
    for k in range(bank.headings):
        turn = quat_from_rotvec([0.0, 0.0, 2 * np.pi * k / bank.headings])
        found = runs.run(quat_multiply(turn, first), COARSE_SD, levelled)
        run = runs.run(runs.back(found, place), JUDGED_SD, judged)
        starts.append(runs.back(run, place))
        costs.append(_cost(run))
    last = runs.run(starts[int(np.argmin(costs))], FINAL_SD, len(increments))
    q_nb, P = last.x[:, :4].copy(), _attitude_covariance(last)
    q_nb[:judged], P[:judged] = np.nan, np.nan
    return BankRun(q_nb, P, np.array(costs))


@dataclass(frozen=True)
class _Runs:
    """The record, and the filter to run over it."""

    increments: Increments
    velocity_n: Array
    estimator: EKF
    setup: AlignSetup

    def run(self, q_nb: Array, sd: tuple[float, float, float], count: int) -> Output:
        """Filter the first ``count`` intervals from an attitude; everything else starts from its prior."""
        setup, T = self.setup, self.increments.dt
        spread: dict[str, ArrayLike] = {"q_nb": sd, "gyro_bias": setup.gyro_bias_sd, "accel_bias": setup.accel_bias_sd}
        running = stream(self.estimator, Start.at(self.estimator.model, spread, q_nb=q_nb))
        t: Array = T * np.arange(count + 1, dtype=np.float64)
        rows = self.increments.rows[:count]
        # The first row only sets the clock: no increment ends at the start.
        return running.run(t, np.vstack([rows[:1], rows]), [SensorData(t[1:], self.velocity_n[:count])])

    def back(self, run: Output, place: Place) -> Array:
        """Return the attitude (4,) at the start from a run's last attitude and gyro bias."""
        slices = self.estimator.model.state_slices
        last = run.x[-1]
        gone = self.increments.between(0, len(run.x) - 1)
        return backtrack(last[slices["q_nb"]], gone, place, last[slices["gyro_bias"]])


def bank_estimator(setup: AlignSetup, bank: HeadingBank) -> EKF:
    """Return the filter that a bank runs: attitude on SO(3) and the wind's lines."""
    noise = AlignmentNoise(
        gyro_density=setup.gyro_density,
        accel_density=setup.accel_density,
        gyro_bias_density=setup.gyro_bias_walk,
        accel_bias_density=setup.accel_bias_walk,
        velocity_sd=bank.velocity_sd,
    )
    place = Place.at(setup.latitude)
    north, _, down = place.earth_rate_n
    return EKF(
        alignment_so3(noise, gravity=setup.gravity, earth_rate_north=north, earth_rate_down=down, lines=bank.lines)
    )


def _cost(run: Output) -> float:
    """Return minus the log likelihood of a run's readings, up to a constant."""
    seen = run.seen[0]
    if seen is None:
        raise InputError("heading bank", got="no reading", expected="reference velocities")
    return float(0.5 * np.nansum(seen.nis[:, None] / seen.nu.shape[1] + np.log(seen.s)))


def _attitude_covariance(run: Output) -> Array:
    if run.P is None:
        raise InputError("heading bank", got="no covariance", expected="an extended Kalman filter")
    out: Array = unpack(run.P)[:, :3, :3]
    return out
