"""Error-state derivation: from a model's equations to Jacobians on unit quaternions x R^n.

The error moves the state by x [+] e: a vector block by addition, a quaternion by a small rotation in body axes
(q * (1, e/2)) or in navigation axes ((1, e/2) * q).  Derivation and checks: docs/models.md.
"""

from __future__ import annotations

from typing import Any

from robustnav.errors import InputError, MissingExtra
from robustnav.model.blocks import Equations, Model, Rotation, Symbols

Exprs = list[Any]
Rows = list[list[Any]]


def skew(v: Exprs) -> Rows:
    """Return the cross-product matrix of three expressions."""
    return [[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]]


def matrix(q: Exprs) -> Rows:
    """Return C_nb of a unit quaternion q_nb, as rows."""
    w, x, y, z = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def quat_product(a: Exprs, b: Exprs) -> Exprs:
    """Return the Hamilton product of two quaternions."""
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]


def product(a: Rows, b: Rows) -> Rows:
    """Return the matrix product of two row lists."""
    columns = list(zip(*b, strict=True))
    return [[sum(x * y for x, y in zip(row, column, strict=True)) for column in columns] for row in a]


def transpose(a: Rows) -> Rows:
    """Return the transposed row list."""
    return [list(column) for column in zip(*a, strict=True)]


