"""One time step of a model: mean, transition F and noise Q by the midpoint rule, as expressions.

The mean moves with the rate at the half-way state.  The Jacobian is taken there too: a velocity then sees the
mid-step attitude.  Rotations are composed, never added: a first-order I - [w]x dt would inflate the covariance by
(1 + |w dt|^2) each step.  Models without a rotation use the exact derivative of the midpoint map; where the error's
rate is constant the noise integral is taken to third order in dt, exact for chains of two integrators.  Derivation:
docs/models.md.
"""

from __future__ import annotations

from typing import Any

from robustnav.model.blocks import Rotation
from robustnav.model.derive import Derivation, Exprs, Rows, matrix, product, quat_product, skew, transpose
from robustnav.model.program import Program


class Step:
    """Expressions of one step of ``dt`` seconds, their intermediate results named in a Program."""

    def __init__(self, derivation: Derivation, program: Program, dt: Any) -> None:
        self.derivation, self.program, self.dt = derivation, program, dt
        self.model = derivation.model
        if derivation.steps:
            zero = dict.fromkeys(derivation.w, 0)
            given = [e.subs(zero) for b in self.model.state for e in derivation.steps[b.name]]
            self.state = self._normalized(program.let_all("m", given))
            return
        half = self._move(derivation.x, self._rates("r0", derivation.x), dt / 2, "half_")
        self.middle = program.let_all("m", half)
        self.rate = self._rates("r", self.middle)
        self.state = self._normalized(self._move(derivation.x, self.rate, dt, ""))

    def transition(self) -> tuple[Rows, Rows]:
        """Return F (ne, ne) and Q (ne, ne)."""
        import symengine as se

        if self.derivation.steps:
            F, G = self.derivation.step_jacobians()
            Q = [[self.dt * e for e in row] for row in self._noise(G)]
            return self.program.let_matrix("F", F), self.program.let_matrix("Q", Q)
        A, G = self.derivation.error_rate()
        at_middle = dict(zip(self.derivation.x, self.middle, strict=True))
        A_mid = self.program.let_matrix("A", [[e.subs(at_middle) for e in row] for row in A])
        G_mid = [[e.subs(at_middle) for e in row] for row in G]  # unnamed: roots of squares cancel in Q
        n, dt = self.model.error_size, self.dt
        one = [[se.Integer(int(i == j)) for j in range(n)] for i in range(n)]
        if self.model.rotation is not None:
            F = [[one[i][j] + A_mid[i][j] * dt for j in range(n)] for i in range(n)]
            if self.model.rotation.error == "b":
                self._compose_body_rotation(F, A_mid)
        else:
            A_0 = self.program.let_matrix("A0", A)
            half = [[one[i][j] + A_0[i][j] * dt / 2 for j in range(n)] for i in range(n)]
            F = [[one[i][j] + dt * e for j, e in enumerate(row)] for i, row in enumerate(product(A_mid, half))]
        Q = [[dt * e for e in row] for row in self._noise(G_mid)]
        if self.derivation.constant:
            AG = product(A_mid, G_mid)
            spread = [[g + dt / 2 * a for g, a in zip(*rows, strict=True)] for rows in zip(G_mid, AG, strict=True)]
            near, far = self._noise(spread), self._noise(AG)
            Q = [[dt * near[i][j] + dt**3 / 12 * far[i][j] for j in range(n)] for i in range(n)]
        return self.program.let_matrix("F", F), self.program.let_matrix("Q", Q)

    def covariance(self, P: Rows) -> Rows:
        """Return F P F' + Q, upper triangle only (lower entries are None)."""
        F, Q = self.transition()
        T = self.program.let_matrix("T", product(F, P))
        n = len(F)
        return [
            [sum(a * b for a, b in zip(T[i], F[j], strict=True)) + Q[i][j] if j >= i else None for j in range(n)]
            for i in range(n)
        ]

    def _rates(self, prefix: str, x: Exprs) -> dict[str, Exprs]:
        at = dict(zip(self.derivation.x, x, strict=True)) | dict.fromkeys(self.derivation.w, 0)
        return {
            b.name: self.program.let_all(f"{prefix}_{b.name}", [e.subs(at) for e in self.derivation.rates[b.name]])
            for b in self.model.state
        }

    def _move(self, x: Exprs, rate: dict[str, Exprs], dt: Any, prefix: str) -> Exprs:
        out: Exprs = []
        for block in self.model.state:
            part, r = x[self.model.state_slices[block.name]], rate[block.name]
            if isinstance(block, Rotation):
                out += quat_product(part, self._increment(r, dt, prefix))
            else:
                out += [e + v * dt for e, v in zip(part, r, strict=True)]
        return out

    def _normalized(self, x: Exprs) -> Exprs:
        """Scale the quaternion by one Newton step of 1/sqrt at one: no division, no square root."""
        rotation = self.model.rotation
        if rotation is None:
            return x
        at = self.model.state_slices[rotation.name]
        q = self.program.let_all("n", x[at])
        scale = self.program.let("newton", 1.5 - sum(e * e for e in q) / 2)
        return [*x[: at.start], *(e * scale for e in q), *x[at.stop :]]

    def _increment(self, rate: Exprs, dt: Any, prefix: str) -> Exprs:
        """Return the quaternion of a small turn; angle error theta^5/1920 at theta = |rate| dt."""
        phi = self.program.let_all(f"{prefix}phi", [r * dt for r in rate])
        square = self.program.let(f"{prefix}phi_square", sum(p * p for p in phi))
        # (cos, sin/theta) of half the angle to fourth and third order
        scale = self.program.let(f"{prefix}half_sinc", 0.5 - square / 48)
        return [1 - square / 8 + square * square / 384, *(p * scale for p in phi)]

    def _compose_body_rotation(self, F: Rows, A: Rows) -> None:
        """Replace the rows of a body-frame attitude error by the exact rotation over the step."""
        rotation = self.model.rotation
        rows = self.model.error_slices[rotation.name] if rotation else slice(0)
        rate = self.rate[rotation.name] if rotation else []
        turn = self.program.let_all("dq", self._increment(rate, self.dt, ""))
        own = transpose(matrix(turn))
        phi = [r * self.dt for r in rate]
        back = [[(1 if i == j else 0) - e / 2 for j, e in enumerate(row)] for i, row in enumerate(skew(phi))]
        for i in range(3):
            for j in range(len(F)):
                if rows.start <= j < rows.stop:
                    F[rows.start + i][j] = own[i][j - rows.start]
                else:
                    F[rows.start + i][j] = self.dt * sum(back[i][k] * A[rows.start + k][j] for k in range(3))

    def _noise(self, G: Rows) -> Rows:
        """Return G Qc G' for the intensities q of the noise blocks."""
        import symengine as se

        weights: Exprs = []
        for i, noise in enumerate(self.model.noises):
            weights += [se.Symbol(f"q_{i}")] * noise.size
        if not weights:
            return [[se.Integer(0)] * len(G) for _ in G]
        weighted = [[g * w for g, w in zip(row, weights, strict=True)] for row in G]
        return product(weighted, transpose(G))
