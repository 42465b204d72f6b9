"""One filter of the alignment, as it is meant: attitude on SO(3) with covariance transport, and one wind.

The navigation axes are level, turned about down by an unknown angle (the wander frame).  Instead of a heading the state
holds the two horizontal components of the Earth's rotation in those axes: everything stays linear whatever the heading
is.  The base is at rest but for sway, and the wind has no preferred direction, so that the reference velocity needs no
turning into the wander frame.  Error: C = Exp(theta) C_est with theta in the wander frame, all else additive, ordered
theta 3, velocity 2, gyro bias 3, accelerometer bias 3, Earth rate 2, with a compass its constant error, then (cos, sin)
north, (cos, sin) east and the frequency of each line, then the Markov part 2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, exp, log, nan, pi, sin

import numpy as np

from robustnav.alignment.setting import AlignSetup, Wind
from robustnav.earth import EARTH_RATE
from robustnav.frames import (
    Array,
    left_jacobian,
    matrix_from_quat,
    quat_from_rotvec,
    quat_multiply,
    quat_normalize,
    skew,
)

TURN, VELOCITY, GYRO, ACCEL, RATE, COMPASS = 0, 3, 5, 8, 11, 13

LEVEL_SD = 0.15  # rad, of the coarse start
VELOCITY_SD = 3.0  # m/s, base and mean wind
RATE_SD = 2e-4  # rad/s, well above the Earth's: flat on its circle
AMPLITUDE_SD = 0.35  # m/s, of a line
AMPLITUDE_WALK = 3e-4  # m/s/sqrt(s)
OMEGA_WALK = 1e-4  # rad/s/sqrt(s)


@dataclass(frozen=True)
class Core:
    """States common to all winds: ``q`` body to wander frame; ``x`` the rest, (10,), with a compass (11,), SI.

    ``north`` [rad] is the azimuth in the wander frame that bearings are laid across, fixed by the first, NaN before;
    ``steepness`` the tangent of the field's dip, a mean over some seconds.
    """

    q: Array
    x: Array
    north: float = nan
    steepness: float = nan

    @property
    def velocity(self) -> Array:
        """Velocity of the base and mean wind (2,) [m/s]."""
        return self.x[0:2]

    @property
    def gyro_bias(self) -> Array:
        """Gyro bias (3,) [rad/s]."""
        return self.x[2:5]

    @property
    def accel_bias(self) -> Array:
        """Accelerometer bias (3,) [m/s^2]."""
        return self.x[5:8]

    @property
    def rate(self) -> Array:
        """Horizontal Earth rate (2,) [rad/s]."""
        return self.x[8:10]

    @property
    def compass_bias(self) -> Array:
        """Constant error of the compass (1,) [rad]; (0,) without one."""
        return self.x[10:]

    @property
    def size(self) -> int:
        """Length of its error."""
        return 3 + len(self.x)


@dataclass(frozen=True)
class Belief:
    """State and covariance under one wind: ``d`` holds its lines and Markov part; ``P`` (n, n) of the error.

    Where ``off`` is given, readings leave ``core`` alone and all is linear about it, the anchor: ``off`` is its error
    as estimated, in the order of the common states.  A turn about down, however large, is then one of the whole
    picture: tilt and the axes of the biases are found as the anchor has them.

    ``log_likelihood`` and ``misfit`` are those of the last reading: log density, and the squared normalised innovation
    times its weight, 2 expected.
    """

    wind: Wind
    core: Core
    d: Array
    P: Array
    log_likelihood: float = 0.0
    misfit: float = 2.0
    off: Array | None = None

    @property
    def level(self) -> Core:
        """What is estimated but for the turn about down."""
        if self.off is None:
            return self.core
        return _moved(self.core, np.concatenate([self.off[:2], [0.0], self.off[3:]]))

    @property
    def turn(self) -> float:
        """The turn about down [rad] that ``level`` lacks."""
        return 0.0 if self.off is None else float(self.off[2])

    @property
    def estimate(self) -> Core:
        """What is estimated of the common states."""
        level = self.level
        return level if self.off is None else replace(level, q=_product(_about_down(self.turn), level.q))

    @property
    def lines(self) -> int:
        """Number of lines."""
        return len(self.wind.omega)


def start(setup: AlignSetup, wind: Wind, q0: Array, v0: Array, gyro_bias: Array | None = None) -> Belief:
    """Return the belief at t = 0 about attitude ``q0`` (4,), velocity ``v0`` (2,) [m/s], gyro bias (3,) or zero."""
    # The azimuth of the wander frame is a choice: at the start it has no error.
    level = [LEVEL_SD, LEVEL_SD, 0.0]
    sd = [*level, *[VELOCITY_SD] * 2, *[setup.gyro_bias_sd] * 3, *[setup.accel_bias_sd] * 3, *[RATE_SD] * 2]
    if setup.compass_bias_sd is not None:
        sd.append(setup.compass_bias_sd)
    x = np.zeros(len(sd) - 3)
    x[:2] = v0
    if gyro_bias is not None:
        x[2:5] = gyro_bias
    return with_wind(Core(np.asarray(q0, float), x), np.diag(np.square(sd)), wind)


def graft(known: Belief, wind: Wind) -> Belief:
    """Return a belief that knows the common states as another, and nothing of the wind, its mean included."""
    P = known.P[: known.core.size, : known.core.size].copy()
    P[[VELOCITY, VELOCITY + 1], [VELOCITY, VELOCITY + 1]] += VELOCITY_SD**2
    return replace(with_wind(known.core, P, wind), off=known.off)


def with_wind(core: Core, P: Array, wind: Wind) -> Belief:
    """Return a belief with the common states and their covariance ``P``, and the wind's own from its prior."""
    d, sd = [], []
    for omega, omega_sd in zip(wind.omega, wind.omega_sd, strict=True):
        d += [0.0, 0.0, 0.0, 0.0, omega]
        sd += [*[AMPLITUDE_SD] * 4, omega_sd]
    sd += [wind.markov_sd] * 2
    common = core.size
    whole = np.zeros((common + len(sd), common + len(sd)))
    whole[:common, :common] = P
    np.fill_diagonal(whole[common:, common:], np.square(sd))
    return Belief(wind, core, np.array([*d, 0.0, 0.0]), whole)


