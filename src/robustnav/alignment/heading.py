"""From a belief to an answer: the horizontal Earth rate lies on a known circle, and where on it is the heading.

Given the heading everything else is Gaussian, so the posterior is a one-dimensional sum over the circle: exact for a
prior that knows nothing of heading, with one mode or several, and wide where nothing can be known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2, exp, pi, sqrt

import numpy as np

from robustnav.alignment.filter import ACCEL, COMPASS, GYRO, RATE, Belief
from robustnav.alignment.setting import AlignSetup
from robustnav.frames import Array, matrix_from_quat, quat_conjugate, quat_multiply, wrap_angle

NODES = 64


@dataclass(frozen=True)
class Answer:
    """Heading and tilt, given that the Earth rate has its known length.

    ``q`` attitude in the wander frame the tilt refers to; ``tilt`` (2,) mean turn left to apply [rad] and ``tilt_cov``
    (2, 2); ``heading`` of the forward axis [rad] and its variance; ``concentration`` length of the mean heading vector,
    0 for nothing known to 1; biases (3,) SI; ``wind`` (2,) all that the reference velocity shows besides noise [m/s];
    ``compass_bias`` [rad] and its variance, NaN without a compass.
    """

    q: Array
    tilt: Array
    tilt_cov: Array
    heading: float
    heading_var: float
    concentration: float
    gyro_bias: Array
    accel_bias: Array
    wind: Array
    compass_bias: float
    compass_bias_var: float

    @property
    def row(self) -> Array:
        """The twenty-two numbers in the order of the compiled form."""
        cov = self.tilt_cov[[0, 0, 1], [0, 1, 1]]
        heading = (self.heading, self.heading_var, self.concentration)
        compass = (self.compass_bias, self.compass_bias_var)
        return np.hstack([self.q, self.tilt, cov, heading, self.gyro_bias, self.accel_bias, self.wind, compass])


@dataclass(frozen=True)
class _Circle:
    """Density of the Earth rate on its circle: azimuth p of the wander frame has rate radius (cos p, -sin p)."""

    radius: float
    mean: Array
    info: Array

    def at(self, p: Array) -> tuple[Array, Array]:
        """Return offsets (k, 2) from the mean at azimuths (k,), and log densities (k,)."""
        off = self.radius * np.stack([np.cos(p), -np.sin(p)], axis=-1) - self.mean
        return off, -0.5 * np.einsum("ki,ij,kj->k", off, self.info, off)

    def climb(self, p: float) -> tuple[float, float]:
        """Return the top near azimuth ``p`` and half the width of the arc worth summing over."""
        info = 0.0
        for _ in range(20):
            off = self.at(np.array([p]))[0][0]
            slope = self.radius * np.array([-np.sin(p), -np.cos(p)])
            info = float(slope @ self.info @ slope)
            p += float(np.clip(-off @ self.info @ slope / info, -0.05, 0.05))
        return p, min(6 / sqrt(info), pi)

    def arcs(self) -> list[tuple[float, float]]:
        """Return centre and half width of one arc or two that hold the density, the highest first.

        The exponent is a trigonometric polynomial of degree two: it has two tops at most.
        """
        grid = 2 * pi * np.arange(NODES) / NODES
        value = self.at(grid)[1]
        tops = grid[(value >= np.roll(value, 1)) & (value > np.roll(value, -1))][:2]
        found = [self.climb(float(top)) for top in tops] or [(0.0, pi)]  # none: flat to rounding
        found.sort(key=lambda arc: -float(self.at(np.array([arc[0]]))[1][0]))
        apart = abs(float(wrap_angle(found[-1][0] - found[0][0])))
        if len(found) == 2 and apart < found[0][1] + found[1][1]:
            return [(found[0][0], min(found[0][1] + apart, pi))]
        return found


def answer(belief: Belief, setup: AlignSetup) -> Answer:
    """Return what a belief says of attitude and heading."""
    P, core, turn = belief.P, belief.level, slice(RATE, RATE + 2)
    info = np.linalg.inv(P[turn, turn])
    circle = _Circle(setup.horizontal_earth_rate, core.rate, np.asarray(info, float))
    K = P[:RATE, turn] @ circle.info
    arcs, unit = circle.arcs(), (2 * np.arange(NODES) + 1) / NODES - 1
    centre = arcs[0][0]
    off, log_density = circle.at(np.concatenate([middle + half * unit for middle, half in arcs]))
    turns = np.concatenate([wrap_angle(middle - centre) + half * unit for middle, half in arcs])
    w = np.repeat([half for _, half in arcs], NODES) * np.exp(log_density - circle.at(np.array([centre]))[1])
    w /= w.sum()
    heading = turns + off @ K[2]
    mean, mean_heading = w @ off, float(w @ heading)
    # Covariance given the heading, and what the spread of the heading adds.
    excess = (off * w[:, None]).T @ off - np.outer(mean, mean) - P[turn, turn]
    down = float(P[2, 2] - K[2] @ P[turn, turn] @ K[2])  # of the wander frame's azimuth, given the Earth rate
    compass = _compass(belief, circle.info, mean, excess)
    C = matrix_from_quat(core.q)
    wind = core.velocity + belief.d[-2:]
    for k in range(0, 5 * belief.lines, 5):
        wind = wind + belief.d[[k, k + 2]]
    return Answer(
        q=core.q,
        tilt=K[:2] @ mean,
        tilt_cov=P[:2, :2] + K[:2] @ excess @ K[:2].T,
        heading=float(wrap_angle(atan2(C[1, 0], C[0, 0]) + belief.turn + centre + mean_heading)),
        heading_var=float(w @ heading**2 - mean_heading**2 + down),
        concentration=exp(-0.5 * down) * float(np.hypot(w @ np.cos(heading), w @ np.sin(heading))),
        gyro_bias=core.gyro_bias + K[GYRO:ACCEL] @ mean,
        accel_bias=core.accel_bias + K[ACCEL:RATE] @ mean,
        wind=wind,
        compass_bias=compass[0],
        compass_bias_var=compass[1],
    )


def _compass(belief: Belief, info: Array, mean: Array, excess: Array) -> tuple[float, float]:
    """Return mean and variance of the compass's constant error, given the Earth rate; NaN without a compass."""
    core, P = belief.level, belief.P
    if not core.compass_bias.size:
        return np.nan, np.nan
    k = P[COMPASS, RATE:COMPASS] @ info
    return float(core.compass_bias[0] + k @ mean), float(P[COMPASS, COMPASS] + k @ excess @ k)