class Derivation:
    """A model's symbols and equations in symengine, with its Jacobians on the error state.

    Raises
    ------
    MissingExtra : SymPy or symengine is not installed.
    InputError : a rate or a sensor has no equation, or one of the wrong size.
    """

    def __init__(self, model: Model) -> None:
        try:
            import symengine as se
            import sympy as sp
        except ModuleNotFoundError as why:
            raise MissingExtra(str(why.name), "model") from why
        self.model = model
        names = {
            "s": model.state,
            "u": model.inputs,
            "w": model.noises,
        }
        columns: dict[str, Exprs] = {}
        entries: dict[str, Any] = {}
        self.dt = se.Symbol("dt")
        for prefix, blocks in names.items():
            columns[prefix] = []
            for block in blocks:
                symbols = [sp.Symbol(f"{prefix}_{block.name}_{i}", real=True) for i in range(block.size)]
                entries[block.name] = sp.Matrix(symbols)
                columns[prefix] += [se.Symbol(str(s)) for s in symbols]
        for name in model.parameters:
            entries[name] = sp.Symbol(f"p_{name}", real=True)
        self.x, self.u, self.w = columns["s"], columns["u"], columns["w"]
        self.p = [se.Symbol(f"p_{name}") for name in model.parameters]
        self.known: dict[str, Exprs] = {}
        for sensor in model.sensors:
            self.known[sensor.name] = []
            for block in sensor.known:
                symbols = [sp.Symbol(f"k_{block.name}_{i}", real=True) for i in range(block.size)]
                entries[block.name] = sp.Matrix(symbols)
                self.known[sensor.name] += [se.Symbol(str(s)) for s in symbols]
        entries.setdefault("dt", sp.Symbol("dt", real=True))
        equations = model.equations(Symbols(entries))
        self._check_names(equations)
        self.rates, self.steps = self._motion(equations)
        self.directions = self._collect("direction", equations.directions, dict.fromkeys(equations.directions, 3))
        self.h = self._sensors(equations)

    def _check_names(self, equations: Equations) -> None:
        blocks, sensors = {b.name for b in self.model.state}, {s.name for s in self.model.sensors}
        spare = [
            *({*equations.rates, *equations.steps} - blocks),
            *({*equations.sensors, *equations.directions} - sensors),
        ]
        if spare:
            raise InputError(
                f"model {self.model.name!r}",
                got=f"an equation for {', '.join(map(repr, sorted(spare)))}",
                expected=f"names among {', '.join([*sorted(blocks), *sorted(sensors)])}",
            )

    def _motion(self, equations: Equations) -> tuple[dict[str, Exprs], dict[str, Exprs]]:
        """Return the rates, or the steps of a model in increments; the other is empty."""
        if not equations.steps:
            return self._collect("rate", equations.rates, {b.name: b.error_size for b in self.model.state}), {}
        if equations.rates:
            raise InputError(f"model {self.model.name!r}", got="rates and steps", expected="one of them")
        return {}, self._collect("step", equations.steps, {b.name: b.size for b in self.model.state})

    def _collect(self, what: str, given: Any, sizes: dict[str, int]) -> dict[str, Exprs]:
        moving = what in ("rate", "step")
        shared = {*self.x, *self.p, *([*self.u, *self.w] if moving else []), *([self.dt] if what == "step" else [])}
        out = {}
        for name, size in sizes.items():
            if name not in given:
                raise InputError(f"model {self.model.name!r}", got=f"no {what} for {name!r}", expected=f"a {what} each")
            values = [_without_tan(e) for e in (given[name] if hasattr(given[name], "__len__") else [given[name]])]
            place = f"{what} of {name!r} in model {self.model.name!r}"
            if len(values) != size:
                raise InputError(place, got=f"{len(values)} expressions", expected=f"{size}")
            own = set() if moving else {*self.known.get(name, [])}
            strange = sorted({str(s) for e in values for s in e.free_symbols - shared - own})
            if strange:
                allowed = "state, input, noise and parameters" if moving else "state, parameters and its known"
                raise InputError(place, got=f"the symbol {', '.join(strange)}", expected=f"only the model's {allowed}")
            out[name] = values
        return out

    def _sensors(self, equations: Equations) -> dict[str, Exprs]:
        sizes = {s.name: s.size for s in self.model.sensors if s.name not in self.directions}
        plain = self._collect("sensor equation", equations.sensors, sizes)
        out = {}
        for sensor in self.model.sensors:
            if sensor.name in plain:
                out[sensor.name] = plain[sensor.name]
            else:
                C_bn = transpose(matrix(self.quaternion(self.x)))
                out[sensor.name] = [row[0] for row in product(C_bn, [[v] for v in self.directions[sensor.name]])]
        return out

    def quaternion(self, x: Exprs) -> Exprs:
        """Return the four numbers of the attitude block in a state."""
        rotation = self.model.rotation
        if rotation is None:
            raise InputError(
                f"model {self.model.name!r}", got="no Rotation block", expected="one, for a direction sensor"
            )
        return x[self.model.state_slices[rotation.name]]

    def in_navigation(self, sensor: str) -> bool:
        """Whether a sensor is compared in navigation axes: a direction, with the attitude error kept there."""
        rotation = self.model.rotation
        return sensor in self.directions and rotation is not None and rotation.error == "n"

    def rows(self, sensor: str) -> list[int]:
        """Return which numbers of a reading tell of the state, by structure: the rows it is fused as."""
        H = skew(self.directions[sensor]) if self.in_navigation(sensor) else self.on_error(self.h[sensor])
        return [i for i, row in enumerate(H) if any(e != 0 for e in row)]

    def retraction(self, x: Exprs) -> Rows:
        """Return d(x [+] e)/de at e = 0, shape (nx, ne)."""
        import symengine as se

        out = [[se.Integer(0)] * self.model.error_size for _ in range(self.model.state_size)]
        for block in self.model.state:
            rows, columns = self.model.state_slices[block.name], self.model.error_slices[block.name]
            for i in range(block.size):
                part = _quaternion_rows(x[rows], block.error) if isinstance(block, Rotation) else None
                for j in range(block.error_size):
                    value = part[i][j] if part else se.Integer(int(i == j))
                    out[rows.start + i][columns.start + j] = value
        return out

    def on_error(self, expressions: Exprs) -> Rows:
        """Return the Jacobian of expressions of the state on the error, (m, ne)."""
        J = self.retraction(self.x)
        return product(jacobian(expressions, self.x), J)

    def error_rate(self) -> tuple[Rows, Rows]:
        """Return A (ne, ne) and G (ne, nw) of the error's rate e' = A e + G w at zero noise."""
        if self.steps:
            raise InputError(f"model {self.model.name!r}", got="steps", expected="rates, for a continuous-time design")
        A, G = [], []
        for block in self.model.state:
            rate = self.rates[block.name]
            a, g = self.on_error(rate), jacobian(rate, self.w)
            if isinstance(block, Rotation) and block.error == "n":
                C = matrix(self.quaternion(self.x))
                a, g = product(C, a), self._turned(C, g)
            elif isinstance(block, Rotation):
                start = self.model.error_slices[block.name].start
                for i, row in enumerate(skew(rate)):
                    for j in range(3):
                        a[i][start + j] = a[i][start + j] - row[j]
            A += a
            G += g
        zero = dict.fromkeys(self.w, 0)
        return [[e.subs(zero) for e in row] for row in A], [[e.subs(zero) for e in row] for row in G]

    @property
    def constant(self) -> bool:
        """Whether the error's rate depends on parameters only, as in chains of integrators."""
        if self.steps:
            return False
        varying = {*self.x, *self.u}
        return not any(varying & set(e.free_symbols) for part in self.error_rate() for row in part for e in row)

    def step_jacobians(self) -> tuple[Rows, Rows]:
        """Return F (ne, ne) and G (ne, nw) of a model in increments: how errors and noise pass through a step."""
        zero = dict.fromkeys(self.w, 0)
        F, G = [], []
        for block in self.model.state:
            after = self.steps[block.name]
            f, g = self.on_error(after), jacobian(after, self.w)
            if isinstance(block, Rotation):
                back = _error_rows([e.subs(zero) for e in after], block.error)
                f, g = product(back, f), product(back, g)
            F += [[e.subs(zero) for e in row] for row in f]
            G += [[e.subs(zero) for e in row] for row in g]
        return F, G

    def _turned(self, C: Rows, g: Rows) -> Rows:
        """Turn noise into navigation axes, except isotropic noise of the attitude alone: turning does not change it."""
        import symengine as se

        out = product(C, g)
        start = 0
        for noise in self.model.noises:
            columns = range(start, start + noise.size)
            start += noise.size
            own = [[row[j] for j in columns] for row in g]
            elsewhere = any(
                e.diff(self.w[j]) != 0
                for name, rate in self.rates.items()
                if self.model.rotation is None or name != self.model.rotation.name
                for e in rate
                for j in columns
            )
            scale = own[0][0]
            isotropic = noise.size == 3 and own == [
                [scale if i == j else se.Integer(0) for j in range(3)] for i in range(3)
            ]
            if isotropic and not elsewhere:
                for i in range(3):
                    for k, j in enumerate(columns):
                        out[i][j] = own[i][k]
        return out