def wind_transition(belief: Belief, period: float) -> tuple[Array, Array, Array]:
    """Return the wind's states after ``period`` [s], its transition matrix and the diagonal of its noise."""
    d, n = belief.d.copy(), len(belief.d)
    F, Q = np.eye(n), np.zeros(n)
    for k in range(0, 5 * belief.lines, 5):
        c, s = cos(d[k + 4] * period), sin(d[k + 4] * period)
        for j in (k, k + 2):
            d[j], d[j + 1] = c * d[j] + s * d[j + 1], c * d[j + 1] - s * d[j]
            F[j, j], F[j, j + 1], F[j, k + 4] = c, s, period * d[j + 1]
            F[j + 1, j], F[j + 1, j + 1], F[j + 1, k + 4] = -s, c, -period * d[j]
        Q[k : k + 4] = AMPLITUDE_WALK**2 * period
        Q[k + 4] = OMEGA_WALK**2 * period
    decay = exp(-period / belief.wind.markov_time)
    d[-2:] *= decay
    F[-2, -2] = F[-1, -1] = decay
    Q[-2:] = belief.wind.markov_sd**2 * (1 - decay**2)
    return d, F, Q


def core_transition(core: Core, setup: AlignSetup, reading: Array) -> tuple[Core, Array]:
    """Return the common states after one reading (30,) and their transition matrix."""
    T, C = setup.period, matrix_from_quat(core.q)
    J, H = reading[7:16].reshape(3, 3), reading[16:25].reshape(3, 3)
    a = C @ (reading[4:7] - J @ core.accel_bias - H @ core.gyro_bias)
    w = np.array([*core.rate, -EARTH_RATE * sin(setup.latitude)])
    earth = quat_from_rotvec(-w * T)
    q = _product(earth, core.q)
    q = _product(_product(q, quat_from_rotvec(-J @ core.gyro_bias)), reading[:4])
    x = core.x.copy()
    x[:2] += (a - 0.5 * T * np.cross(w, a))[:2]
    F = np.eye(core.size)
    F[:3, :3] = matrix_from_quat(earth)
    F[:3, GYRO:ACCEL] = -C @ J
    F[:2, RATE:COMPASS] = -T * np.eye(2)
    # At rest the specific force is that of gravity.  Were it taken less the bias found so far, what tilt and bias have
    # in common would change with every reading, and the filter would claim to tell them apart.
    F[VELOCITY:GYRO, :3] = -skew(np.array([0.0, 0.0, -setup.gravity * T]))[:2]
    F[VELOCITY:GYRO, GYRO:ACCEL] = (-C @ H)[:2]
    F[VELOCITY:GYRO, ACCEL:RATE] = (-C @ J)[:2]
    F[VELOCITY:GYRO, RATE:COMPASS] = 0.5 * T * skew(a)[:2, :2]
    return replace(core, q=q, x=x), F


