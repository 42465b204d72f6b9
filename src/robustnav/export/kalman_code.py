"""The steps of an extended Kalman filter as straight-line C, from the derivation that the kernel is generated from."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from robustnav.export.baked import baked
from robustnav.export.text import function, literal
from robustnav.filter.weighting import Gate, Huber, Rule, StudentT
from robustnav.model.blocks import Model, Rotation, Sensor
from robustnav.model.codegen import Generator, packed
from robustnav.model.derive import Exprs, Rows, quat_product
from robustnav.model.discretize import Step
from robustnav.model.program import Program

_INPUT_LIMIT = 1e6  # no input in SI units comes near: what is above, or not a number, is refused
_TEMPORARY = re.compile(r"\bt_(\d+)\b")


@dataclass(frozen=True)
class _Row:
    """One scalar row: residual, coefficients on the error, variance over the sensor's."""

    r: Any
    H: Exprs
    share: float


class _Folded(Program):
    """A program in which the entries of A get no names of their own: their factors then join those of F."""

    def let_matrix(self, name: str, rows: Sequence[Sequence[Any]]) -> Rows:
        """Name each entry of a matrix, but for A."""
        return [list(row) for row in rows] if name == "A" else super().let_matrix(name, rows)


class KalmanCode:
    """The C functions of one model's filter."""

    def __init__(self, name: str, model: Model) -> None:
        self.name, self.upper, self.model = name, name.upper(), baked(model)
        self.generator = Generator(self.model)
        self.n = self.model.error_size

    def predict(self) -> str:
        """Return the function that moves state and covariance by a step."""
        inputs = [f"({s} * {s})" for s in map(str, self.generator.derivation.u)]
        size = " + ".join([*inputs, "(dt * dt)"])
        check = [f"if (!(({size}) < R({_INPUT_LIMIT!r}))) return {self.upper}_REFUSED;"]
        noises = [f"const real q_{i} = {literal(v)};" for i, v in enumerate(self.model.intensities)]
        import symengine as se

        program = _Folded()
        step = Step(self.generator.derivation, program, se.Symbol("dt"))
        self._mean_attitude(step)
        body = program.statements(self.generator.predicted(step))
        head = self.head_of_predict()
        return function(head, self._reading([*check, *body], noises))

    def _mean_attitude(self, step: Step) -> None:
        """Take the attitude half-way as the mean of both ends: the same direction, shorter by the share phi^2 / 32."""
        rotation = self.model.rotation
        if rotation is not None:
            rows = self.model.state_slices[rotation.name]
            ends = zip(self.generator.derivation.x[rows], step.state[rows], strict=True)
            step.middle[rows] = step.program.let_all("mean", [(a + b) / 2 for a, b in ends])

    def head_of_predict(self) -> str:
        """Return its head."""
        given = [f"const real u[{self.model.input_size}]"] if self.model.input_size else []
        return f"int {self.name}_predict({self.name}_state *s, {', '.join(['real dt', *given])})"

    def head_of_update(self, sensor: Sensor) -> str:
        """Return the head of the function that fuses a sensor's reading."""
        return f"int {self.name}_update_{sensor.name}({self.name}_state *s, const real z[{sensor.width}])"

    def update(self, sensor: Sensor, rule: Rule) -> str:
        """Return the function that fuses a sensor's reading, weighed by a rule."""
        plain = rule == Gate()
        rows = self._rows(sensor, merge=plain)
        program, outputs = Program(), []
        names: list[list[str]] = []
        for i, row in enumerate(rows):
            outputs.append((f"const real r_{i}", row.r))
            names.append([])
            for j, e in enumerate(row.H):
                one = e.is_Number and float(e) == 1.0
                names[-1].append("" if e == 0 else "1" if one else f"H_{i}_{j}")
                if e != 0 and not one:
                    outputs.append((f"const real H_{i}_{j}", e))
        lines = program.statements(outputs)
        for i, row in enumerate(rows):
            lines += self._scalar(i, names[i], row.share * sensor.sd**2)
        last = len(rows)
        soft = "weight * " if isinstance(rule, Huber | StudentT) else ""
        lines += self._weighting(rule, last)
        lines += [f"const real e_{i} = {soft}dx{last}_{i};" for i in range(self.n)]
        lines += self._injected()
        for i in range(self.n):
            for j in range(i, self.n):
                old, new = f"P_{i}_{j}", f"P{last}_{i}_{j}"
                value = f"{old} + (weight * ({new} - {old}))" if soft else new
                lines.append(f"s->P[{packed(i, j, self.n)}] = {value};")
        return function(self.head_of_update(sensor), self._reading(lines, []))

    def _reading(self, lines: list[str], first: list[str]) -> list[str]:
        """Put what the lines need in front of them: every input is read before anything is stored."""
        text = "\n".join(lines)
        used = [s for s in self.generator.reads if re.search(rf"\b{s}\b", text)]
        used = [s for s in used if not re.search(rf"const real {s} =", text) and not s.startswith(("q_", "e_"))]
        places = {s: self.generator.reads[s] for s in used}
        reads = [f"const real {s} = {'s->' + p if p[0] in 'xP' else p};" for s, p in places.items()]
        stores = [re.sub(r"^x\[", "s->x[", re.sub(r"^P\[", "s->P[", line)) for line in lines]
        return [*reads, *first, *stores, f"return {self.upper}_OK;"]

    def _rows(self, sensor: Sensor, *, merge: bool) -> list[_Row]:
        import symengine as se

        r, H = self.generator.fused_rows(sensor)
        rows = []
        for value, coefficients in zip(r, H, strict=True):
            numbers = [float(e) if e.is_Number else None for e in coefficients]
            if any(v is None for v in numbers):
                rows.append(_Row(value, coefficients, 1.0))
                continue
            scale = max((v for v in numbers if v is not None), key=abs)
            unit = [se.Integer(int(bool(v))) if v in (0.0, scale) else se.sympify((v or 0.0) / scale) for v in numbers]
            rows.append(_Row(value / scale, unit, 1.0 / scale**2))
        return _merged(rows) if merge else rows

    def _scalar(self, i: int, H: list[str], variance: float) -> list[str]:
        """One row, from P<i> and dx<i> to P<i+1> and dx<i+1>; P0 is P, dx0 is nothing."""
        n = self.n
        columns = [j for j in range(n) if H[j]]

        def old(a: int, b: int) -> str:
            return f"P{i or ''}_{min(a, b)}_{max(a, b)}"

        def times(j: int, factor: str) -> str:
            return factor if H[j] == "1" else f"({H[j]} * {factor})"

        PH = " + ".join
        lines = [f"const real PH{i}_{k} = {PH(times(j, old(k, j)) for j in columns)};" for k in range(n)]
        seen = " + ".join(times(j, f"PH{i}_{j}") for j in columns)
        explained = "".join(f" - {times(j, f'dx{i}_{j}')}" for j in columns) if i else ""
        lines += [
            f"const real s_{i} = {literal(variance)} + {seen};",
            f"const real nu_{i} = r_{i}{explained};",
            f"const real inverse_{i} = R(1.0) / s_{i};",
            f"const real step_{i} = nu_{i} * inverse_{i};",
            f"if (!(s_{i} > {literal(0.999 * variance)})) return {self.upper}_REFUSED;",
            *(f"const real gain{i}_{a} = PH{i}_{a} * inverse_{i};" for a in range(n)),
        ]
        for a in range(n):
            before = f"dx{i}_{a} + " if i else ""
            lines.append(f"const real dx{i + 1}_{a} = {before}(PH{i}_{a} * step_{i});")
            rows = (f"const real P{i + 1}_{a}_{b} = {old(a, b)} - (gain{i}_{a} * PH{i}_{b});" for b in range(a, n))
            lines += rows
        return lines

    def _weighting(self, rule: Rule, rows: int) -> list[str]:
        """Refuse a reading without weight; Huber and Student-t give the others a weight."""
        lines = [f"const real nis = {' + '.join(f'(nu_{i} * step_{i})' for i in range(rows))};"]
        most = min(rule.limit, 1e12) if isinstance(rule, Gate) else 1e12
        lines.append(f"if (!(nis <= {literal(most)})) return {self.upper}_REFUSED;")
        if isinstance(rule, Huber):
            far, weight = rule.limit**2, f"{literal(rule.limit)} / rn_sqrt(nis)"
        elif isinstance(rule, StudentT):
            far, weight = float(rows), f"{literal(rule.limit + rows)} / ({literal(rule.limit)} + nis)"
        else:
            return lines
        return [*lines, f"const real weight = (nis > {literal(far)}) ? ({weight}) : R(1.0);"]

    def _injected(self) -> list[str]:
        import symengine as se

        program, outputs = Program(), []
        e = [se.Symbol(f"e_{i}") for i in range(self.n)]
        x = self.generator.derivation.x
        for block in self.model.state:
            rows, columns = self.model.state_slices[block.name], self.model.error_slices[block.name]
            if isinstance(block, Rotation):
                turn = [se.Integer(1), *(v / 2 for v in e[columns])]
                q = x[rows]
                moved = quat_product(turn, q) if block.error == "n" else quat_product(q, turn)
                moved = program.let_all("n", moved)
                scale = program.let("scale", se.Rational(3, 2) - sum(v * v for v in moved) / 2)
                values: Exprs = [v * scale for v in moved]
            else:
                values = [a + b for a, b in zip(x[rows], e[columns], strict=True)]
            outputs += [(f"x[{rows.start + k}]", v) for k, v in enumerate(values)]
        return [_TEMPORARY.sub(r"m_\1", line) for line in program.statements(outputs)]


def _merged(rows: list[_Row]) -> list[_Row]:
    """Join rows that see the same direction into the one row that says the same: weighted by their information."""
    out: list[_Row] = []
    for row in rows:
        same = next((k for k, other in enumerate(out) if other.H == row.H), None)
        if same is None or not all(e.is_Number for e in row.H):
            out.append(row)
            continue
        other = out[same]
        share = 1.0 / (1.0 / other.share + 1.0 / row.share)
        r = share / other.share * other.r + share / row.share * row.r
        out[same] = _Row(r, row.H, share)
    return out
