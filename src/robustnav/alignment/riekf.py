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
from robustnav.frames import Array, matrix_from_quat, quat_from_rotvec, quat_multiply, quat_normalize, rotate, skew

THETA, NU, GYRO, ACCEL = (slice(k, k + 3) for k in range(0, 12, 3))
SIZE = 12
VELOCITY_SD = 3.0  # m/s, at the start
SMALL = 1e-4  # rad; below it the left Jacobian is its series
TERMS = 20  # of the group's Jacobian; turns stay below pi, the last term below 1e-9
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
    """What is known of m runs: ``q`` (m, 4), ``v``, ``gyro``, ``accel`` (m, 3), ``P`` (m, 12, 12)."""

    q: Array
    v: Array
    gyro: Array
    accel: Array
    P: Array


@dataclass(frozen=True)
class Step:
    """What stays the same from step to step: period [s], Earth rate, gravity, variances of a step, weight."""

    T: float
    w: Array
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
    q, v, P = np.empty((m, n + 1, 4)), np.empty((m, n + 1, 3)), np.empty((m, n + 1, 3, 3))
    q[:, 0], v[:, 0], P[:, 0] = belief.q, belief.v, belief.P[:, THETA, THETA]
    for k in range(n):
        predict(belief, rows[:, k], step)
        _correct(belief, z[:, k], step, correction)
        q[:, k + 1], v[:, k + 1], P[:, k + 1] = belief.q, belief.v, belief.P[:, THETA, THETA]
    return InvariantRun(q, v, P)


def left_jacobian(theta: Array) -> Array:
    """Return J_l(theta) (..., 3, 3): Exp(theta + J_l^-1 d) = Exp(d) Exp(theta) to first order in d."""
    a2 = np.sum(theta**2, axis=-1)[..., None, None]
    a = np.sqrt(np.maximum(a2, SMALL**2))
    first = np.where(a2 < SMALL**2, 0.5 - a2 / 24, (1 - np.cos(a)) / a**2)
    second = np.where(a2 < SMALL**2, 1 / 6 - a2 / 120, (a - np.sin(a)) / a**3)
    K = skew(theta)
    out: Array = np.eye(3) + first * K + second * (K @ K)
    return out


def step_of(setup: AlignSetup) -> Step:
    """Return what a setup makes of every step."""
    T = setup.period
    walk = T * np.repeat([setup.gyro_bias_walk**2, setup.accel_bias_walk**2], 3)
    return Step(
        T=T,
        w=earth_rate_n(setup.latitude),
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
    return Belief(np.array(start.q_nb, float), v, gyro, accel, sd[:, :, None] ** 2 * np.eye(SIZE))


def transition(belief: Belief, row: Array, step: Step) -> tuple[Array, Array, Array]:
    """Return the error's transition (m, 12, 12), and attitude and velocity after the step, all from ``belief``."""
    J, H = row[:, 7:16].reshape(-1, 3, 3), row[:, 16:].reshape(-1, 3, 3)
    C = matrix_from_quat(belief.q)
    turn = quat_multiply(quat_from_rotvec(-_times(J, belief.gyro)), row[:, :4])
    a = rotate(belief.q, row[:, 4:7] - _times(J, belief.accel) - _times(H, belief.gyro))
    v = belief.v + a + step.T * (step.g - np.cross(step.w, 2 * belief.v + a / 2))
    q = quat_multiply(quat_multiply(quat_from_rotvec(-step.w * step.T), belief.q), turn)
    F = np.tile(np.eye(SIZE), (len(row), 1, 1))
    F[:, THETA, THETA] = matrix_from_quat(quat_from_rotvec(-step.w * step.T))
    F[:, THETA, GYRO] = -C @ J
    F[:, NU, THETA] = step.T * skew(step.g)
    F[:, NU, NU] -= 2 * step.T * skew(step.w)
    F[:, NU, GYRO] = -C @ H - skew(v) @ C @ J
    F[:, NU, ACCEL] = -C @ J
    return F, quat_normalize(q), v


def predict(belief: Belief, row: Array, step: Step) -> None:
    """Move ``belief`` by rows (m, 25) of increments; gyro noise turns the velocity estimate too."""
    F, belief.q, belief.v = transition(belief, row, step)
    P = F @ belief.P @ F.swapaxes(1, 2)
    V = skew(belief.v)
    P[:, THETA, THETA] += step.gyro_var * np.eye(3)
    P[:, NU, THETA] += step.gyro_var * V
    P[:, THETA, NU] += step.gyro_var * V.swapaxes(1, 2)
    P[:, NU, NU] += step.accel_var * np.eye(3) + step.gyro_var * V @ V.swapaxes(1, 2)
    P[:, GYRO.start :, GYRO.start :] += step.walk
    belief.P = P


def _correct(belief: Belief, z: Array, step: Step, correction: Correction) -> None:
    """Kalman's update, then the turn of estimate and covariance by the correction."""
    m = len(z)
    H = np.zeros((m, 3, SIZE))
    H[:, :, THETA], H[:, :, NU] = -skew(belief.v), np.eye(3)
    PH = belief.P @ H.swapaxes(1, 2)
    K = np.linalg.solve(H @ PH + step.R, PH.swapaxes(1, 2)).swapaxes(1, 2)
    dx = _times(np.asarray(K, float), z - belief.v)
    P = belief.P - K @ PH.swapaxes(1, 2)
    belief.q, belief.v, G = moved(belief.q, belief.v, dx[:, : NU.stop], correction)
    belief.gyro, belief.accel = belief.gyro + dx[:, GYRO], belief.accel + dx[:, ACCEL]
    P[:, : NU.stop] = G @ P[:, : NU.stop]
    P[:, :, : NU.stop] = P[:, :, : NU.stop] @ G.swapaxes(1, 2)
    belief.P = (P + P.swapaxes(1, 2)) / 2


def moved(q: Array, v: Array, dx: Array, correction: Correction) -> tuple[Array, Array, Array]:
    """Return attitude (m, 4) and velocity (m, 3) moved by ``dx`` (m, 6), theta and nu, and what that does to errors.

    The last, G (m, 6, 6), takes an error about ``dx`` before the move to the error after it, to first order.
    """
    theta, nu = dx[:, :3], dx[:, 3:]
    turn, J = quat_from_rotvec(theta), left_jacobian(theta)
    shift = nu if correction == "first order" else _times(J, nu)
    G = np.tile(np.eye(6), (len(dx), 1, 1))
    if correction == "first order":
        G[:, :3, :3], G[:, 3:, :3] = J, skew(nu) @ J
    else:
        ad, term = np.zeros_like(G), G.copy()
        ad[:, :3, :3] = ad[:, 3:, 3:] = skew(theta)
        ad[:, 3:, :3] = skew(nu)
        for k in range(1, TERMS if np.abs(theta).max() > 0.1 else TERMS // 3):
            term = term @ ad / (k + 1)
            G += term
    return quat_normalize(quat_multiply(turn, q)), rotate(turn, v) + shift, G


def _times(matrices: Array, vectors: Array) -> Array:
    out: Array = np.einsum("nij,nj->ni", matrices, vectors)
    return out