def tilt_between(a: Array, b: Array) -> Array:
    """Return the turn (2,) [rad] about x, y of the wander frame that takes attitude ``b`` to ``a``; small."""
    q = quat_multiply(a, quat_conjugate(b))
    out: Array = np.where(q[0] < 0, -2.0, 2.0) * q[1:3]
    return out


def mix(answers: list[Answer], weights: Array) -> Answer:
    """Return one answer with the mean and covariance of several, referred to the attitude of the heaviest."""
    ref = answers[int(np.argmax(weights))]
    tilts = np.array([tilt_between(one.q, ref.q) + one.tilt for one in answers])
    headings = wrap_angle([one.heading - ref.heading for one in answers])
    tilt, heading = weights @ tilts, float(weights @ headings)
    compass = weights @ [one.compass_bias for one in answers]
    second = weights @ [one.compass_bias_var + (one.compass_bias - compass) ** 2 for one in answers]
    covs = np.array([one.tilt_cov for one in answers])
    spread = np.einsum("k,kij->ij", weights, covs) + (tilts * weights[:, None]).T @ tilts - np.outer(tilt, tilt)
    return replace(
        ref,
        tilt=tilt,
        tilt_cov=spread,
        heading=float(wrap_angle(ref.heading + heading)),
        heading_var=float(weights @ (np.array([one.heading_var for one in answers]) + headings**2) - heading**2),
        concentration=float(weights @ [one.concentration for one in answers]),
        gyro_bias=weights @ np.array([one.gyro_bias for one in answers]),
        accel_bias=weights @ np.array([one.accel_bias for one in answers]),
        wind=weights @ np.array([one.wind for one in answers]),
        compass_bias=float(compass),
        compass_bias_var=float(second),
    )
