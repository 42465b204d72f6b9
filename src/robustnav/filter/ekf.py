"""The extended Kalman filter on an error state: on a quaternion model it is the multiplicative EKF."""

from __future__ import annotations

import numpy as np

from robustnav.filter.steps import Seen
from robustnav.frames import Array
from robustnav.model.functions import ModelFunctions


def predict(model: ModelFunctions, x: Array, P: Array, u: Array, dt: float) -> tuple[Array, Array]:
    """Return state (nx,) and covariance (ne, ne) after ``dt`` seconds of input ``u`` (nu,)."""
    F, Q = model.transition(x, u, dt)
    P = F @ P @ F.T + Q
    return model.propagate(x, u, dt), (P + P.T) / 2


def update(
    model: ModelFunctions, sensor: int, belief: tuple[Array, Array], z: Array, gate: float = np.inf
) -> tuple[Array, Array, Seen]:
    """Fuse one reading of a sensor, row after row.

    Parameters
    ----------
    model : the model's functions.
    sensor : its position in the model.
    belief : state x (nx,) and covariance P (ne, ne).
    z : the reading (size,), finite.
    gate : largest accepted sum of nu^2 / s; above it, or if it is not finite, the belief stays as it was.

    Returns
    -------
    x, P, seen : belief after, and what the reading said.  All rows share the linearisation point; the sum of
        nu^2 / s over the rows equals nu' S^-1 nu of the joint update.
    """
    x, P = belief
    variance = model.model.variances[sensor]
    rows, H = model.residual(sensor, x, z), model.jacobian(sensor, x)
    dx, left, refused = np.zeros(len(P)), P.copy(), False
    nu, s = np.zeros(len(rows)), np.zeros(len(rows))
    for i, h in enumerate(H):
        PH = left @ h
        s[i] = h @ PH + variance
        nu[i] = rows[i] - h @ dx
        if not s[i] > 0.999 * variance:  # NaN, or P has lost definiteness; the margin is for rounding
            refused = True
            continue
        gain = PH / s[i]
        dx = dx + gain * nu[i]
        left = left - np.outer(gain, PH)
    nis = float(np.sum(nu**2 / s))
    if refused or not (nis <= gate and np.isfinite(nis)):
        return x, P, Seen(nu, s, nis, False)
    return model.inject(x, dx), (left + left.T) / 2, Seen(nu, s, nis, True)
