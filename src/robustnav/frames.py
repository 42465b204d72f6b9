"""Rotations and frames: the only place that knows the order of quaternion numbers.

Conventions: quaternions are Hamilton, scalar first (w, x, y, z); ``q_nb`` and ``C_nb`` take body vectors to
navigation, ``v_n = C_nb @ v_b``; n is north-east-down, b is forward-right-down; angles are radians.
All functions work on arrays with any leading axes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_HALF = np.sqrt(0.5)
Q_NED_ENU: Array = np.array([0.0, _HALF, _HALF, 0.0])  # v_ned = C(q) v_enu; its own inverse up to sign
Q_FRD_FLU: Array = np.array([0.0, 1.0, 0.0, 0.0])  # v_frd = C(q) v_flu; its own inverse up to sign


def skew(v: ArrayLike) -> Array:
    """Return the cross-product matrix (..., 3, 3) of vectors (..., 3): ``skew(a) @ b == cross(a, b)``."""
    v = np.asarray(v, float)
    out = np.zeros((*v.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2] = -v[..., 2], v[..., 1]
    out[..., 1, 0], out[..., 1, 2] = v[..., 2], -v[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -v[..., 1], v[..., 0]
    return out


def quat_multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Return the product ``q_ac = q_ab * q_bc`` of quaternions (..., 4)."""
    w1, x1, y1, z1 = np.moveaxis(np.asarray(a, float), -1, 0)
    w2, x2, y2, z2 = np.moveaxis(np.asarray(b, float), -1, 0)
    return np.stack(
        [
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
            w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
            w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
            w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        ],
        axis=-1,
    )


def quat_conjugate(q: ArrayLike) -> Array:
    """Return the inverse ``q_ba`` of unit quaternions ``q_ab`` (..., 4)."""
    out: Array = np.asarray(q, float) * np.array([1.0, -1.0, -1.0, -1.0])
    return out


def quat_normalize(q: ArrayLike) -> Array:
    """Return quaternions (..., 4) scaled to unit norm."""
    q = np.asarray(q, float)
    out: Array = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return out


def quat_from_rotvec(rotvec: ArrayLike) -> Array:
    """Return unit quaternions (..., 4) of rotation vectors (..., 3) [rad]: Exp."""
    rotvec = np.asarray(rotvec, float)
    half = 0.5 * np.linalg.norm(rotvec, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * rotvec], axis=-1)


def rotvec_from_quat(q: ArrayLike) -> Array:
    """Return rotation vectors (..., 3) [rad], norm at most pi, of unit quaternions (..., 4): Log."""
    q = np.asarray(q, float)
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sine, q[..., :1])
    small = sine < 1e-8
    return q[..., 1:] * np.where(small, 2.0, 2.0 * half / np.where(small, 1.0, sine))