def predict(belief: Belief, setup: AlignSetup, reading: Array) -> Belief:
    """Return the belief one period later; ``reading`` (30,) as made by ``reading_rows``."""
    d, F_wind, Q_wind = wind_transition(belief, setup.period)
    core, F_core = core_transition(belief.core, setup, reading)
    n, common = len(belief.P), core.size
    F = np.zeros((n, n))
    F[:common, :common], F[common:, common:] = F_core, F_wind
    densities = (setup.gyro_density, setup.accel_density, setup.gyro_bias_walk, setup.accel_bias_walk)
    Q = [density**2 * setup.period for density, size in zip(densities, (3, 2, 3, 3), strict=True) for _ in range(size)]
    P = F @ belief.P @ F.T + np.diag([*Q, *np.zeros(common - RATE), *Q_wind])
    return replace(belief, core=core, d=d, P=P, off=None if belief.off is None else F_core @ belief.off)


def observation(belief: Belief) -> Array:
    """Return H (2, n): velocity, cosine of each line and Markov part."""
    H = np.zeros((2, len(belief.P)))
    for i in range(2):
        H[i, VELOCITY + i] = 1.0
        H[i, [belief.core.size + 5 * k + 2 * i for k in range(belief.lines)]] = 1.0
        H[i, i - 2] = 1.0
    return H


def update(belief: Belief, setup: AlignSetup, z: Array) -> Belief:
    """Return the belief after a reference velocity ``z`` (2,) [m/s] north and east.

    The reading may be a gust: the likelihood is that of both cases, and the noise of the update is divided by the
    probability that it is none.
    """
    H = observation(belief)
    PH = belief.P @ H.T
    S, noise = H @ PH, setup.reference_sd**2
    off = np.zeros(2) if belief.off is None else belief.off[VELOCITY:GYRO]
    r = z - belief.core.velocity - off - H[:, belief.core.size :] @ belief.d
    calm, square = _log_normal(r, S + noise * np.eye(2))
    blown, _ = _log_normal(r, S + (noise + setup.gust_sd**2) * np.eye(2))
    calm += log(1 - setup.gust_share)
    blown = blown + log(setup.gust_share) if setup.gust_share > 0 else -np.inf
    top = max(calm, blown)
    odds = exp(calm - top) + exp(blown - top)
    weight = max(exp(calm - top) / odds, 1e-6)
    W = np.linalg.solve(np.linalg.cholesky(S + noise / weight * np.eye(2)), np.column_stack([PH.T, r]))
    moved = inject(replace(belief, P=belief.P - W[:, :-1].T @ W[:, :-1]), W[:, :-1].T @ W[:, -1])
    return replace(moved, log_likelihood=top + log(odds) - log(2 * pi), misfit=weight * square)


def inject(belief: Belief, dx: Array) -> Belief:
    """Return the belief moved by ``dx`` (n,), its covariance carried to the new attitude: P <- G P G'.

    The error left is Log(Exp(theta + e) Exp(-theta)) = J_l(theta) e; without G a state that absorbs the mean wind lets
    the filter believe a heading it never saw.
    """
    common = belief.core.size
    d = belief.d + dx[common:]
    if belief.off is not None:
        return replace(belief, d=d, off=belief.off + dx[:common])
    core = _moved(belief.core, dx[:common])
    G = np.eye(len(dx))
    G[:3, :3] = left_jacobian(dx[:3])
    return replace(belief, core=core, d=d, P=G @ belief.P @ G.T)


def anchor(belief: Belief) -> Belief:
    """Return a fresh belief that is linear about its start, and the free motion from there."""
    return replace(belief, off=np.zeros(belief.core.size))


def _moved(core: Core, dx: Array) -> Core:
    return replace(core, q=_product(quat_from_rotvec(dx[:3]), core.q), x=core.x + dx[3:])


def _about_down(angle: float) -> Array:
    return quat_from_rotvec(np.array([0.0, 0.0, angle]))


def _product(a: Array, b: Array) -> Array:
    return quat_normalize(quat_multiply(a, b))


def _log_normal(r: Array, S: Array) -> tuple[float, float]:
    """Return the log density of r up to -log(2 pi), and r' S^-1 r."""
    square = float(r @ np.linalg.solve(S, r))
    return -0.5 * (square + log(np.linalg.det(S))), square
