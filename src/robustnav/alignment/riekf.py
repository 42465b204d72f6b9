"""A right-invariant extended Kalman filter over many runs at once: the single-pass rival in the alignment study.

Error ``C = Exp(theta) C^``, ``V = Exp(theta) V^ + nu``, biases additive, in the order theta, nu, gyro bias,
accelerometer bias.  The covariance is carried along with every correction of attitude (docs/alignment.md, section 4):
without that a velocity estimate that has taken up the mean wind makes a filter believe it has measured heading.  Two
exact corrections: ``first order`` adds nu to the turned velocity; ``lie`` moves along the group SE2(3).
Barrau, Bonnabel, IEEE Transactions on Automatic Control 62(4), 2017, section III.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robustnav.alignment.setting import AlignSetup
from robustnav.earth import earth_rate_n
from robustnav.errors import InputError
from robustnav.frames import Array, matrix_from_quat, quat_from_matrix, quat_from_rotvec, skew

THETA, NU, GYRO, ACCEL = (slice(k, k + 3) for k in range(0, 12, 3))
SIZE = 12
VELOCITY_SD = 3.0  # m/s, at the start
SMALL = 1e-4  # rad; below it a turn and its left Jacobian are their series
NEGLIGIBLE = 1e-12  # size of a term of the group's Jacobian
Correction = Literal["first order", "lie"]


@dataclass(frozen=True)
class InvariantStart:
    """Where runs start: ``q_nb`` (runs, 4), its sd (runs, 3) about north, east, down [rad]; velocity is 0 +- 3 m/s."""

    q_nb: Array
    sd: Array


@dataclass(frozen=True)
class InvariantRun:
    """What the filter said at the start and after each reading.

    ``q_nb`` (runs, n + 1, 4), ``v_n`` (runs, n + 1, 3) [m/s], ``P`` (runs, n + 1, 3, 3) covariance of theta [rad^2] in
    navigation axes.
    """

    q_nb: Array
    v_n: Array
    P: Array


@dataclass
class Belief:
    """What is known of m runs: ``C`` (m, 3, 3), ``v``, ``gyro``, ``accel`` (m, 3), ``P`` (m, 12, 12)."""

    C: Array
    v: Array
    gyro: Array
    accel: Array
    P: Array


@dataclass(frozen=True)
class Step:
    """What stays the same from step to step: period [s], Earth rate and turn, gravity, variances of a step, weight."""

    T: float
    w: Array
    earth: Array
    g: Array
    gyro_var: float
    accel_var: float
    walk: Array
    R: Array


def invariant_ekf(
    rows: Array, z: Array, start: InvariantStart, setup: AlignSetup, correction: Correction = "first order"
) -> InvariantRun:
    """Run the filter over several runs.

    Parameters
    ----------
    rows : (runs, n, 25) pre-integrated increments: rotation 4, velocity 3, J 9, H 9.
    z : (runs, n, 3) velocity north, east, down at the end of each period [m/s].
    start : of each run.
    setup : place and sensors; ``reference_sd`` is the weight of a reading.
    correction : how a correction is applied, and the covariance with it.

    Raises
    ------
    InputError : shapes that do not fit each other.
    """
    m, n = z.shape[:2]
    if rows.shape != (m, n, 25) or z.shape != (m, n, 3) or start.q_nb.shape != (m, 4) or start.sd.shape != (m, 3):
        got = f"rows {rows.shape}, z {z.shape}, start {start.q_nb.shape} and {start.sd.shape}"
        raise InputError("invariant_ekf", got=got, expected="(runs, n, 25), (runs, n, 3), (runs, 4) and (runs, 3)")
    step, belief = step_of(setup), _start(start, setup)
    C, v, P = np.empty((m, n + 1, 3, 3)), np.empty((m, n + 1, 3)), np.empty((m, n + 1, 3, 3))
    C[:, 0], v[:, 0], P[:, 0] = belief.C, belief.v, belief.P[:, THETA, THETA]
    turns = matrix_from_quat(rows[..., :4])
    for k in range(n):
        predict(belief, turns[:, k], rows[:, k], step)
        _correct(belief, z[:, k], step, correction)
        C[:, k + 1], v[:, k + 1], P[:, k + 1] = belief.C, belief.v, belief.P[:, THETA, THETA]
    return InvariantRun(quat_from_matrix(C), v, P)


def turn_and_jacobian(theta: Array) -> tuple[Array, Array]:
    """Return Exp(theta) and J_l(theta) (..., 3, 3): Exp(theta + J_l^-1 d) = Exp(d) Exp(theta) to first order in d."""
    a2 = np.sum(theta**2, axis=-1)[..., None, None]
    small, a = a2 < SMALL**2, np.sqrt(np.maximum(a2, SMALL**2))
    sine = np.sin(a)
    none = np.where(small, 1 - a2 / 6, sine / a)
    first = np.where(small, 0.5 - a2 / 24, (1 - np.cos(a)) / a**2)
    second = np.where(small, 1 / 6 - a2 / 120, (a - sine) / a**3)
    K = skew(theta)
    square = K @ K
    return np.eye(3) + none * K + first * square, np.eye(3) + first * K + second * square


def step_of(setup: AlignSetup) -> Step:
    """Return what a setup makes of every step."""
    T = setup.period
    walk = T * np.repeat([setup.gyro_bias_walk**2, setup.accel_bias_walk**2], 3)
    return Step(
        T=T,
        w=earth_rate_n(setup.latitude),
        earth=matrix_from_quat(quat_from_rotvec(-T * earth_rate_n(setup.latitude))),
        g=np.array([0.0, 0.0, setup.gravity]),
        gyro_var=setup.gyro_density**2 * T,
        accel_var=setup.accel_density**2 * T,
        walk=np.diag(walk),
        R=setup.reference_sd**2 * np.eye(3),
    )


def _start(start: InvariantStart, setup: AlignSetup) -> Belief:
    m = len(start.q_nb)
    rest = np.repeat([VELOCITY_SD, setup.gyro_bias_sd, setup.accel_bias_sd], 3)
    sd = np.hstack([start.sd, np.tile(rest, (m, 1))])
    v, gyro, accel = np.zeros((3, m, 3))
    return Belief(matrix_from_quat(start.q_nb), v, gyro, accel, sd[:, :, None] ** 2 * np.eye(SIZE))


def transition(belief: Belief, turn: Array, row: Array, step: Step) -> tuple[Array, Array, Array]:
    """Return the error's transition, and attitude and velocity after a step, all from ``belief``.

    ``turn`` (m, 3, 3) is the rotation in ``row`` (m, 25).  Of the transition the six rows (m, 6, 12) of theta and nu:
    biases stay.
    """
    J, H = row[:, 7:16].reshape(-1, 3, 3), row[:, 16:].reshape(-1, 3, 3)
    CJ, CH, W = belief.C @ J, belief.C @ H, skew(step.w)
    a = _times(belief.C, row[:, 4:7]) - _times(CJ, belief.accel) - _times(CH, belief.gyro)
    v = belief.v + a + step.T * (step.g - (2 * belief.v + a / 2) @ W.T)
    C = step.earth @ belief.C @ turn_and_jacobian(-_times(J, belief.gyro))[0] @ turn
    F = np.zeros((len(row), 6, SIZE))
    F[:, THETA, THETA] = step.earth
    F[:, THETA, GYRO] = F[:, NU, ACCEL] = -CJ
    F[:, NU, THETA] = step.T * skew(step.g)
    F[:, NU, NU] = np.eye(3) - 2 * step.T * W
    F[:, NU, GYRO] = -CH - skew(v) @ CJ
    return F, C, v


def predict(belief: Belief, turn: Array, row: Array, step: Step) -> None:
    """Move ``belief`` by increments, as ``transition``; gyro noise turns the velocity estimate too."""
    F, belief.C, belief.v = transition(belief, turn, row, step)
    P, V = belief.P, skew(belief.v)
    moved = F @ P
    P[:, : NU.stop, : NU.stop] = moved @ F.swapaxes(1, 2)
    P[:, : NU.stop, NU.stop :] = moved[:, :, NU.stop :]
    P[:, NU.stop :, : NU.stop] = moved[:, :, NU.stop :].swapaxes(1, 2)
    P[:, THETA, THETA] += step.gyro_var * np.eye(3)
    P[:, NU, THETA] += step.gyro_var * V
    P[:, THETA, NU] -= step.gyro_var * V
    P[:, NU, NU] += step.accel_var * np.eye(3) - step.gyro_var * V @ V
    P[:, NU.stop :, NU.stop :] += step.walk


def _correct(belief: Belief, z: Array, step: Step, correction: Correction) -> None:
    """Kalman's update, H = (-skew(v), I, 0, 0), then the turn of estimate and covariance by the correction."""
    V = skew(belief.v)
    PH = belief.P[:, :, NU] + belief.P[:, :, THETA] @ V
    K = np.linalg.solve(PH[:, NU] - V @ PH[:, THETA] + step.R, PH.swapaxes(1, 2)).swapaxes(1, 2)
    dx = _times(np.asarray(K, float), z - belief.v)
    P = belief.P - K @ PH.swapaxes(1, 2)
    belief.C, belief.v, G = moved(belief.C, belief.v, dx[:, : NU.stop], correction)
    belief.gyro, belief.accel = belief.gyro + dx[:, GYRO], belief.accel + dx[:, ACCEL]
    P[:, : NU.stop] = G @ P[:, : NU.stop]
    P[:, :, : NU.stop] = P[:, :, : NU.stop] @ G.swapaxes(1, 2)
    belief.P = (P + P.swapaxes(1, 2)) / 2


