"""Check a model before it is trusted: its Jacobians, its step, what it claims of frames, what its sensors can see.

The derivation is symbolic and does not go wrong; equations do.  They may have no derivative somewhere, claim that a
vector is fixed in navigation axes when it is not, or leave a part of the state that no sensor tells of.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from robustnav.errors import RobustnavError
from robustnav.frames import Array, matrix_from_quat, quat_conjugate, quat_from_rotvec, quat_multiply
from robustnav.model.blocks import Model, Rotation
from robustnav.model.derive import Derivation
from robustnav.model.functions import NumericModel, evaluator

# What a user's equations raise when they do not fit their blocks.
_MISTAKES = (RobustnavError, ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)
_JACOBIAN_LIMIT = 1e-4  # central differences are good to about 1e-8
_STEP_LIMIT = 0.1
_CLAIM_LIMIT = 1e-6


@dataclass(frozen=True)
class ModelCheck:
    """What ``check_model`` found.

    Parameters
    ----------
    model : its name.
    samples : random states tried, beside the nominal one and one next to it.
    worst : largest relative deviation by what was compared: ``A``, ``G``, ``F``, ``H of <sensor>``, ``turned body``.
    rank, error_size : how many error directions the sensors see at the nominal point, of how many.
    unobservable : the directions that no sensor sees, by block and axis.
    findings : what is wrong or worth knowing, in words; empty when nothing is.
    """

    model: str
    samples: int
    worst: Mapping[str, float] = field(default_factory=dict)
    rank: int = 0
    error_size: int = 0
    unobservable: tuple[str, ...] = ()
    findings: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether nothing was found."""
        return not self.findings


def check_model(model: Model, *, samples: int = 20, seed: int = 0, dt: float = 0.01) -> ModelCheck:
    """Check a model at its nominal state, 1e-8 rad beside it and at random states.

    A, G and H are compared with differences taken on the manifold, the transition F with differences of the step.
    A sensor among ``directions`` and a block with ``frame="b"`` claim that turning the body axes changes nothing but
    body vectors; that is tried.  Observability is that of (F, H) at the nominal point.

    Parameters
    ----------
    model : the model; nothing needs to be compiled.
    samples : random states, drawn around the nominal one with ``start_sd`` (1 where not given), attitudes uniform.
    seed : of the random states.
    dt : step [s] the transition is compared over.

    Returns
    -------
    ModelCheck : also for a model that cannot be derived at all; nothing is raised.
    """
    try:
        with np.errstate(all="ignore"):
            return _Check(model, dt).run(samples, seed)
    except _MISTAKES as why:
        return ModelCheck(model.name, samples, error_size=model.error_size, findings=(_words(why),))


