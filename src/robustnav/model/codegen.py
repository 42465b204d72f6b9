"""The C header of a model: every function of ``csrc/rn_model.h``, derived and unrolled."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from robustnav.model.blocks import Model, Rotation, Sensor
from robustnav.model.derive import Derivation, Exprs, Rows, matrix, product, skew
from robustnav.model.discretize import Step
from robustnav.model.manifold import difference, moved, transport
from robustnav.model.pattern import errors_moved, errors_seen, gain_pattern
from robustnav.model.program import Program

Outputs = list[tuple[str, Any]]
MOTION, ERRORS = ("propagate", "predict", "transition", "noise"), ("inject", "inject_turned", "difference", "carry")


def packed(i: int, j: int, n: int) -> int:
    """Return where P[i, j] lies in the upper triangle stored by rows."""
    i, j = min(i, j), max(i, j)
    return i * (2 * n - i - 1) // 2 + j


def model_header(model: Model) -> str:
    """Return the generated C header of a model.

    Raises
    ------
    MissingExtra : SymPy or symengine is not installed.
    InputError : an expression has no C form, or the equations do not fit the blocks.
    """
    return Generator(model).header()


class Generator:
    """The functions of one model in C, each derived when it is asked for."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.derivation = Derivation(model)
        self.n = model.error_size
        self._pattern = gain_pattern(self.derivation, [self.fused_rows(s)[1] for s in model.sensors])
        self.reads = {
            **{str(s): f"x[{i}]" for i, s in enumerate(self.derivation.x)},
            **{str(s): f"u[{i}]" for i, s in enumerate(self.derivation.u)},
            **{str(s): f"p[{i}]" for i, s in enumerate(self.derivation.p)},
            **{f"q_{i}": f"q[{i}]" for i in range(len(model.noises))},
            **{f"P_{i}_{j}": f"P[{packed(i, j, self.n)}]" for i in range(self.n) for j in range(i, self.n)},
            **{f"e_{i}": f"e[{i}]" for i in range(self.n)},
            **{f"a_{i}": f"a[{i}]" for i in range(model.state_size)},
            **{f"b_{i}": f"b[{i}]" for i in range(model.state_size)},
            **{f"z_{i}": f"z[{i}]" for i in range(sum(s.width for s in model.sensors))},
            **{
                f"K_{i}": f"K[{i}]"
                for i in range(self.n * sum(len(self.derivation.rows(s.name)) for s in model.sensors))
            },
        }

    def header(self) -> str:
        """Put the whole file together."""
        guard = f"RN_GENERATED_{self.model.name.upper()}_H"
        parts = [
            f"/* Generated from the model {self.model.name!r}; do not edit: make generate. */\n"
            f"/* clang-format off */\n#ifndef {guard}\n#define {guard}\n"
            '#include "rn_model.h"\n#include "rn_update.h"\n\n' + self._describe(),
            self._propagate(),
            self._predict(),
            self._transition(),
            self._noise(),
            self._inject("inject", turned=False),
            self._inject("inject_turned", turned=True),
            self._difference(),
            self._carry(),
        ]
        for sensor in self.model.sensors:
            parts += [self._measure(sensor), self._residual(sensor), self._jacobian(sensor)]
            parts += [self._innovation(sensor), self._update(sensor)]
        parts += [self._gain(), self._correct(), self._table(), "#endif"]
        return "\n".join(parts) + "\n"

    def _describe(self) -> str:
        lines = ["/* state, error (quaternions: small rotation, rad), input, parameters:"]
        for block in self.model.state:
            x, e = self.model.state_slices[block.name], self.model.error_slices[block.name]
            kind = f", error in {block.error}" if isinstance(block, Rotation) else ""
            lines.append(
                f" *   x[{x.start}..{x.stop - 1}], e[{e.start}..{e.stop - 1}]  {block.name} [{block.unit}]{kind}"
            )
        start = 0
        for block in self.model.inputs:
            lines.append(f" *   u[{start}..{start + block.size - 1}]  {block.name} [{block.unit}]")
            start += block.size
        lines += [f" *   p[{i}]  {name}" for i, name in enumerate(self.model.parameters)]
        for sensor in self.model.sensors:
            lines.append(f" *   reading {sensor.name}: z[0..{sensor.size - 1}] [{sensor.unit}]")
            start = sensor.size
            for block in sensor.known:
                lines.append(f" *     z[{start}..{start + block.size - 1}]  {block.name} [{block.unit}]")
                start += block.size
        lines += [f" *   q[{i}]  intensity of {n.name} [({n.unit})^2]" for i, n in enumerate(self.model.noises)]
        return "\n".join(lines) + " */\n"

    def _function(self, name: str, signature: str, program: Program, outputs: Outputs, tail: Sequence[str] = ()) -> str:
        """One C function: inputs read first, outputs stored last, unused arguments named."""
        body = program.statements(outputs)
        text = "\n".join([*(line.split(" = ", 1)[1] for line in body), *tail])
        used = [s for s in self.reads if _names(s, text)]
        lines = [f"const real {s} = {self.reads[s]};" for s in used] + body + list(tail)
        kind = "real" if any(line.startswith("return") for line in tail) else "void"
        return self._whole(f"RN_INLINE {kind}", name, signature, lines)

    def _whole(self, kind: str, name: str, signature: str, lines: list[str]) -> str:
        text, arguments = "\n".join(lines), re.findall(r"(\w+)(?:,|$)", signature)
        unused = [f"RN_UNUSED({a});" for a in arguments if not _names(a, text)]
        head = f"{kind} rn_{self.model.name}_{name}({signature})\n{{\n"
        return head + "".join(f"    {line}\n" for line in [*unused, *lines]) + "}\n"

    def _step(self) -> tuple[Program, Step]:
        import symengine as se

        program = Program()
        return program, Step(self.derivation, program, se.Symbol("dt"))

    def _propagate(self) -> str:
        program, step = self._step()
        outputs = [(f"x[{i}]", e) for i, e in enumerate(step.state)]
        return self._function("propagate", "real *x, const real *u, const real *p, real dt", program, outputs)

    def _predict(self) -> str:
        program, step = self._step()
        signature = "real *x, real *P, const real *u, const real *q, const real *p, real dt"
        return self._function("predict", signature, program, self.predicted(step))

    def predicted(self, step: Step) -> Outputs:
        """Return what a step assigns to the state ``x[i]`` and to its packed covariance ``P[k]``."""
        import symengine as se

        P = [[se.Symbol(f"P_{min(i, j)}_{max(i, j)}") for j in range(self.n)] for i in range(self.n)]
        new = step.covariance(P)
        outputs = [(f"x[{i}]", e) for i, e in enumerate(step.state)]
        return outputs + [(f"P[{packed(i, j, self.n)}]", new[i][j]) for i in range(self.n) for j in range(i, self.n)]

    def _transition(self) -> str:
        program, step = self._step()
        F, Q = step.transition()
        outputs = _store("F", F) + _store("Q", Q)
        signature = "const real *x, const real *u, const real *q, const real *p, real dt, real *F, real *Q"
        return self._function("transition", signature, program, outputs)

    def _noise(self) -> str:
        program, step = self._step()
        _, Q = step.transition()
        outputs = [(f"Q[{packed(i, j, self.n)}]", Q[i][j]) for i in range(self.n) for j in range(i, self.n)]
        signature = "const real *x, const real *u, const real *q, const real *p, real dt, real *Q"
        return self._function("noise", signature, program, outputs)

    def _inject(self, name: str, *, turned: bool) -> str:
        import symengine as se

        program = Program()
        error = [se.Symbol(f"e_{i}") for i in range(self.n)]
        x = moved(self.derivation, program, self.derivation.x, error, turned=turned)
        return self._function(name, "real *x, const real *e", program, _store("x", [x]))

    def _difference(self) -> str:
        a, b = self._states("a"), self._states("b")
        program = Program()
        outputs = _store("e", [difference(self.derivation, program, a, b)])
        return self._function("difference", "const real *a, const real *b, real *e", program, outputs)

    def _states(self, name: str) -> Exprs:
        import symengine as se

        return [se.Symbol(f"{name}_{i}") for i in range(self.model.state_size)]

    def _carry(self) -> str:
        """Points x [+] e through a step and back to errors in one loop over them, for compilers to vectorise."""
        import symengine as se

        program, points = Program(), 2 * self.n
        error = [se.Symbol(f"e_{i}") for i in range(self.n)]
        start = moved(self.derivation, program, self._states("a"), error)
        for symbol, value in zip(self.derivation.x, start, strict=True):
            program.let(str(symbol), value)  # what Step starts from
        stepped = Step(self.derivation, program, se.Symbol("dt")).state
        apart = difference(self.derivation, program, stepped, self._states("b"))
        column = {f"e_{i}": f"e[{i * points} + k]" for i in range(self.n)}
        changed = errors_moved(self.model, self.derivation.x, stepped)
        body = program.statements([(column[f"e_{i}"], apart[i]) for i in range(changed)])
        text = "\n".join(line.split(" = ", 1)[1] for line in body)
        used = [s for s in {**self.reads, **column} if s not in map(str, self.derivation.x) and _names(s, text)]
        lines = [f"const real {s} = {self.reads[s]};" for s in used if s not in column]
        inside = [f"const real {s} = {column[s]};" for s in used if s in column] + body
        lines += [f"for (int k = 0; k < {points}; k++) {{", *(f"    {line}" for line in inside), "}"]
        signature = "const real *a, const real *b, const real *u, const real *p, real dt, real *e"
        return self._whole("RN_VECTORISED static void", "carry", signature, lines)

    def fused_rows(self, sensor: Sensor, first: int = 0) -> tuple[Exprs, Rows]:
        """Return the residual rows a sensor is fused as and their Jacobian, for a reading that starts at z[first]."""
        import symengine as se

        z = [se.Symbol(f"z_{first + i}") for i in range(sensor.size)]
        if self.derivation.in_navigation(sensor.name):
            v = self.derivation.directions[sensor.name]
            C = matrix(self.derivation.quaternion(self.derivation.x))
            r = [e[0] - w for e, w in zip(product(C, [[e] for e in z]), v, strict=True)]
            H = [[se.Integer(0)] * self.n for _ in range(3)]
            rotation = self.model.rotation
            start = self.model.error_slices[rotation.name].start if rotation else 0
            for i, row in enumerate(skew(v)):
                H[i][start : start + 3] = [se.sympify(e) for e in row]
        else:
            h = self.derivation.h[sensor.name]
            r, H = [a - b for a, b in zip(z, h, strict=True)], self.derivation.on_error(h)
            if sensor.wraps:
                r = [se.Function("rn_wrap")(e) for e in r]
        keep = self.derivation.rows(sensor.name)
        at = self._travelling(sensor, first)
        return [r[i].subs(at) for i in keep], [[se.sympify(e).subs(at) for e in H[i]] for i in keep]

    def _travelling(self, sensor: Sensor, first: int = 0) -> dict[Any, Any]:
        """Return where what travels with a reading stands behind its numbers."""
        import symengine as se

        start = first + sensor.size
        return {s: se.Symbol(f"z_{start + i}") for i, s in enumerate(self.derivation.known[sensor.name])}

    def _measure(self, sensor: Sensor) -> str:
        at = self._travelling(sensor)
        outputs = [(f"h[{i}]", e.subs(at)) for i, e in enumerate(self.derivation.h[sensor.name])]
        signature = "const real *x, const real *z, const real *p, real *h"
        return self._function(f"measure_{sensor.name}", signature, Program(), outputs)

    def _residual(self, sensor: Sensor) -> str:
        r, _ = self.fused_rows(sensor)
        outputs = [(f"r[{i}]", e) for i, e in enumerate(r)]
        signature = "const real *x, const real *z, const real *p, real *r"
        return self._function(f"residual_{sensor.name}", signature, Program(), outputs)

    def _jacobian(self, sensor: Sensor) -> str:
        _, H = self.fused_rows(sensor)
        signature = "const real *x, const real *z, const real *p, real *H"
        return self._function(f"jacobian_{sensor.name}", signature, Program(), _store("H", H))

    def _innovation(self, sensor: Sensor) -> str:
        import symengine as se

        at = self._travelling(sensor)
        r = [se.Symbol(f"z_{i}") - e.subs(at) for i, e in enumerate(self.derivation.h[sensor.name])]
        if sensor.wraps:
            r = [se.Function("rn_wrap")(e) for e in r]
        signature = "const real *x, const real *z, const real *p, real *r"
        return self._function(f"innovation_{sensor.name}", signature, Program(), _store("r", [r]))

    def _update(self, sensor: Sensor) -> str:
        r, H = self.fused_rows(sensor)
        n, program = self.n, Program()
        outputs: Outputs = [(f"const real r_{i}", e) for i, e in enumerate(r)]
        names: list[list[str]] = []
        for i, row in enumerate(H):
            names.append([f"H_{i}_{j}" if e != 0 else "" for j, e in enumerate(row)])
            outputs += [(f"const real H_{i}_{j}", e) for j, e in enumerate(row) if e != 0]
        packed_size = n * (n + 1) // 2
        tail = [
            f"real L[{packed_size}], dx[{n}];",
            "int refused = 0;",
            "memcpy(L, P, sizeof L);",
            f"for (int i = 0; i < {n}; i++) dx[i] = R(0.0);",
            "*nis = R(0.0);",
        ]
        for i, row_names in enumerate(names):
            columns = [j for j in range(n) if row_names[j]]
            tail += _scalar_row(i, columns, n)
        tail += [
            f"const real weight = refused ? R(0.0) : rn_weight(rule, *nis, R({len(r)}.0));",
            "if (!(weight > R(0.0))) return R(0.0);",
            f"if (weight < R(1.0)) rn_soften(L, P, {packed_size}, dx, {n}, weight);",
            "memcpy(P, L, sizeof L);",
            *transport(self.model),
            f"rn_{self.model.name}_inject(x, dx);",
            "return weight;",
        ]
        given = "real *x, real *P, const real *z, real variance, RN(rule) rule, const real *p"
        return self._function(f"update_{sensor.name}", f"{given}, real *nu, real *s, real *nis", program, outputs, tail)

    def _gain(self) -> str:
        lines = []
        for i, pattern in enumerate(self._pattern):
            terms = [f"K[{i * len(pattern) + j}] * r[{j}]" for j in range(len(pattern)) if pattern[j]]
            lines.append(f"e[{i}] = {' + '.join(terms) or 'R(0.0)'};")
        return self._function("gain", "const real *K, const real *r, real *e", Program(), [], lines)

    def _correct(self) -> str:
        """Residuals of all sensors, gain and correction in one: the constant-gain filter when nothing is missing."""
        import symengine as se

        program, residuals, first = Program(), [], 0
        for sensor in self.model.sensors:
            residuals += self.fused_rows(sensor, first)[0]
            first += sensor.width
        r = program.let_all("r", residuals)
        error = [
            program.let(f"de_{i}", sum(se.Symbol(f"K_{i * len(r) + j}") * v for j, v in enumerate(r) if pattern[j]))
            for i, pattern in enumerate(self._pattern)
        ]
        x = moved(self.derivation, program, self.derivation.x, error, turned=True)
        outputs = _store("x", [x]) + _store("r", [r])
        return self._function(
            "correct", "real *x, const real *z, const real *K, const real *p, real *r", program, outputs
        )

    def _table(self) -> str:
        m, name = self.model, self.model.name
        own = ("measure", "residual", "jacobian", "innovation", "update")
        sensors = ",\n".join(
            f'    {{"{s.name}", {s.size}, {s.width}, '
            f"{len(self.fused_rows(s)[0])}, {errors_seen(self.derivation, s.name)}, "
            f"{', '.join(f'rn_{name}_{function}_{s.name}' for function in own)}}}"
            for s in m.sensors
        )
        moving = errors_moved(m, self.derivation.x, self._step()[1].state)
        sizes = (m.state_size, self.n, m.input_size, len(m.noises), len(m.parameters), len(m.sensors), moving)
        return (
            f"static const RN(sensor) rn_{name}_sensors[] = {{\n{sensors}}};\n"
            f"static const RN(model) rn_{name}_model = {{\n"
            f'    RN_ABI, (int)sizeof(real), "{name}", {", ".join(map(str, sizes))}, rn_{name}_sensors,\n'
            f"    {', '.join(f'rn_{name}_{f}' for f in (*MOTION, *ERRORS, 'gain', 'correct'))}}};\n"
        )


def _store(name: str, rows: Rows) -> Outputs:
    return [(f"{name}[{i * len(row) + j}]", e) for i, row in enumerate(rows) for j, e in enumerate(row)]


def _names(symbol: str, text: str) -> bool:
    return re.search(rf"\b{symbol}\b", text) is not None


def _scalar_row(i: int, columns: list[int], n: int) -> list[str]:
    """The sequential update of one row: PH over its non-zero columns only, then the shared rank-one step."""
    lines = ["{"]
    terms = [" + ".join(f"H_{i}_{c} * L[{packed(k, c, n)}]" for c in columns) for k in range(n)]
    lines.append(f"    const real PH[{n}] = {{{', '.join(terms)}}};")
    lines.append(f"    s[{i}] = variance + {' + '.join(f'H_{i}_{c} * PH[{c}]' for c in columns)};")
    lines.append(f"    nu[{i}] = r_{i} - ({' + '.join(f'H_{i}_{c} * dx[{c}]' for c in columns)});")
    lines.append(f"    refused += rn_scalar_update(L, dx, PH, {n}, s[{i}], variance, nu[{i}], nis);")
    return [*lines, "}"]