def matrix_from_quat(q: ArrayLike) -> Array:
    """Return rotation matrices ``C_ab`` (..., 3, 3) of unit quaternions ``q_ab`` (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quat_from_matrix(C: ArrayLike) -> Array:
    """Return unit quaternions ``q_ab`` (..., 4), w >= 0, of rotation matrices ``C_ab`` (..., 3, 3)."""
    C = np.asarray(C, float)
    # Bar-Itzhack: every row of this symmetric table is a multiple of q; the largest diagonal is the safe one.
    d0, d1, d2 = C[..., 0, 0], C[..., 1, 1], C[..., 2, 2]
    wx, wy, wz = (C[..., 2, 1] - C[..., 1, 2], C[..., 0, 2] - C[..., 2, 0], C[..., 1, 0] - C[..., 0, 1])
    xy, xz, yz = (C[..., 0, 1] + C[..., 1, 0], C[..., 0, 2] + C[..., 2, 0], C[..., 1, 2] + C[..., 2, 1])
    rows = [
        [1 + d0 + d1 + d2, wx, wy, wz],
        [wx, 1 + d0 - d1 - d2, xy, xz],
        [wy, xy, 1 - d0 + d1 - d2, yz],
        [wz, xz, yz, 1 - d0 - d1 + d2],
    ]
    table = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    best = np.argmax(np.diagonal(table, axis1=-2, axis2=-1), axis=-1)
    q = quat_normalize(np.take_along_axis(table, best[..., None, None], axis=-2)[..., 0, :])
    return np.where(q[..., :1] < 0, -q, q)


def quat_from_euler(euler: ArrayLike) -> Array:
    """Return ``q_nb`` (..., 4) of roll, pitch, yaw (..., 3) [rad], yaw-pitch-roll sequence (z-y-x)."""
    half = 0.5 * np.asarray(euler, float)
    (cr, cp, cy), (sr, sp, sy) = np.moveaxis(np.cos(half), -1, 0), np.moveaxis(np.sin(half), -1, 0)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )


def euler_from_quat(q_nb: ArrayLike) -> Array:
    """Return roll, pitch, yaw (..., 3) [rad] of ``q_nb`` (..., 4); pitch within +-pi/2."""
    w, x, y, z = np.moveaxis(np.asarray(q_nb, float), -1, 0)
    return np.stack(
        [
            np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
            np.arcsin(np.clip(2 * (w * y - x * z), -1.0, 1.0)),
            np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        ],
        axis=-1,
    )


def rotate(q_ab: ArrayLike, v_b: ArrayLike) -> Array:
    """Return ``v_a = C_ab v_b`` (..., 3) for unit quaternions (..., 4) and vectors (..., 3)."""
    out: Array = np.einsum("...ij,...j->...i", matrix_from_quat(q_ab), np.asarray(v_b, float))
    return out


def left_jacobian(rotvec: Array) -> Array:
    """Return J (..., 3, 3) of rotation vectors (..., 3): Exp(rotvec + d) = Exp(J d) Exp(rotvec) to first order in d.

    The right Jacobian, Exp(rotvec + d) = Exp(rotvec) Exp(J d), is that of ``-rotvec``.
    """
    square = np.sum(np.square(rotvec), axis=-1)[..., None, None]
    small = square < 0.01
    a = np.sqrt(np.where(small, 1.0, square))
    first = np.where(small, 0.5 - square / 24 + square**2 / 720, (1 - np.cos(a)) / a**2)
    second = np.where(small, 1 / 6 - square / 120 + square**2 / 5040, (a - np.sin(a)) / a**3)
    K = skew(np.asarray(rotvec, float))
    out: Array = np.eye(3) + first * K + second * (K @ K)
    return out


def rotation_error(q_est: ArrayLike, q_true: ArrayLike) -> Array:
    """Return the attitude error ``q_est * conj(q_true)`` as a rotation vector (..., 3) [rad] in navigation axes."""
    return rotvec_from_quat(quat_multiply(q_est, quat_conjugate(q_true)))


def wrap_angle(angle: ArrayLike) -> Array:
    """Return angles wrapped into [-pi, pi) [rad]."""
    out: Array = (np.asarray(angle, float) + np.pi) % (2 * np.pi) - np.pi
    return out


def quat_ned_frd_from_enu_flu(q: ArrayLike) -> Array:
    """Return ``q_nb`` (NED, FRD) of an attitude given from FLU body to ENU world; (..., 4), its own inverse."""
    return quat_multiply(quat_multiply(Q_NED_ENU, q), Q_FRD_FLU)


def quat_ned_from_enu(q: ArrayLike) -> Array:
    """Return ``q_nb`` to NED of an attitude given from the same body axes to ENU; (..., 4)."""
    return quat_multiply(Q_NED_ENU, q)


def ned_from_enu(v: ArrayLike) -> Array:
    """Return vectors (..., 3) in NED of vectors in ENU, or the reverse: (y, x, -z)."""
    v = np.asarray(v, float)
    return np.stack([v[..., 1], v[..., 0], -v[..., 2]], axis=-1)


def frd_from_flu(v: ArrayLike) -> Array:
    """Return vectors (..., 3) in FRD of vectors in FLU, or the reverse: (x, -y, -z)."""
    out: Array = np.asarray(v, float) * np.array([1.0, -1.0, -1.0])
    return out


def triad(f_b: ArrayLike, m_b: ArrayLike) -> Array:
    """Return ``q_nb`` (..., 4) from specific force and magnetic field at rest, n = magnetic north-east-down.

    Parameters
    ----------
    f_b : (..., 3) specific force [m/s^2], about (0, 0, -9.8) when level.
    m_b : (..., 3) magnetic field, any unit, not parallel to ``f_b``.
    """
    down = -np.asarray(f_b, float)
    down = down / np.linalg.norm(down, axis=-1, keepdims=True)
    east = np.cross(down, np.asarray(m_b, float))
    east = east / np.linalg.norm(east, axis=-1, keepdims=True)
    north = np.cross(east, down)
    return quat_from_matrix(np.stack([north, east, down], axis=-2))
