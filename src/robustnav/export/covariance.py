"""The extended Kalman filter of any model as straight-line C: one function to predict, one for each sensor.

The equations are those of the generated kernel with the model's numbers in place: terms that are zero vanish, rows of a
sensor that see the same direction are one row, a row with constant coefficients is scaled to a leading one.  Every
function reads all it needs, then decides, then stores: a refused reading leaves the state as it was.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from robustnav.engine.filters import FilterSetup
from robustnav.errors import InputError
from robustnav.export.baked import baked
from robustnav.export.text import comment, function, literal
from robustnav.export.unit import Block, Counted, Unit
from robustnav.filter.weighting import Gate, Huber, Rule, StudentT
from robustnav.frames import Array
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


class _Code:
    def __init__(self, name: str, model: Model) -> None:
        self.name, self.upper, self.model = name, name.upper(), baked(model)
        self.generator = Generator(self.model)
        self.n = self.model.error_size

    def predict(self) -> str:
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
        given = ["const real u[%d]" % self.model.input_size] if self.model.input_size else []
        return f"int {self.name}_predict({self.name}_state *s, {', '.join(['real dt', *given])})"

    def head_of_update(self, sensor: Sensor) -> str:
        return f"int {self.name}_update_{sensor.name}({self.name}_state *s, const real z[{sensor.width}])"

    def update(self, sensor: Sensor, rule: Rule) -> str:
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

        lines = []
        for k in range(n):
            lines.append(f"const real PH{i}_{k} = {' + '.join(times(j, old(k, j)) for j in columns)};")
        known = literal(variance)
        lines.append(f"const real s_{i} = {known} + {' + '.join(times(j, f'PH{i}_{j}') for j in columns)};")
        explained = " - ".join(["r_%d" % i, *(times(j, f"dx{i}_{j}") for j in columns)]) if i else "r_0"
        lines.append(f"const real nu_{i} = {explained};")
        lines.append(f"const real inverse_{i} = R(1.0) / s_{i};")
        lines.append(f"const real step_{i} = nu_{i} * inverse_{i};")
        bound = f"(s_{i} > {literal(0.999 * variance)})"
        lines.append(f"if (!{bound}) return {self.upper}_REFUSED;")
        for a in range(n):
            lines.append(f"const real gain{i}_{a} = PH{i}_{a} * inverse_{i};")
        for a in range(n):
            before = f"dx{i}_{a} + " if i else ""
            lines.append(f"const real dx{i + 1}_{a} = {before}(PH{i}_{a} * step_{i});")
        for a in range(n):
            for b in range(a, n):
                lines.append(f"const real P{i + 1}_{a}_{b} = {old(a, b)} - (gain{i}_{a} * PH{i}_{b});")
        return lines

    def _weighting(self, rule: Rule, rows: int) -> list[str]:
        nis = " + ".join(f"(nu_{i} * step_{i})" for i in range(rows))
        lines = [f"const real nis = {nis};"]
        if isinstance(rule, Gate):
            limit = literal(min(rule.limit, 1e12))
            return [*lines, f"if (!(nis <= {limit})) return {self.upper}_REFUSED;"]
        limit = literal(rule.limit)
        inside = limit if isinstance(rule, StudentT) else literal(rule.limit**2)
        inside = literal(-float(rows)) if isinstance(rule, StudentT) else inside
        if isinstance(rule, Huber):
            value = f"(nis > {inside}) ? ({limit} / rn_sqrt(nis)) : R(1.0)"
        else:
            value = f"(nis > R({float(rows)!r})) ? (({literal(rule.limit + rows)}) / ({limit} + nis)) : R(1.0)"
        lines += [f"if (!(nis < R(1e12))) return {self.upper}_REFUSED;", f"const real weight = {value};"]
        return lines

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


def kalman(name: str, real: str, model: Model, setup: FilterSetup) -> Unit:
    """Return the extended Kalman filter of a model.

    Raises
    ------
    MissingExtra : SymPy or symengine is not installed.
    InputError : the setup has no covariance.
    """
    if setup.P is None:
        raise InputError("export", got="a filter without a covariance", expected="an extended Kalman filter")
    code = _Code(name, model)
    updates = [code.update(s, rule) for s, rule in zip(model.sensors, setup.rules, strict=True)]
    heads = [code.head_of_predict(), *(code.head_of_update(s) for s in model.sensors)]
    first = 1 + model.input_size
    moved = f"{name}_predict(s, row[0]{', &row[1]' if model.input_size else ''})"
    step, fused = [f"if (row[0] > R(0.0)) refused |= {moved};"], []
    for j, sensor in enumerate(model.sensors):
        fused.append(f"{name}_update_{sensor.name}(s, &row[{first}])")
        step.append(f"if (((unsigned)present >> {j}u & 1u) != 0u) refused |= {fused[-1]};")
        first += sensor.width
    single = [Counted(f"update_{s.name}", (call,)) for s, call in zip(model.sensors, fused, strict=True)]
    title = f"Extended Kalman filter of the model {model.name!r}, covariance packed."
    return Unit(
        name=name,
        real=real,
        title=title,
        header=_header(code, title, model, real, heads),
        source="\n".join([f'#include "{name}.h"\n', _reset(code, setup.P), code.predict(), *updates]),
        heads=tuple(heads),
        kernel=("rn_real.h",),
        columns=_columns(model),
        step=tuple(step),
        counted=(Counted("update", (moved, *fused)), Counted("predict", (moved,)), *single),
        blocks=(Block("x", model.state_size, 2e-4),),
    )


def _columns(model: Model) -> tuple[str, ...]:
    inputs = [f"{b.name}_{i}" for b in model.inputs for i in range(b.size)]
    readings = []
    for s in model.sensors:
        readings += [f"{s.name}_{i}" for i in range(s.size)]
        readings += [f"{b.name}_{i}" for b in s.known for i in range(b.size)]
    return ("dt", *inputs, *readings)


def _header(code: _Code, title: str, model: Model, real: str, heads: list[str]) -> str:
    name, upper = code.name, code.upper
    about = comment(
        f"{title} SI units and radians; body axes forward, right, down, navigation axes north, east, down.  No allocation, "
        f"no globals; the caller owns the state.  Functions return {upper}_OK, or {upper}_REFUSED and leave the state as "
        "it was: an input that is not finite, a reading its rule gives no weight, a variance that lost its sign."
    )
    lines = [
        f"{model.state_slices[b.name].start}..{model.state_slices[b.name].stop - 1} {b.name} [{b.unit}]"
        for b in model.state
    ]
    numbers = code.n * (code.n + 1) // 2
    inputs = ", ".join(f"{b.name} [{b.unit}]" for b in model.inputs) or "none"
    says = [f"/* Move by dt [s], above 0; u: {inputs}. */\n{heads[0]};\n"]
    for sensor, head in zip(model.sensors, heads[1:], strict=True):
        known = "".join(f", then {b.name} [{b.unit}]" for b in sensor.known)
        says.append(f"/* Fuse z: {sensor.name} [{sensor.unit}]{known}. */\n{head};\n")
    float_type = "#ifndef RN_FLOAT\n#define RN_FLOAT\n#endif\n" if real == "float" else ""
    return (
        f'{about}#ifndef {upper}_H\n#define {upper}_H\n\n{float_type}#include "rn_real.h"\n\n'
        f"enum {{ {upper}_OK = 0, {upper}_REFUSED = 1 }};\n#define {upper}_SAVED {model.state_size + numbers}\n\n"
        f"typedef struct {{\n    real x[{model.state_size}]; /* {', '.join(lines)} */\n"
        f"    real P[{numbers}]; /* covariance of the error, upper triangle by rows; a rotation counts three */\n}} {name}_state;\n\n"
        f"/* Start at x with the covariance the filter was exported with. */\n"
        f"int {name}_reset({name}_state *s, const real x[{model.state_size}]);\n\n"
        + "\n".join(says)
        + f"\n/* The state as {upper}_SAVED plain numbers, to keep over a restart, and back; refused if not finite. */\n"
        f"void {name}_save(const {name}_state *s, real saved[{upper}_SAVED]);\n"
        f"int {name}_restore({name}_state *s, const real saved[{upper}_SAVED]);\n\n#endif\n"
    )


def _reset(code: _Code, P: Array) -> str:
    name, upper, n, nx = code.name, code.upper, code.n, code.model.state_size
    numbers = n * (n + 1) // 2
    start = ", ".join(literal(P[i, j]) for i in range(n) for j in range(i, n))
    finite = [
        f"for (int i = 0; i < {{}}; i++) {{{{\n        if (!((x[i] > R(-1e12)) && (x[i] < R(1e12)))) return {upper}_REFUSED;\n    }}}}"
    ]
    check = finite[0].format(nx).replace("{{", "{").replace("}}", "}")
    reset = [f"static const real start[{numbers}] = {{{start}}};", check]
    reset += [
        f"for (int i = 0; i < {nx}; i++) s->x[i] = x[i];",
        f"for (int i = 0; i < {numbers}; i++) s->P[i] = start[i];",
    ]
    both = [f"for (int i = 0; i < {nx}; i++) saved[i] = s->x[i];"]
    both += [f"for (int i = 0; i < {numbers}; i++) saved[{nx} + i] = s->P[i];"]
    again = [f"for (int i = 0; i < {upper}_SAVED; i++) {{"]
    again += [f"    if (!((saved[i] > R(-1e12)) && (saved[i] < R(1e12)))) return {upper}_REFUSED;", "}"]
    again += [f"for (int i = 0; i < {nx}; i++) s->x[i] = saved[i];"]
    again += [f"for (int i = 0; i < {numbers}; i++) s->P[i] = saved[{nx} + i];"]
    return "\n".join(
        [
            function(f"int {name}_reset({name}_state *s, const real x[{nx}])", [*reset, f"return {upper}_OK;"]),
            function(f"void {name}_save(const {name}_state *s, real saved[{upper}_SAVED])", both),
            function(
                f"int {name}_restore({name}_state *s, const real saved[{upper}_SAVED])", [*again, f"return {upper}_OK;"]
            ),
        ]
    )


__all__ = ["kalman"]