class _Check:
    def __init__(self, model: Model, dt: float) -> None:
        self.model, self.dt, self.numeric = model, dt, NumericModel(model)
        derivation = Derivation(model)
        self.in_steps = bool(derivation.steps)
        lists = [derivation.x, derivation.u, derivation.w, derivation.p]
        rates = [] if self.in_steps else [e for b in model.state for e in derivation.rates[b.name]]
        self._rate = evaluator(lists, rates)
        self.noise_size = len(derivation.w)
        self.directions = set(derivation.directions)
        self.scale = _error_scale(model)
        self.worst: dict[str, float] = {}
        self._rng = np.random.default_rng(0)
        self.findings: list[str] = []

    def run(self, samples: int, seed: int) -> ModelCheck:
        rng = self._rng = np.random.default_rng(seed)
        for x, u in self._states(samples, rng):
            self._jacobians(x, u)
            self._transition(x, u)
            if self._claims():
                self._turned_body(x, u, rng.normal(size=3))
        self._judge()
        if not self.model.sensors:
            self.findings.append("no sensor: nothing corrects the state")
        seen, unseen = self._observability()
        if unseen:
            self.findings.append(f"no sensor sees {', '.join(unseen)} at the nominal point")
        self._c_form()
        n = self.model.error_size
        return ModelCheck(self.model.name, samples, self.worst, seen, n, unseen, tuple(self.findings))

    def _states(self, samples: int, rng: np.random.Generator) -> Iterator[tuple[Array, Array]]:
        x, u = self.model.nominal_state(), self.model.nominal_input()
        rotation = self.model.rotation
        beside = np.zeros(self.model.error_size)
        if rotation is not None:
            beside[self.model.error_slices[rotation.name]] = 1e-8
        yield x, u
        yield self.numeric.inject(x, beside), u
        for _ in range(samples):
            away = self.numeric.inject(x, self.scale * rng.normal(size=len(self.scale)))
            if rotation is not None:
                q = rng.normal(size=4)
                away[self.model.state_slices[rotation.name]] = q / np.linalg.norm(q)
            yield away, u + rng.normal(size=len(u))

    def _known(self, sensor: int) -> Array:
        """Draw what travels with a reading: anchors and lever arms anywhere within metres."""
        return 5.0 * self._rng.normal(size=sum(k.size for k in self.model.sensors[sensor].known))

    def _error_growth(self, x: Array, u: Array, e: Array, w: Array) -> Array:
        """Return d/dt of the error that is e now, from the rates of both states and nothing else."""
        p = self.model.parameter_values
        truth = self.numeric.inject(x, e)
        rate, rate_true = self._rate(x, u, np.zeros_like(w), p), self._rate(truth, u, w, p)
        out = rate_true - rate
        rotation = self.model.rotation
        if rotation is None:
            return out
        part, rows = self.model.state_slices[rotation.name], self.model.error_slices[rotation.name]
        back, omega, omega_true = quat_conjugate(x[part]), np.r_[0.0, rate[rows]], np.r_[0.0, rate_true[rows]]
        if rotation.error == "n":
            q = quat_multiply(truth[part], back)
            dq = quat_multiply(quat_multiply(truth[part], omega_true - omega), back) / 2
        else:
            q = quat_multiply(back, truth[part])
            dq = (quat_multiply(q, omega_true) - quat_multiply(omega, q)) / 2
        out[rows] = 2 * (dq[1:] * q[0] - q[1:] * dq[0]) / q[0] ** 2
        return out

    def _jacobians(self, x: Array, u: Array) -> None:
        numeric = self.numeric
        if not self.in_steps:
            self._growth(x, u)
        for j, sensor in enumerate(self.model.sensors):
            known = self._known(j)
            z = np.concatenate([numeric.measure(j, x, known), known])

            def predicted(e: Array, j: int = j, z: Array = z) -> Array:
                return -numeric.residual(j, numeric.inject(x, e), z)

            H = _differences(predicted, 1e-4 * self.scale)
            self._keep(f"H of {sensor.name}", numeric.jacobian(j, x, known), H, self.scale)

    def _growth(self, x: Array, u: Array) -> None:
        numeric, n = self.numeric, self.model.error_size
        A, G = numeric.error_rate(x, u)
        e0, w0, ones = np.zeros(n), np.zeros(self.noise_size), np.ones(self.noise_size)
        self._keep("A", A, _differences(lambda e: self._error_growth(x, u, e, w0), 1e-4 * self.scale), self.scale)
        G_seen, start = _differences(lambda w: self._error_growth(x, u, e0, w), 1e-4 * ones), 0
        for noise in self.model.noises:  # G G' is what counts: isotropic noise is left unturned
            part = slice(start, start := start + noise.size)
            self._keep("G", G[:, part] @ G[:, part].T, G_seen[:, part] @ G_seen[:, part].T, np.ones(n))

    def _transition(self, x: Array, u: Array) -> None:
        numeric, dt = self.numeric, self.dt
        after = numeric.propagate(x, u, dt)

        def moved(e: Array) -> Array:
            return numeric.difference(numeric.propagate(numeric.inject(x, e), u, dt), after)

        F, one = numeric.transition(x, u, dt)[0], np.eye(self.model.error_size)
        self._keep("F", F - one, _differences(moved, 1e-4 * self.scale) - one, self.scale)

    def _claims(self) -> bool:
        body = any(b.frame == "b" for b in self.model.state)
        return not self.in_steps and self.model.rotation is not None and (body or bool(self.directions))

    def _rates_claimed(self) -> bool:
        rotation = self.model.rotation
        return any(b.frame == "b" for b in self.model.state) or (rotation is not None and rotation.error == "n")

    def _turned_body(self, x: Array, u: Array, rotvec: Array) -> None:
        """Give the body other axes: what stands in navigation axes must not notice."""
        model, numeric, p = self.model, self.numeric, self.model.parameter_values
        rotation = model.rotation
        S = matrix_from_quat(quat_from_rotvec(rotvec))
        x_turned, u_turned, start = x.copy(), u.copy(), 0
        for block in model.state:
            part = model.state_slices[block.name]
            if isinstance(block, Rotation):
                x_turned[part] = quat_multiply(x[part], quat_from_rotvec(rotvec))
            elif block.frame == "b":
                x_turned[part] = S.T @ x[part]
        for block in model.inputs:
            if block.frame == "b":
                u_turned[start : start + 3] = S.T @ u[start : start + 3]
            start += block.size
        w = np.zeros(self.noise_size)
        rate, turned = self._rate(x, u, w, p), self._rate(x_turned, u_turned, w, p)
        for block in model.state if self._rates_claimed() else ():
            rows = model.error_slices[block.name]
            expected = S.T @ rate[rows] if block is rotation or block.frame == "b" else rate[rows]
            self._keep("turned body", expected, turned[rows], np.ones(1), f"rate of {block.name}")
        for j, sensor in enumerate(model.sensors):
            if sensor.name in self.directions:
                known = self._known(j)
                expected, found = S.T @ numeric.measure(j, x, known), numeric.measure(j, x_turned, known)
                self._keep("turned body", expected, found, np.ones(1), f"direction of {sensor.name}")

    def _keep(self, what: str, claimed: Array, found: Array, columns: Array, part: str = "") -> None:
        """Keep the largest deviation, each row relative to its own size, columns weighed by the size of errors."""
        claimed, found = (m.reshape(len(m), -1) * columns for m in (claimed, found))
        if not claimed.size:
            return
        size = np.maximum(np.abs(claimed).max(axis=1), np.abs(found).max(axis=1))
        size = np.maximum(size, max(1e-6 * size.max(), 1e-12))
        deviation = float((np.abs(claimed - found).max(axis=1) / size).max())
        worst = self.worst.get(what, 0.0)
        self.worst[what] = worst if deviation <= worst or np.isnan(worst) else deviation
        if part and not deviation <= _CLAIM_LIMIT:
            text = (
                f"{part} changes with the choice of body axes: a frame='b' is missing or wrong, or a direction is none"
            )
            self.findings += [] if text in self.findings else [text]

    def _judge(self) -> None:
        for what, deviation in self.worst.items():
            limit = {"F": _STEP_LIMIT, "turned body": np.inf}.get(what, _JACOBIAN_LIMIT)
            if np.isnan(deviation):
                self.findings.append(f"{what} is not a finite number at some state")
            elif deviation > limit and what == "F":
                self.findings.append(f"F is off by {deviation:.2g}: a step of {self.dt:g} s is too long")
            elif deviation > limit:
                self.findings.append(f"{what} differs from finite differences by {deviation:.2g}")

    def _observability(self) -> tuple[int, tuple[str, ...]]:
        model, n = self.model, self.model.error_size
        x, u = model.nominal_state(), model.nominal_input()
        growth = (self.numeric.transition(x, u, self.dt)[0] - np.eye(n)) / self.dt  # powers span those of F
        rows = [
            self.numeric.jacobian(j, x, self._known(j)) / s.sd
            for j, s in enumerate(model.sensors)
            for _ in range(n if s.known else 1)  # what travels with readings differs from one to the next
        ]
        block = np.vstack([*rows, np.zeros((1, n))]) * self.scale
        growth = growth * self.scale / self.scale[:, None]
        blocks = []
        for _ in range(n):
            blocks.append(block / max(np.abs(block).max(), 1e-300))
            block = blocks[-1] @ growth
            if np.abs(block).max() < 1e-9:
                break
        stacked = np.vstack(blocks)
        if not np.isfinite(stacked).all():
            return 0, ()
        _, values, directions = np.linalg.svd(stacked)
        rank = int((values > 1e-7 * max(values[0], 1e-300)).sum())
        return rank, tuple(self._named(v) for v in _sparse(directions[rank:]))

    def _named(self, direction: Array) -> str:
        """Name an error direction by the axes it lies along."""
        parts = []
        for block in self.model.state:
            for i, value in enumerate(direction[self.model.error_slices[block.name]]):
                if abs(value) > 0.05 * np.abs(direction).max():
                    axis = "xyz"[i] if block.error_size == 3 else f"[{i}]"
                    parts.append(f"{block.name} {axis}" if block.error_size > 1 else block.name)
        return " with ".join(parts)

    def _c_form(self) -> None:
        from robustnav.model.codegen import model_header

        try:
            model_header(self.model)
        except _MISTAKES as why:
            self.findings.append(f"runs in NumPy only: {_words(why)}")


def _error_scale(model: Model) -> Array:
    parts = [np.broadcast_to(np.asarray(model.start_sd.get(b.name, 1.0), float), b.error_size) for b in model.state]
    scale = np.concatenate(parts)
    return np.where(scale > 0, scale, 1.0)


def _differences(function: Callable[[Array], Array], steps: Array) -> Array:
    """Return the derivative at zero by central differences, a column a step."""
    columns = [(function(e) - function(-e)) / (2 * h) for e, h in zip(np.diag(steps), steps, strict=True)]
    return np.array(columns).T if columns else np.zeros((len(function(steps)), 0))


def _sparse(rows: Array) -> Array:
    """Return a basis of the same space in reduced row echelon form, so that single axes show."""
    rows = rows.copy()
    for i in range(len(rows)):
        pivot = int(np.argmax(np.abs(rows[i])))
        rows[i] /= rows[i, pivot]
        for k in range(len(rows)):
            if k != i:
                rows[k] -= rows[k, pivot] * rows[i]
    return rows


def _words(why: BaseException) -> str:
    return str(why).replace("\n", ";") if isinstance(why, RobustnavError) else f"{type(why).__name__}: {why}"