def jacobian(expressions: Exprs, symbols: Exprs) -> Rows:
    """Return the derivative of expressions on symbols as rows.

    Raises
    ------
    InputError : an expression has no derivative in closed form, as the absolute value of a state.
    """
    out = [[e.diff(s) for s in symbols] for e in expressions]
    for e, row in zip(expressions, out, strict=True):
        if any("Derivative" in str(d) for d in row):
            raise InputError("no derivative", place=str(e)[:80], do="write abs(v) as sqrt(v**2 + small**2)")
    return out


def _error_rows(q: Exprs, error: str) -> Rows:
    """Return de/dq (3, 4) at a unit quaternion: the transposed retraction, times four."""
    return [[4 * e for e in row] for row in transpose(_quaternion_rows(q, error))]


def _quaternion_rows(q: Exprs, error: str) -> Rows:
    w, x, y, z = (component / 2 for component in q)
    if error == "n":
        return [[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]]
    return [[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]]


def _without_tan(expression: Any) -> Any:
    """Return an expression in symengine, tan as sin/cos: those are at hand, and tan is the costliest of the three."""
    import symengine as se
    import sympy as sp

    return se.sympify(sp.sympify(expression).replace(sp.tan, lambda angle: sp.sin(angle) / sp.cos(angle)))
