"""The unscented Kalman filter on an error state: points are x [+] e, so quaternions stay unit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.filter.ekf import EVERYTHING
from robustnav.filter.steps import Seen
from robustnav.filter.weighting import Rule
from robustnav.frames import Array
from robustnav.model.functions import ModelFunctions, innovation


@dataclass(frozen=True)
class Spread:
    """Sigma-point spread (Wan and van der Merwe 2000): lambda = alpha^2 (n + kappa) - n.

    The default, alpha 1, beta 0, kappa 0, is the cubature rule: equal weights, none negative.
    """

    alpha: float = 1.0
    beta: float = 0.0
    kappa: float = 0.0

    def weights(self, n: int) -> tuple[float, Array, Array]:
        """Return n + lambda and the weights (2 n + 1,) of mean and covariance, the centre first."""
        spread = self.alpha**2 * (n + self.kappa)
        if not spread > 0:
            raise InputError("sigma-point spread", got=f"n + lambda = {spread}", expected="a positive number")
        mean = np.full(2 * n + 1, 0.5 / spread)
        mean[0] = (spread - n) / spread
        covariance = mean.copy()
        covariance[0] += 1 - self.alpha**2 + self.beta
        return spread, mean, covariance


def _points(model: ModelFunctions, x: Array, P: Array, spread: float) -> tuple[Array, list[Array]]:
    """Return error offsets (2 n + 1, ne) and the states there."""
    try:
        L = np.linalg.cholesky(P) if np.isfinite(P).all() else None  # of a NaN it would return NaN
    except np.linalg.LinAlgError:
        L = None
    if L is None:
        raise EstimatorError("covariance of the unscented filter is not positive definite", got=str(np.diag(P)))
    offsets = [np.zeros(len(P))]
    for column in np.sqrt(spread) * L.T:
        offsets += [column, -column]
    return np.array(offsets), [x, *(model.inject(x, e) for e in offsets[1:])]


def predict(
    model: ModelFunctions, belief: tuple[Array, Array], u: Array, dt: float, spread: Spread
) -> tuple[Array, Array]:
    """Return the belief (x, P) after ``dt`` seconds of input ``u``; noise enters additively as Q."""
    x, P = belief
    distance, w_mean, w_cov = spread.weights(len(P))
    moved = [model.propagate(point, u, dt) for point in _points(model, x, P, distance)[1]]
    errors = np.array([model.difference(point, moved[0]) for point in moved])
    mean = w_mean @ errors
    apart = errors - mean
    _, Q = model.transition(x, u, dt)
    P = apart.T @ (w_cov[:, None] * apart) + Q
    return model.inject(moved[0], mean), (P + P.T) / 2


def update(
    model: ModelFunctions, sensor: int, belief: tuple[Array, Array], z: Array, spread: Spread, rule: Rule = EVERYTHING
) -> tuple[Array, Array, Seen]:
    """Fuse one reading of a sensor; parameters and result as in ``ekf.update``, with s the diagonal of S.

    The innovation stays in the sensor's own axes.  Turned into navigation axes it would vary over the points with what
    the sensor happened to read, and a carrier's own acceleration would look like news of its heading.
    """
    x, P = belief
    distance, w_mean, w_cov = spread.weights(len(P))
    offsets, points = _points(model, x, P, distance)
    known = z[model.model.sensors[sensor].size :]
    centre = np.concatenate([model.measure(sensor, points[0], known), known])
    below = np.array([innovation(model, sensor, point, centre) for point in points])  # how far below the centre's
    mean = w_mean @ below
    nu, apart = innovation(model, sensor, points[0], z) + mean, below - mean
    S = apart.T @ (w_cov[:, None] * apart) + model.model.variances[sensor] * np.eye(len(nu))
    cross = -offsets.T @ (w_cov[:, None] * apart)  # falls as the prediction rises
    gain = np.linalg.solve(S, cross.T).T
    nis = float(nu @ np.linalg.solve(S, nu))
    weight = rule.weight(nis, len(nu))
    seen = Seen(nu, np.diag(S).copy(), nis, weight if weight > 0 else 0.0)
    if not seen.used:
        return x, P, seen
    P = P - weight * gain @ S @ gain.T
    return model.inject(x, weight * gain @ nu), (P + P.T) / 2, seen
