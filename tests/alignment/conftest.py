"""A base at rest that sways: increments and reference velocity made from the attitude alone.

The increments are what the mechanisation inverts exactly, so that every error in a test is the estimator's.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from robustnav.alignment import AlignSetup
from robustnav.earth import earth_rate_n
from robustnav.frames import (
    matrix_from_quat,
    quat_conjugate,
    quat_from_euler,
    quat_from_rotvec,
    quat_multiply,
    rotate,
    skew,
)
from robustnav.strapdown import Increments
from robustnav.units import DEG, DEG_PER_HOUR, DPS, MILLI_G

FINE, COARSE = 0.01 * DEG_PER_HOUR, 0.01 * DPS
LATITUDE = 32.0 * DEG


def setup_of(gyro_rms: float = FINE, period: float = 0.1, latitude: float = LATITUDE, **numbers: float) -> AlignSetup:
    published = vars(AlignSetup.published(gyro_rms, 0.1 * MILLI_G, latitude))
    return AlignSetup(**{**published, "period": period, **numbers})


@dataclass(frozen=True)
class Case:
    setup: AlignSetup
    increments: Increments
    reference: np.ndarray
    t: np.ndarray
    q_nb: np.ndarray

    def head(self, n: int) -> "Case":
        return Case(self.setup, self.increments.between(0, n), self.reference[:n], self.t[:n], self.q_nb[:n])


def attitude(t: np.ndarray, heading: float) -> np.ndarray:
    roll, pitch = 3 * DEG * np.sin(7.3 * t), (20 + 5 * np.sin(4.1 * t)) * DEG
    return quat_from_euler(np.stack([roll, pitch, np.full_like(t, heading)], axis=-1))


def increments_at_rest(setup: AlignSetup, q: np.ndarray, gyro_bias: np.ndarray, accel_bias: np.ndarray) -> Increments:
    """Exact increments between attitudes ``q`` (n + 1, 4), then moved by biases (n, 3)."""
    T, w = setup.period, earth_rate_n(setup.latitude)
    turn = quat_from_rotvec(np.broadcast_to(w * T, (len(q) - 1, 3)))
    rotation = quat_multiply(quat_conjugate(q[:-1]), quat_multiply(turn, q[1:]))
    a = np.linalg.solve(np.eye(3) - 0.5 * T * skew(w), [0.0, 0.0, -setup.gravity * T])
    velocity = rotate(quat_conjugate(q[:-1]), a)
    J = T * matrix_from_quat(quat_from_rotvec(0.5 * T * np.tile([0.02, -0.1, 0.05], (len(velocity), 1))))
    H = -0.5 * T * skew(velocity)
    push = np.einsum("nij,nj->ni", J, accel_bias) + np.einsum("nij,nj->ni", H, gyro_bias)
    spin = quat_from_rotvec(np.einsum("nij,nj->ni", J, gyro_bias))
    return Increments.of(quat_multiply(spin, rotation), velocity + push, (J, H), T)


def markov(rng: np.random.Generator, n: int, period: float, sd: float, time: float) -> np.ndarray:
    keep, x, out = np.exp(-period / time), sd * rng.standard_normal(2), np.empty((n, 2))
    for k in range(n):
        x = keep * x + sd * np.sqrt(1 - keep**2) * rng.standard_normal(2)
        out[k] = x
    return out


def lines(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    phase = rng.uniform(0, 2 * np.pi, (2, 3))
    amplitude = np.array([[0.15, 0.2, 0.3], [0.15, 0.2, 0.5]])
    return np.einsum("ij,ijk->ki", amplitude, np.sin(np.multiply.outer([2.0, 1.0, 0.5], t) + phase[..., None]))


def make_case(setup: AlignSetup, seed: int, seconds: float, wind: str) -> Case:
    """Winds: ``none``, ``lines``, ``markov`` (0.5 m/s, 4 s); ``gusts`` are lines with 5 % of gusts."""
    rng = np.random.default_rng(seed)
    n, T = round(seconds / setup.period), setup.period
    t = T * np.arange(n + 1)
    q = attitude(t, rng.uniform(-np.pi, np.pi))
    biases = []
    for sd, walk in ((setup.gyro_bias_sd, setup.gyro_bias_walk), (setup.accel_bias_sd, setup.accel_bias_walk)):
        biases.append(sd * rng.standard_normal(3) + walk * np.sqrt(T) * rng.standard_normal((n, 3)).cumsum(axis=0))
    exact = increments_at_rest(setup, q, *biases)
    noisy = Increments.of(
        quat_multiply(exact.rotation, quat_from_rotvec(setup.gyro_density * np.sqrt(T) * rng.standard_normal((n, 3)))),
        exact.velocity + setup.accel_density * np.sqrt(T) * rng.standard_normal((n, 3)),
        (exact.J, exact.H),
        T,
    )
    reference = np.array([2.7, 2.0]) + setup.reference_sd * rng.standard_normal((n, 2))
    if wind in ("lines", "gusts"):
        reference += lines(rng, t[1:])
    if wind == "markov":
        reference += markov(rng, n, T, 0.5, 4.0)
    if wind == "gusts":
        hit = rng.random(n) < 0.05
        reference[hit] += 3.0 * rng.standard_normal((hit.sum(), 2))
    return Case(setup, noisy, reference, t[1:], q[1:])


def tilt_of(q_nb: np.ndarray, q_true: np.ndarray) -> np.ndarray:
    """Turn (n, 2) left to apply about the level axes of ``q_nb``: free of heading."""
    down = np.einsum("nij,nj->ni", matrix_from_quat(q_nb), matrix_from_quat(q_true)[:, 2, :])
    return np.stack([down[:, 1], -down[:, 0]], axis=-1)


@pytest.fixture(scope="session")
def fine_case() -> Case:
    return make_case(setup_of(FINE), 3, 120.0, "lines")
