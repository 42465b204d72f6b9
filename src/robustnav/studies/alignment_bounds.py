"""What is left when the wind is known, or the sensors' biases alone err, and single winds to hold ``align`` against."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robustnav.alignment.align import ANSWER
from robustnav.alignment.level import first_velocity, level_attitude
from robustnav.alignment.readings import VELOCITY, reading_rows
from robustnav.alignment.setting import MOST_LINES, Wind
from robustnav.engine import _kernel
from robustnav.frames import Array, matrix_from_quat, quat_from_rotvec, quat_multiply, wrap_angle
from robustnav.sim.alignment import AlignmentData
from robustnav.studies.alignment_errors import Followed, heading_of, tilt_error
from robustnav.studies.alignment_figures import AFTER, LASTING, tilt_after
from robustnav.studies.alignment_setting import setup_of

CALM = Wind(0.0, 4.0)
# Single winds to hold align against. The study's own Gauss-Markov wind is one of them; the bank of align lacks it.
TRIED = (
    CALM,
    Wind(0.1, 2.0),
    Wind(0.2, 4.0),
    Wind(0.5, 4.0),
    Wind(1.5, 4.0),
    Wind(0.5, 1.0),
    Wind(0.15, 16.0),
    Wind(0.4, 16.0),
    Wind(1.0, 16.0),
)
LEVELLED = 20  # readings that level the start
STATES = 41  # of the compiled filter; its attitude takes one number more


def floor(data: AlignmentData) -> Followed:
    """Return the errors that the true biases leave to who knows everything else: perfect gyros and reference, no wind.

    Level: the force bias seen as gravity's direction.  Heading: the east rate bias seen as a turn of the Earth's rate.
    Both are averaged since the start, the sway included; a heading error ends at half a turn.
    """
    C = matrix_from_quat(data.q_nb).mean(axis=0)
    since = np.arange(1, len(data.q_nb) + 1)[:, None]
    force, rate = (np.cumsum(bias @ C.T, axis=0) / since for bias in (data.accel_bias, data.gyro_bias))
    place, n = data.scenario.place, len(since)
    tilt = np.column_stack([force[:, 1], -force[:, 0]]) / place.gravity_n[2]
    heading = np.clip(rate[:, 1] / place.earth_rate_n[0], -np.pi, np.pi)
    return Followed(tilt, np.full((n, 2, 2), np.nan), heading, np.full(n, np.nan), np.zeros(n, bool))


def told(data: AlignmentData) -> Followed:
    """Return one filter of ``align`` on the reference with the true wind, gusts included, taken off."""
    return one_wind(data, (data.velocity.values - data.wind_n)[:, :2], CALM)


def fixed_winds(data: AlignmentData) -> dict[str, float]:
    """Return the tilt [arcmin] some time after the start or the wind's change, of one filter by the wind it is told.

    Winds are those of ``TRIED``, and the lines of the scenario, if any, with their true frequencies.
    """
    winds = {f"{wind.markov_sd:g} m/s, {wind.markov_time:g} s": wind for wind in TRIED}
    lines = tuple({line.frequency: None for part in data.scenario.wind for line in part.lines})
    if lines:
        winds["known lines"] = Wind(0.0, 4.0, lines, (0.0,) * len(lines))
    changed = data.scenario.wind[-1].start
    n = int(np.searchsorted(data.velocity.t, changed + AFTER + LASTING, "right"))
    reference = data.velocity.values[:n, :2]
    since = data.truth.t[: n + 1] - changed
    return {name: tilt_after(since, one_wind(data, reference, wind).tilt) for name, wind in winds.items()}


def one_wind(data: AlignmentData, reference: Array, wind: Wind) -> Followed:
    """Return what one filter of ``align``, told the wind's kind, makes of the first readings (n, 2) [m/s]."""
    rows, q_true = (
        reading_rows(data.increments.between(0, len(reference)), reference),
        data.q_nb[1 : len(reference) + 1],
    )
    omega = np.zeros((2, MOST_LINES))
    omega[:, : len(wind.omega)] = wind.omega, wind.omega_sd
    numbers = np.concatenate([[wind.markov_sd, wind.markov_time], omega.ravel()])
    said, likelihood = np.empty((len(rows), ANSWER)), np.empty(len(rows))
    start = level_attitude(rows[:LEVELLED]), first_velocity(rows[:LEVELLED, VELOCITY])
    setup = setup_of(data.scenario).numbers
    _kernel.align_one(
        "double", setup, numbers, *start, rows, said, likelihood, np.empty(STATES + 1), np.empty(STATES**2)
    )
    q = quat_multiply(quat_from_rotvec(np.column_stack([said[:, 4:6], np.zeros(len(said))])), said[:, :4])
    nothing = np.full((1, 2), np.nan)
    trace = np.append(np.nan, said[:, 6] + said[:, 8])
    return Followed(
        tilt=np.vstack([nothing, tilt_error(q_true, q)]),
        tilt_cov=trace[:, None, None] / 2 * np.eye(2),  # its mean radius, as for align
        heading=np.append(np.nan, wrap_angle(heading_of(q_true) - said[:, 9])),
        heading_sd=np.append(np.nan, np.sqrt(said[:, 10])),
        known=np.zeros(len(q) + 1, bool),
    )


LIMITS: dict[str, Callable[[AlignmentData], Followed]] = {"told": told, "floor": floor}  # by their names in BOUNDS
