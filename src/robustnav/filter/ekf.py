"""The extended Kalman filter on an error state: on a quaternion model it is the multiplicative EKF."""

from __future__ import annotations

import numpy as np

from robustnav.filter.steps import Seen
from robustnav.filter.weighting import Gate, Rule
from robustnav.frames import Array, left_jacobian
from robustnav.model.blocks import Model
from robustnav.model.functions import ModelFunctions

EVERYTHING = Gate()


def predict(model: ModelFunctions, x: Array, P: Array, u: Array, dt: float) -> tuple[Array, Array]:
    """Return state (nx,) and covariance (ne, ne) after ``dt`` seconds of input ``u`` (nu,)."""
    F, Q = model.transition(x, u, dt)
    P = F @ P @ F.T + Q
    return model.propagate(x, u, dt), (P + P.T) / 2


def update(
    model: ModelFunctions, sensor: int, belief: tuple[Array, Array], z: Array, rule: Rule = EVERYTHING
) -> tuple[Array, Array, Seen]:
    """Fuse one reading of a sensor, row after row.

    Parameters
    ----------
    model : the model's functions.
    sensor : its position in the model.
    belief : state x (nx,) and covariance P (ne, ne).
    z : the reading and what travels with it (width,), finite.
    rule : what the reading counts for by its sum of nu^2 / s; with no weight the belief stays as it was.

    Returns
    -------
    x, P, seen : belief after, and what the reading said.  All rows share the linearisation point; the sum of
        nu^2 / s over the rows equals nu' S^-1 nu of the joint update.
    """
    x, P = belief
    variance = model.model.variances[sensor]
    rows, H = model.residual(sensor, x, z), model.jacobian(sensor, x, z[model.model.sensors[sensor].size :])
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
    weight = 0.0 if refused else rule.weight(nis, len(rows))
    if not weight > 0:
        return x, P, Seen(nu, s, nis, 0.0)
    left = P + weight * (left - P)
    left = transported(model.model, weight * dx, (left + left.T) / 2)
    return model.inject(x, weight * dx), left, Seen(nu, s, nis, weight)


def transported(model: Model, dx: Array, P: Array) -> Array:
    """Return the covariance (ne, ne) about the state corrected by ``dx`` (ne,), where the model asks for it.

    An error about the old attitude is not one about the new: Log(Exp(d + e) Exp(-d)) = J_l(d) e to first order.
    """
    rotation = model.rotation
    if rotation is None or not rotation.transported:
        return P
    part, G = model.error_slices[rotation.name], np.eye(len(P))
    G[part, part] = left_jacobian(dx[part] if rotation.error == "n" else -dx[part])
    out: Array = G @ P @ G.T
    return out
