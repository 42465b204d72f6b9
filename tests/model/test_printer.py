"""The printer: every node type in every position that once went wrong, compiled and held against 50 digits."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest
import symengine as se
import sympy as sp

from robustnav.engine import compile_model
from robustnav.engine.user import find_compiler
from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, NumericModel, Sensor, Vector
from robustnav.model.printer import constant, print_c
from robustnav.model.program import Program

CSRC = Path(__file__).parents[2] / "csrc"
x, y, z = sp.symbols("x y z", real=True)
EXPRESSIONS = {
    "power in a denominator": y / x**2,
    "power of a sum in a denominator": z / (x + y) ** 2,
    "product of sums in a denominator": x / ((x + y) * (y + z)),
    "nested quotient": x / (y / (z + x / (y + 1))),
    "quotient of quotients": (x / y) / (z / (x + 1)),
    "minus a quotient of sums": -(x - y) / (z - y - 1),
    "negative base": (-x) ** 3 * y,
    "negative sum squared": (-x - y) ** 2,
    "negative factor": x * (-2) * (y - z),
    "rational": sp.Rational(1, 3) * x - sp.Rational(22, 7) * y,
    "rational in a denominator": x / (sp.Rational(2, 3) * y),
    "root of a sum": sp.sqrt(x**2 + y**2 + z),
    "one over a root": x / sp.sqrt(x**2 + y**2),
    "root of a quotient": sp.sqrt(x / (y + z)),
    "root of a number": sp.sqrt(2) * x + 1 / sp.sqrt(3),
    "three halves": (x + y) ** sp.Rational(3, 2),
    "minus three halves": z * (x**2 + y) ** sp.Rational(-3, 2),
    "third and fourth powers": x**3 - y**4 + x**-3 / z**4,
    "difference of differences": x - (y - (z - 1)),
    "minus a sum": -(x + y) * -(y - z),
    "sum of a product of sums": 1 - (x - y) * (y - z),
    "atan2": sp.atan2(y - z, -x),
    "angles": sp.sin(x) * sp.cos(y) - sp.tan(z / 3) / sp.cos(x) ** 2,
    "inverse angles": sp.asin(x / 9) + sp.acos(y / 9) - sp.atan(z),
    "exponential": sp.exp(-x / 2) * sp.exp(y) - sp.exp(-5) + sp.E * z,
    "exponential in a denominator": x / (1 + sp.exp(-y)),
    "logarithm": sp.log(x + y) / sp.log(z),
    "absolute value": sp.Abs(x - y) - abs(z),
    "pi": sp.pi * x - y / sp.pi,
    "zero and integers": 2 + 0 * x - 3 * y,
}
POINTS = np.random.default_rng(0).uniform(0.5, 2.5, (5, 3))


@pytest.fixture(scope="module", params=["double", "float"])
def compiled(request, tmp_path_factory):
    """All expressions, each alone and each through a Program with shared temporaries, as one library."""
    folder, single = tmp_path_factory.mktemp("printer"), request.param == "float"
    head = "const real x = (real)v[0], y = (real)v[1], z = (real)v[2];"
    lines = ['#include "rn_real.h"', '#define KEEP __attribute__((visibility("default"))) double']
    for i, expression in enumerate(EXPRESSIONS.values()):
        text = print_c(se.sympify(expression))
        lines.append(f"KEEP plain_{i}(const double *v) {{ {head} RN_UNUSED(x); RN_UNUSED(y); RN_UNUSED(z);")
        lines.append(f"return (double)({text}); }}")
    everything = [(f"r[{i}]", e) for i, e in enumerate(EXPRESSIONS.values())]
    program = "\n".join(Program().statements(everything))
    lines.append(
        f"KEEP all(const double *v, int i) {{ {head} real r[{len(EXPRESSIONS)}]; {program} return (double)r[i]; }}"
    )
    (folder / "table.c").write_text("\n".join(lines))
    command = [
        *find_compiler(),
        "-std=c99",
        "-O2",
        "-Wall",
        "-Wdouble-promotion",
        "-Werror",
        "-shared",
        "-fPIC",
        f"-I{CSRC}",
    ]
    command += ["-DRN_FLOAT"] if single else []
    subprocess.run([*command, "-o", str(folder / "table.so"), str(folder / "table.c"), "-lm"], check=True)
    return ctypes.CDLL(str(folder / "table.so")), (3e-5 if single else 2e-14)


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_printed_expressions_agree_with_fifty_digits(compiled, name):
    library, tolerance = compiled
    i = list(EXPRESSIONS).index(name)
    plain = getattr(library, f"plain_{i}")
    plain.restype = library.all.restype = ctypes.c_double
    for point in POINTS:
        point = point.astype(np.float32).astype(float)
        values = {s: sp.Float(v, 50) for s, v in zip((x, y, z), point, strict=True)}
        exact = float(sp.sympify(EXPRESSIONS[name]).evalf(50, subs=values))
        pointer = point.ctypes.data_as(ctypes.c_void_p)
        assert plain(pointer) == pytest.approx(exact, rel=tolerance, abs=tolerance)
        assert library.all(pointer, i) == pytest.approx(exact, rel=tolerance, abs=tolerance)


@pytest.mark.parametrize(
    "expression",
    [x**5, x ** sp.Rational(1, 3), x**y, sp.Max(x, y), sp.sign(x), sp.I * x, 1e-40 * x, 1e39 + x, sp.oo * x],
)
def test_what_has_no_c_is_refused_by_name(expression):
    with pytest.raises(InputError) as caught:
        print_c(se.sympify(expression))
    assert any(part in str(caught.value) for part in ("x", "I", "1e-40", "1e+39", "inf"))


def test_a_refused_power_names_the_term():
    with pytest.raises(InputError, match=r"\(1 \+ x\)\*\*\(5\)"):
        print_c(se.sympify(3 * (x + 1) ** 5))


@pytest.mark.parametrize(("value", "text"), [(2, "R(2.0)"), (-0.5, "R(-0.5)"), (0, "R(0.0)"), (1e-5, "R(1e-05)")])
def test_constants_have_a_point_or_an_exponent(value, text):
    assert constant(value) == text


def test_names_that_mean_something_in_c_are_safe():
    """Blocks named like temporaries, kernel macros, packed entries, keywords and library functions."""
    names = ["x3", "P3", "R", "I", "step", "sin", "real", "t_0", "e", "P_0_0", "double", "F_0_0", "rn_wrap"]

    def equations(s):
        values = [getattr(s, n)[0] for n in names]
        rates = {
            n: (values[i - 1] * s.dt - values[i] * (1 + values[i - 2] ** 2) + s.x[0] + s.q_0[0],)
            for i, n in enumerate(names)
        }
        return Equations(rates=rates, sensors={"nu": (sum(values) ** 2, values[0] / (1 + values[1] ** 2))})

    model = Model(
        name="names",
        state=tuple(Vector(n, "1", 1) for n in names),
        inputs=(Vector("x", "1", 1),),
        noises=(Noise("q_0", "1", 0.3, 1),),
        sensors=(Sensor("nu", "1", 0.2, 2),),
        parameters={"dt": 0.7},
        equations=equations,
    )
    numeric, compiled = NumericModel(model), compile_model(model)
    rng = np.random.default_rng(1)
    state, u = rng.normal(size=len(names)), rng.normal(size=1)
    np.testing.assert_allclose(compiled.propagate(state, u, 0.1), numeric.propagate(state, u, 0.1), rtol=1e-13)
    for one, other in zip(compiled.transition(state, u, 0.1), numeric.transition(state, u, 0.1), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(compiled.measure(0, state), numeric.measure(0, state), rtol=1e-13)
    np.testing.assert_allclose(compiled.jacobian(0, state), numeric.jacobian(0, state), rtol=1e-12, atol=1e-15)


def test_inputs_are_read_before_the_first_output_is_stored():
    a, b = se.symbols("a b")
    program = Program()
    total = program.let("total", a + b)
    lines = program.statements([("v[0]", total * total), ("v[1]", a / total)])
    stores = [i for i, line in enumerate(lines) if line.startswith("v[")]
    assert stores == [len(lines) - 2, len(lines) - 1]
    assert lines[0] == "const real total = a + b;"
    with pytest.raises(KeyError, match="total"):
        program.let("total", a - b)
