"""Observer gains from linear matrix inequalities: nominal H2, one gain for a polytope, structured gains, H-infinity.

Every problem is solved in scaled units and every returned gain is certified without the solver's word.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robustnav.design.certificates import Certificate, error_covariance, verify_h2
from robustnav.design.hinf import HinfDesign, certified_hinf
from robustnav.design.matrices import symmetric
from robustnav.design.plant import Plant
from robustnav.design.riccati import H2Design, filter_riccati, h2_riccati
from robustnav.design.scaling import Scaling
from robustnav.errors import EstimatorError, InputError, MissingExtra
from robustnav.records import Array, BoolArray

_SOLVER_TOLERANCE = 1e-5  # relative excess over a bound that an interior-point solver leaves
_SUBOPTIMAL = 1e-3  # relative distance from the Riccati optimum at which an LMI solution is refused
_TIGHT = {"tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11, "tol_feas": 1e-11}  # gains err by the root of the gap
_STRICT = 1e-7  # margin kept in "< 0", scaled units, where the bound is recomputed from X


@dataclass(frozen=True)
class PolytopeDesign:
    """One gain for every plant in the convex hull of some vertices, with a bound that holds for all.

    Parameters
    ----------
    plants : the vertices.
    L : (n, m) common gain of x_hat' = A(p) x_hat + B u + L (y_hat - y); the observer's own model follows p.
    gamma : H2 norm that no plant of the hull exceeds, recomputed from the common Lyapunov matrix.
    certificates : one per vertex, each against ``gamma``.
    """

    plants: tuple[Plant, ...]
    L: Array
    gamma: float
    certificates: tuple[Certificate, ...]


def h2_lmi(plant: Plant, scaling: ArrayLike | None = None) -> H2Design:
    """Design the H2-optimal observer by semidefinite programming.

    Minimises trace(Z) over W, symmetric Z and X subject to three conditions, and returns L = X^-1 W::

        [XA + W C_y + (.)'   X B_w + W D_w]         [-Z  C_z']
        [       *                 -I      ] < 0     [ *   -X ] < 0      trace(Z) < gamma^2

    Parameters
    ----------
    plant : what to design for.
    scaling : (n,) expected standard deviations of the error, each in its state's unit; None takes them from the
        Riccati solution.  Without scaling a solver may report an optimum ten times off.

    Raises
    ------
    MissingExtra : cvxpy is not installed (extra ``lmi``).
    EstimatorError : the solver found nothing, or its gain fails the certificate.

    References
    ----------
    Kim, Tadiparthi, Bhattacharya, ACC 2020; Duan, Yu, LMIs in Control Systems (2013), H2 observers.
    """
    units = Scaling.expected(plant, _expected_sd([plant]) if scaling is None else np.asarray(scaling, float))
    problem = _Problem([units.apply(plant)])
    X, W, gamma = problem.solve()
    design = _admit(plant, units.gain(_gain(X, W)), gamma * units.size, "the H2 observer from the LMI")
    best = h2_riccati(plant).gamma
    if design.certificate.verified > best * (1 + _SUBOPTIMAL):
        raise EstimatorError(
            "the semidefinite program stopped before its optimum",
            got=f"norm {design.certificate.verified:.6g}",
            expected=f"{best:.6g}, which the Riccati equation reaches",
            do="leave scaling to None, or give standard deviations nearer to those of the error",
        )
    return design


def h2_lmi_structured(plant: Plant, pattern: ArrayLike) -> H2Design:
    """Design an H2 observer whose gain is zero wherever ``pattern`` is False.

    W takes the pattern and X is block diagonal over groups of states whose rows have the same pattern, which makes
    L = X^-1 W keep it.  The restriction of X is conservative: the true norm (``certificate.verified``) is usually below
    ``gamma``, another gain of the same pattern may be better still, and a feasible pattern may be refused.

    Parameters
    ----------
    plant : what to design for.
    pattern : (n, m) True where the gain may differ from zero.

    Raises
    ------
    InputError : the pattern has another shape.
    MissingExtra, EstimatorError : as :func:`h2_lmi`.
    """
    mask = np.asarray(pattern, bool)
    if mask.shape != plant.C_y.T.shape:
        raise InputError("gain pattern", got=f"shape {mask.shape}", expected=f"shape {plant.C_y.T.shape}")
    units = Scaling.expected(plant, _expected_sd([plant]))
    correlated = plant.R - np.diag(np.diag(plant.R))
    if np.any(correlated):
        raise InputError("structured gain", got="correlated sensor noises", expected="a diagonal D_w D_w'")
    scaled = units.apply(plant)
    X, W, _ = _Problem([scaled], mask, strict=_STRICT).solve()
    L = np.where(mask, _gain(X, W), 0.0)
    gamma = _bound([scaled], X, L) * units.size
    return _admit(plant, units.gain(L), gamma, "the structured H2 observer")


def h2_lmi_polytope(plants: Sequence[Plant]) -> PolytopeDesign:
    """Design one gain whose H2 norm is bounded over the convex hull of ``plants`` by a common Lyapunov matrix.

    For a parameter the observer knows (its model follows it) but its gain does not.  The bound also holds while the
    parameter varies, as a bound on the error's mean square.  Conservative for a parameter that stays constant.

    Parameters
    ----------
    plants : vertices of equal shape; in between, all five matrices move together.

    Raises
    ------
    InputError : no plants, or plants of different shapes.
    MissingExtra, EstimatorError : as :func:`h2_lmi`.

    References
    ----------
    Boyd, El Ghaoui, Feron, Balakrishnan, Linear Matrix Inequalities (1994), section 6.3; Apkarian, Tuan, Bernussou,
    IEEE TAC 46 (2001).
    """
    shapes = {tuple(M.shape for M in (p.A, p.B_w, p.C_y, p.C_z)) for p in plants}
    if len(shapes) != 1:
        raise InputError(
            "polytope", got=f"{len(plants)} plants of {len(shapes)} shapes", expected="plants of one shape"
        )
    centre = Scaling.expected(plants[0], _expected_sd(plants))
    outputs = np.asarray(np.linalg.cholesky(np.mean([p.R for p in plants], axis=0)))
    units = Scaling(centre.states, outputs, centre.size)
    scaled = [units.apply(p) for p in plants]
    X, W, _ = _Problem(scaled, strict=_STRICT).solve()
    L_scaled = _gain(X, W)
    gamma = _bound(scaled, X, L_scaled) * units.size
    L = units.gain(L_scaled)
    certificates = tuple(verify_h2(plant, L, gamma) for plant in plants)
    for i, certificate in enumerate(certificates):
        certificate.require(f"the polytope observer at vertex {i}")
    return PolytopeDesign(tuple(plants), L, gamma, certificates)


def hinf_lmi(plant: Plant, relax: float = 1.01) -> HinfDesign:
    """Design an H-infinity observer from the bounded real lemma by semidefinite programming.

    First finds the smallest gamma, then, at ``relax`` times it, the largest X, which is the central design: gains at
    the optimum itself are ill-conditioned.

    Raises
    ------
    MissingExtra, EstimatorError : as :func:`h2_lmi`.

    References
    ----------
    Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.7.3.
    """
    cp = _cvxpy()
    units = Scaling.expected(plant, _expected_sd([plant]))
    scaled = units.apply(plant)
    n, m = scaled.C_y.T.shape
    X, W, level = cp.Variable((n, n), symmetric=True), cp.Variable((n, m)), cp.Variable(nonneg=True)
    drift = X @ scaled.A + W @ scaled.C_y
    noise = X @ scaled.B_w + W @ scaled.D_w
    energy = -level * np.eye(noise.shape[1])
    block = cp.bmat([[drift + drift.T + scaled.C_z.T @ scaled.C_z, noise], [noise.T, energy]])
    limits = [(block + block.T) / 2 << 0, X >> 0]
    _solve(cp, cp.Problem(cp.Minimize(level), limits))
    chosen = float(level.value) * relax**2
    _solve(cp, cp.Problem(cp.Maximize(cp.trace(X)), [*limits, level == chosen]))
    L = units.gain(_gain(symmetric(X.value), W.value))
    violation = max(float(np.linalg.eigvalsh(symmetric(block.value))[-1]), 0.0) / float(np.abs(block.value).max())
    return certified_hinf(plant, L, float(np.sqrt(chosen)) * units.size, violation)


def _gain(X: Array, W: Array) -> Array:
    return np.asarray(np.linalg.solve(X, W), float)


def _expected_sd(plants: Sequence[Plant]) -> Array:
    variances = [np.diag(filter_riccati(plant).P) for plant in plants]
    return np.asarray(np.sqrt(np.mean(variances, axis=0)))


def _admit(plant: Plant, L: Array, gamma: float, design: str) -> H2Design:
    certificate = verify_h2(plant, L, gamma, tolerance=_SOLVER_TOLERANCE)
    certificate.require(design)
    return H2Design(plant, L, error_covariance(plant, L), gamma, certificate)


class _Problem:
    """The H2 conditions for some scaled plants with common W and X, ready to solve."""

    def __init__(self, plants: Sequence[Plant], pattern: BoolArray | None = None, strict: float = 0.0) -> None:
        self.cp = cp = _cvxpy()
        n, m = plants[0].C_y.T.shape
        self.X = cp.Variable((n, n), symmetric=True)
        self.W = cp.Variable((n, m))
        self.level = cp.Variable()
        self.limits: list[Any] = []
        for plant in plants:
            self._add(plant, strict)
        if pattern is not None:
            together = (pattern[:, None, :] == pattern[None, :, :]).all(axis=2)
            self.limits += [cp.multiply(self.W, ~pattern) == 0, cp.multiply(self.X, ~together) == 0]

    def _add(self, plant: Plant, strict: float) -> None:
        cp, X = self.cp, self.X
        p = len(plant.C_z)
        Z = cp.Variable((p, p), symmetric=True)
        drift = X @ plant.A + self.W @ plant.C_y
        noise = X @ plant.B_w + self.W @ plant.D_w
        error = cp.bmat([[drift + drift.T + strict * np.eye(len(plant.A)), noise], [noise.T, -np.eye(noise.shape[1])]])
        size = cp.bmat([[-Z, plant.C_z], [plant.C_z.T, -X]])
        # Halving with the transpose tells cvxpy what the blocks already ensure: that the matrices are symmetric.
        self.limits += [(error + error.T) / 2 << 0, (size + size.T) / 2 << 0, cp.trace(Z) <= self.level]

    def solve(self) -> tuple[Array, Array, float]:
        """Return X, W and the norm the solver claims."""
        _solve(self.cp, self.cp.Problem(self.cp.Minimize(self.level), self.limits))
        return symmetric(self.X.value), self.W.value, float(np.sqrt(self.level.value))


def _bound(plants: Sequence[Plant], X: Array, L: Array) -> float:
    """Return the H2 norm that X proves for all plants with gain L (scaled units).

    X / s satisfies the first condition for the smallest s with  X F + F'X + X B B'X / s <= 0  at every vertex; then
    trace(C_z X^-1 C_z') s bounds the squared norm over the hull.  This does not trust the solver's tolerances.
    """
    from scipy.linalg import LinAlgError, eigh

    stretch, size = 0.0, 0.0
    for plant in plants:
        F, B = plant.closed_loop(L)
        try:
            worst = eigh(symmetric(X @ B @ B.T @ X), -symmetric(X @ F + F.T @ X), eigvals_only=True)[-1]
            covariance = np.linalg.inv(np.linalg.cholesky(X))
        except LinAlgError as why:
            raise EstimatorError(
                "the common Lyapunov matrix proves nothing",
                got="X, or -(X F + F'X) at a vertex, is not positive definite",
                expected="both positive definite",
                do="use fewer or closer vertices, or allow more gain entries",
            ) from why
        stretch = max(stretch, float(worst))
        size = max(size, float(np.sum((covariance @ plant.C_z.T) ** 2)))
    return float(np.sqrt(stretch * size))


def _cvxpy() -> Any:
    try:
        import cvxpy
    except ImportError:
        raise MissingExtra("cvxpy", "lmi") from None
    return cvxpy


def _solve(cp: Any, problem: Any) -> None:
    """Solve with Clarabel, or raise ``EstimatorError`` with its status."""
    try:
        with warnings.catch_warnings():
            # "Solution may be inaccurate": every gain is certified afterwards, which says more.
            warnings.simplefilter("ignore", UserWarning)
            problem.solve(solver=cp.CLARABEL, **_TIGHT)
    except cp.SolverError as why:
        raise EstimatorError("the semidefinite program was not solved", got=str(why)) from why
    if problem.status not in ("optimal", "optimal_inaccurate"):
        raise EstimatorError(
            "the semidefinite program was not solved",
            got=f"status {problem.status}",
            expected="optimal",
            do="allow more gain entries, use closer vertices, or scale the states",
        )
