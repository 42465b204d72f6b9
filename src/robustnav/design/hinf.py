"""H-infinity observers: the worst-case energy gain from noise to estimation error is bounded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.design.certificates import Certificate, norm_reasons, residual_reasons
from robustnav.design.matrices import modes
from robustnav.design.plant import Plant
from robustnav.design.riccati import filter_riccati
from robustnav.design.scaling import Scaling
from robustnav.errors import EstimatorError, InputError
from robustnav.records import Array

_BISECTION = 1e-6  # relative width at which the smallest gamma counts as found
_NORM_TOLERANCE = 1e-6  # relative accuracy of the Hamiltonian norm
_SWEEP_POINTS = 400


@dataclass(frozen=True)
class HinfDesign:
    """A constant observer gain whose worst-case energy gain from w to the error of z is below ``gamma``.

    Parameters
    ----------
    plant : what it was designed for.
    L : (n, m) gain of x_hat' = A x_hat + B u + L (y_hat - y).
    gamma : bound promised, in the unit of z per unit of w.
    swept : largest gain found on a frequency grid; a lower bound on the norm.
    certificate : ``verified`` is the norm from Hamiltonian eigenvalues; always ok on a returned design.
    """

    plant: Plant
    L: Array
    gamma: float
    swept: float
    certificate: Certificate


def hinf_observer(plant: Plant, gamma: float | None = None, relax: float = 1.01) -> HinfDesign:
    """Design the central H-infinity observer from the filter Riccati equation.

    Parameters
    ----------
    plant : what to design for.
    gamma : bound to meet; None takes ``relax`` times the smallest feasible one, found by bisection.
    relax : above one; gains at the smallest gamma itself are ill-conditioned.

    Raises
    ------
    EstimatorError : ``gamma`` cannot be met, or the certificate fails.
    InputError : ``gamma`` is not above zero or ``relax`` not above one.

    References
    ----------
    Zhou, Doyle, Glover (1996), section 16.8; Shaked, Theodor, CDC 1992.
    """
    if gamma is not None and not gamma > 0:
        raise InputError("H-infinity bound gamma", got=str(gamma), expected="a number above zero, or None")
    if not relax > 1:
        raise InputError("H-infinity option relax", got=str(relax), expected="a number above one")
    units = Scaling.expected(plant, np.sqrt(np.diag(filter_riccati(plant).P)))
    scaled = units.apply(plant)
    level = relax * _smallest_gamma(scaled) if gamma is None else gamma / units.size
    solution = filter_riccati(scaled, level)
    return certified_hinf(plant, units.gain(solution.gain(scaled)), level * units.size, solution.residual)


def certified_hinf(plant: Plant, L: Array, gamma: float, residual: float) -> HinfDesign:
    """Return the design with gain L (n, m), or raise ``EstimatorError`` unless two other routes confirm ``gamma``."""
    F, B = plant.closed_loop(L)
    poles = modes(F)
    margin = -float(poles.real.max())
    if margin > 0:
        swept = frequency_sweep(F, B, plant.C_z)
        verified = hinf_norm(F, B, plant.C_z)
        reasons = norm_reasons(gamma, verified, 1e-5) + residual_reasons(residual)
        if not swept <= verified * (1 + 10 * _NORM_TOLERANCE):
            reasons += (f"frequency sweep: {swept:.6g} found above the norm {verified:.6g}",)
    else:
        swept = verified = np.inf
        reasons = (f"stability: a closed-loop pole has real part {-margin:.3g} 1/s",)
    time_constant = 1 / margin if margin > 0 else np.inf
    certificate = Certificate("H-infinity", gamma, verified, residual, poles, margin, time_constant, reasons)
    certificate.require("the H-infinity observer")
    return HinfDesign(plant, L, gamma, swept, certificate)


def frequency_sweep(F: Array, B: Array, C: Array) -> float:
    """Return the largest singular value of C (jw I - F)^-1 B over a grid of w that spans the poles of F, and w = 0."""
    size = np.abs(modes(F))
    grid = np.geomspace(size.min() / 100, size.max() * 100, _SWEEP_POINTS)
    return max(_gain_at(F, B, C, w) for w in (0.0, *size, *grid))


def hinf_norm(F: Array, B: Array, C: Array) -> float:
    """Return the H-infinity norm of C (s I - F)^-1 B, F stable, to six digits.

    The gain crosses a level exactly at the imaginary eigenvalues of a Hamiltonian matrix; the level is raised to the
    largest gain found between crossings until none is left.

    References
    ----------
    Bruinsma, Steinbuch, Systems & Control Letters 14 (1990).
    """
    poles = modes(F)
    level = max(_gain_at(F, B, C, w) for w in (0.0, *np.abs(poles), *np.abs(poles.imag)))
    for _ in range(100):
        trial = level * (1 + 2 * _NORM_TOLERANCE)
        if trial == 0:
            return 0.0
        crossings = _crossings(F, B, C, trial)
        if len(crossings) == 0:
            return level * (1 + _NORM_TOLERANCE)
        between = (crossings[1:] + crossings[:-1]) / 2
        raised = max(_gain_at(F, B, C, w) for w in (*between, *crossings))
        if raised <= trial:  # crossings that rounding has put on the axis
            return trial
        level = raised
    raise EstimatorError("the H-infinity norm was not found", got="no end after 100 steps")


def _gain_at(F: Array, B: Array, C: Array, frequency: float) -> float:
    response = C @ np.linalg.solve(1j * frequency * np.eye(len(F)) - F, B)
    return float(np.linalg.norm(response, 2))


def _crossings(F: Array, B: Array, C: Array, level: float) -> Array:
    """Return the frequencies >= 0, sorted, where the largest singular value may equal ``level``."""
    hamiltonian = np.block([[F, B @ B.T / level], [-C.T @ C / level, -F.T]])
    found = modes(hamiltonian)
    on_axis = np.abs(found.real) < 1e-8 * np.maximum(np.abs(found), np.abs(found).max() * 1e-6)
    return np.unique(np.abs(found[on_axis].imag))


def _smallest_gamma(scaled: Plant) -> float:
    """Return the smallest gamma (scaled units) at which the filter Riccati equation has a solution."""
    L = filter_riccati(scaled).gain(scaled)
    high = hinf_norm(*scaled.closed_loop(L), scaled.C_z) * 1.001  # met by the H2 gain, hence feasible
    low = 0.0
    while high - low > _BISECTION * high:
        middle = (low + high) / 2
        if _feasible(scaled, middle):
            high = middle
        else:
            low = middle
    return high


def _feasible(scaled: Plant, gamma: float) -> bool:
    try:
        filter_riccati(scaled, gamma)
    except EstimatorError:
        return False
    return True