def moved(C: Array, v: Array, dx: Array, correction: Correction) -> tuple[Array, Array, Array]:
    """Return attitude (m, 3, 3) and velocity (m, 3) moved by ``dx`` (m, 6), theta and nu, and what that does to errors.

    The last, G (m, 6, 6), takes an error about ``dx`` before the move to the error after it, to first order.
    """
    theta, nu = dx[:, :3], dx[:, 3:]
    turn, J = turn_and_jacobian(theta)
    G = np.zeros((len(dx), 6, 6))
    if correction == "first order":
        G[:, :3, :3], G[:, 3:, :3], G[:, 3:, 3:] = J, skew(nu) @ J, np.eye(3)
        return turn @ C, _times(turn, v) + nu, G
    ad = np.zeros_like(G)
    ad[:, :3, :3] = ad[:, 3:, 3:] = skew(theta)
    ad[:, 3:, :3] = skew(nu)
    G += np.eye(6)
    term, k, size, largest = G.copy(), 1, 1.0, float(np.abs(dx).sum(axis=1).max())
    while size > NEGLIGIBLE:  # sum of ad^k / (k + 1)!
        k, size = k + 1, size * largest / (k + 1)
        term = term @ ad / k
        G += term
    return turn @ C, _times(turn, v) + _times(J, nu), G


def _times(matrices: Array, vectors: Array) -> Array:
    out: Array = np.einsum("nij,nj->ni", matrices, vectors)
    return out
