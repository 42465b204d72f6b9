"""The H2-optimal observer from the filter Riccati equation; it is the steady-state Kalman filter."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robustnav.design.certificates import Certificate, residual_reasons, verify_h2
from robustnav.design.matrices import covariance_difference, right_divide, symmetric
from robustnav.design.plant import Plant
from robustnav.errors import EstimatorError
from robustnav.records import Array


@dataclass(frozen=True)
class H2Design:
    """A constant observer gain that keeps the H2 norm from noise to estimation error below ``gamma``.

    Parameters
    ----------
    plant : what it was designed for.
    L : (n, m) gain of x_hat' = A x_hat + B u + L (y_hat - y); minus the Kalman gain.
    P : (n, n) stationary error covariance with this gain.
    gamma : H2 norm promised, in the unit of z.
    certificate : the second opinion; always ok on a returned design.
    """

    plant: Plant
    L: Array
    P: Array
    gamma: float
    certificate: Certificate


@dataclass(frozen=True)
class RiccatiSolution:
    """Stabilising solution ``P`` (n, n) of a filter Riccati equation and its relative ``residual``."""

    P: Array
    residual: float

    def gain(self, plant: Plant) -> Array:
        """Return L = -(P C_y' + S) R^-1 (n, m)."""
        return -right_divide(self.P @ plant.C_y.T + plant.S, plant.R)


def filter_riccati(plant: Plant, gamma: float = np.inf) -> RiccatiSolution:
    """Solve A P + P A' + Q - (P C_y' + S) R^-1 (P C_y' + S)' + P C_z' C_z P / gamma^2 = 0 for its stabilising P >= 0.

    An infinite ``gamma`` drops the last term and leaves the H2 (Kalman) equation.

    Raises
    ------
    EstimatorError : no stabilising positive semidefinite solution exists.

    References
    ----------
    Zhou, Doyle, Glover (1996), sections 14.5 and 16.8 (with estimate C_z x_hat).
    """
    from scipy.linalg import LinAlgError, solve_continuous_are

    C, R, S, zeros = plant.C_y, plant.R, plant.S, np.zeros((len(plant.C_y), len(plant.C_z)))
    if np.isfinite(gamma):
        worst = -np.eye(len(plant.C_z))
        C = np.vstack([C, plant.C_z / gamma])
        R = np.block([[R, zeros], [zeros.T, worst]])
        S = np.hstack([S, np.zeros((len(S), len(worst)))])
    try:
        P = symmetric(solve_continuous_are(plant.A.T, C.T, plant.Q, R, s=S))
    except (LinAlgError, ValueError) as why:
        raise EstimatorError("the filter Riccati equation has no stabilising solution", got=str(why)) from why
    fed = P @ C.T + S
    gain = right_divide(fed, R)
    lowest = float(np.linalg.eigvalsh(P)[0])
    slowest = float(np.linalg.eigvals(plant.A - gain @ C).real.max())
    if lowest < -1e-9 * np.abs(P).max() or not slowest < 0:
        raise EstimatorError(
            "the filter Riccati equation has no stabilising solution",
            got=f"smallest eigenvalue {lowest:.3g}, slowest pole {slowest:.3g} 1/s",
            expected="P >= 0 and all poles left of zero",
        )
    terms = plant.A @ P + P @ plant.A.T + plant.Q - gain @ fed.T
    return RiccatiSolution(P, covariance_difference(terms + P, P) / max(1.0, float(np.abs(plant.A).max())))


def h2_riccati(plant: Plant) -> H2Design:
    """Design the H2-optimal observer of a plant; the optimum does not depend on ``C_z``.

    Parameters
    ----------
    plant : noise that enters both state and output (B_w D_w' not zero) is allowed.

    Raises
    ------
    EstimatorError : no stabilising solution, or the certificate fails.

    References
    ----------
    Kim, Tadiparthi, Bhattacharya, ACC 2020 (observer form); Zhou, Doyle, Glover (1996), section 14.5.
    """
    solution = filter_riccati(plant)
    L = solution.gain(plant)
    gamma = float(np.sqrt(np.trace(plant.C_z @ solution.P @ plant.C_z.T)))
    certificate = verify_h2(plant, L, gamma)
    complaint = residual_reasons(solution.residual)
    certificate = replace(certificate, residual=solution.residual, reasons=certificate.reasons + complaint)
    certificate.require("the H2 observer")
    return H2Design(plant, L, solution.P, gamma, certificate)
