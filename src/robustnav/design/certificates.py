"""Second opinions on a gain: what was promised, what another route finds, and whether the design may be used."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from robustnav.design.matrices import ComplexArray, covariance_difference, matrix, modes, symmetric
from robustnav.design.plant import Plant
from robustnav.errors import EstimatorError
from robustnav.records import Array

RESIDUAL_LIMIT = 1e-8


@dataclass(frozen=True)
class Certificate:
    """What a design promised and what a second route found.

    Parameters
    ----------
    kind : what was certified: ``H2``, ``H-infinity``, ``periodic H2``.
    promised : norm the design claims, an upper bound, in the unit of z.
    verified : the same norm by the second route; infinite when the loop is unstable.
    residual : relative residual of the design equation, unit-free.
    eigenvalues : (n,) of the closed loop [1/s], or of its map over one period.
    margin : distance of the slowest mode from instability: -max Re [1/s], or 1 - spectral radius per period.
    time_constant : of the slowest mode [s]; the estimator has forgotten its start after a few of these.
    reasons : why the design must not be used, one line each; empty when it may.
    """

    kind: str
    promised: float
    verified: float
    residual: float
    eigenvalues: ComplexArray
    margin: float
    time_constant: float
    reasons: tuple[str, ...] = field(default=())

    @property
    def ok(self) -> bool:
        """Whether every check passed."""
        return not self.reasons

    @property
    def ratio(self) -> float:
        """Norm verified over norm promised: below one where a bound is conservative, above where gains are held."""
        return self.verified / self.promised

    def require(self, design: str) -> None:
        """Raise ``EstimatorError`` naming the failed checks unless the design may be used."""
        if self.reasons:
            raise EstimatorError(
                f"{design} fails its certificate",
                got="; ".join(self.reasons),
                expected="a stable loop, a small residual and a norm not above the one promised",
                do="check noise sizes and units, or scale the states by their expected standard deviations",
            )


def error_covariance(plant: Plant, L: Array) -> Array:
    """Return the stationary error covariance (n, n) of the observer with gain L (n, m), from the Lyapunov equation.

    Solved twice, the second time in units of the first solution, so that small states keep their digits.
    """
    from scipy.linalg import solve_continuous_lyapunov

    F, B = plant.closed_loop(L)
    T = np.ones(len(F))
    for _ in range(2):
        P = solve_continuous_lyapunov(F * T / T[:, None], -(B / T[:, None]) @ (B / T[:, None]).T)
        P = symmetric(P) * np.outer(T, T)
        sd = np.sqrt(np.maximum(np.diag(P), 0.0))
        T = np.where(sd > 0, sd, 1.0)
    return np.asarray(P, float)


def verify_h2(plant: Plant, L: ArrayLike, promised: float, tolerance: float = 1e-6) -> Certificate:
    """Certify an H2 observer gain by the Lyapunov equation of its closed loop and by its poles.

    Parameters
    ----------
    plant : what the gain is for.
    L : (n, m) gain of x_hat' = A x_hat + B u + L (y_hat - y).
    promised : H2 norm from w to the error of z that the design claims as an upper bound.
    tolerance : relative excess over the promise still accepted.

    References
    ----------
    Zhou, Doyle, Glover (1996), section 4.6.
    """
    L = matrix(L, (len(plant.A), len(plant.C_y)), "observer gain L")
    F, B = plant.closed_loop(L)
    poles = modes(F)
    margin = -float(poles.real.max())
    if not margin > 0:
        unstable = (f"stability: a closed-loop pole has real part {-margin:.3g} 1/s",)
        return Certificate("H2", promised, np.inf, np.inf, poles, margin, np.inf, unstable)
    P = error_covariance(plant, L)
    residual = covariance_difference(F @ P + P @ F.T + B @ B.T + P, P) / max(1.0, float(np.abs(poles).max()))
    verified = float(np.sqrt(np.trace(plant.C_z @ P @ plant.C_z.T)))
    reasons = norm_reasons(promised, verified, tolerance) + residual_reasons(residual)
    return Certificate("H2", promised, verified, residual, poles, margin, 1 / margin, reasons)


def norm_reasons(promised: float, verified: float, tolerance: float) -> tuple[str, ...]:
    """Return the complaint that a verified norm exceeds the promise, if it does (a NaN does)."""
    if verified <= promised * (1 + tolerance):
        return ()
    return (f"norm: {verified:.6g} found, {promised:.6g} promised",)


def residual_reasons(residual: float) -> tuple[str, ...]:
    """Return the complaint that a design equation is not solved, if so (a NaN is)."""
    return () if residual <= RESIDUAL_LIMIT else (f"residual: {residual:.3g}, above {RESIDUAL_LIMIT:.0e}",)


@dataclass(frozen=True)
class RateHistoryCertificate:
    """Whether a constant nav-frame gain is stable whatever the body rate does.

    Parameters
    ----------
    lowest_bias : smallest eigenvalue of A2 [1/s^2], which must be above zero.
    asymmetry : largest entry of A2 - A2' relative to the largest of A2.
    lowest_damping : smallest eigenvalue of A2 A1 + A1' A2 [1/s^3], which must be above zero.
    reasons : failed checks, one line each.
    """

    lowest_bias: float
    asymmetry: float
    lowest_damping: float
    reasons: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether V proves stability for every rate history."""
        return not self.reasons


def rate_history_certificate(
    K_theta: ArrayLike, K_b: ArrayLike, H_theta: ArrayLike, dt: float
) -> RateHistoryCertificate:
    """Check V = eps' A2 eps + beta' beta for the error eps' = -beta - A1 eps, beta' = [omega]x beta + A2 eps.

    With A1 = K_theta H / dt and A2 = -K_b H / dt, V' = -2 eps' A2 A1 eps for any omega(t), so V never grows if A2 is
    symmetric positive and A2 A1 + A1' A2 is positive.  (Sufficient, for the linearised error and small dt.)

    Parameters
    ----------
    K_theta, K_b : (3, m) gains on attitude [rad per unit] and gyro bias [rad/s per unit], nav frame, one tick.
    H_theta : (m, 3) attitude columns of the outputs.
    dt : tick [s].
    """
    H = matrix(H_theta, (-1, 3), "attitude columns H_theta")
    A1 = matrix(K_theta, (3, len(H)), "attitude gain K_theta") @ H / dt
    A2 = -matrix(K_b, (3, len(H)), "bias gain K_b") @ H / dt
    asymmetry = float(np.abs(A2 - A2.T).max() / max(np.abs(A2).max(), np.finfo(float).tiny))
    lowest_bias = float(np.linalg.eigvalsh(symmetric(A2))[0])
    lowest_damping = float(np.linalg.eigvalsh(A2 @ A1 + A1.T @ A2)[0])
    reasons = []
    if not asymmetry <= 1e-9:
        reasons.append(f"A2 is asymmetric by {asymmetry:.3g}")
    if not lowest_bias > 0:
        reasons.append(f"A2 has the eigenvalue {lowest_bias:.3g} 1/s^2")
    if not lowest_damping > 0:
        reasons.append(f"A2 A1 + A1' A2 has the eigenvalue {lowest_damping:.3g} 1/s^3")
    return RateHistoryCertificate(lowest_bias, asymmetry, lowest_damping, tuple(reasons))
