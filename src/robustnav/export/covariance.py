"""The extended Kalman filter of any model as straight-line C: one function to predict, one for each sensor.

The equations are those of the generated kernel with the model's numbers in place: terms that are zero vanish, rows of a
sensor that see the same direction are one row, a row with constant coefficients is scaled to a leading one.  Every
function reads all it needs, then decides, then stores: a refused reading leaves the state as it was.
"""

from __future__ import annotations

from robustnav.engine.filters import FilterSetup
from robustnav.errors import InputError
from robustnav.export.kalman_code import KalmanCode
from robustnav.export.text import comment, function, literal
from robustnav.export.unit import Block, Counted, Unit
from robustnav.frames import Array
from robustnav.model.blocks import Model


def kalman(name: str, real: str, model: Model, setup: FilterSetup) -> Unit:
    """Return the extended Kalman filter of a model.

    Raises
    ------
    MissingExtra : SymPy or symengine is not installed.
    InputError : the setup has no covariance.
    """
    if setup.P is None:
        raise InputError("export", got="a filter without a covariance", expected="an extended Kalman filter")
    code = KalmanCode(name, model)
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


def _header(code: KalmanCode, title: str, model: Model, real: str, heads: list[str]) -> str:
    name, upper, n = code.name, code.upper, code.n
    about = comment(
        f"{title} SI units and radians; body axes forward, right, down, navigation axes north, east, down.  No "
        f"allocation, no globals; the caller owns the state.  Functions return {upper}_OK, or {upper}_REFUSED and "
        "leave the state as it was: an input that is not finite, a reading its rule gives no weight, a variance that "
        "lost its sign."
    )
    places = [(model.state_slices[b.name], b) for b in model.state]
    blocks = ", ".join(f"x[{part.start}..{part.stop - 1}] {b.name} [{b.unit}]" for part, b in places)
    numbers = n * (n + 1) // 2
    inputs = ", ".join(f"{b.name} [{b.unit}]" for b in model.inputs) or "none"
    says = [f"/* Move by dt [s], above 0; u: {inputs}. */\n{heads[0]};\n"]
    for sensor, head in zip(model.sensors, heads[1:], strict=True):
        known = "".join(f", then {b.name} [{b.unit}]" for b in sensor.known)
        says.append(f"/* Fuse z: {sensor.name} [{sensor.unit}]{known}. */\n{head};\n")
    float_type = "#ifndef RN_FLOAT\n#define RN_FLOAT\n#endif\n" if real == "float" else ""
    return (
        f'{about}#ifndef {upper}_H\n#define {upper}_H\n\n{float_type}#include "rn_real.h"\n\n'
        f"enum {{ {upper}_OK = 0, {upper}_REFUSED = 1 }};\n#define {upper}_SAVED {model.state_size + numbers}\n\n"
        f"{comment(blocks + '; P: covariance of the error, upper triangle by rows; a rotation counts three.')}"
        f"typedef struct {{\n    real x[{model.state_size}];\n    real P[{numbers}];\n}} {name}_state;\n\n"
        f"/* Start at x with the covariance the filter was exported with. */\n"
        f"int {name}_reset({name}_state *s, const real x[{model.state_size}]);\n\n"
        + "\n".join(says)
        + f"\n/* The state as {upper}_SAVED plain numbers, to keep, and back; refused unless finite. */\n"
        f"void {name}_save(const {name}_state *s, real saved[{upper}_SAVED]);\n"
        f"int {name}_restore({name}_state *s, const real saved[{upper}_SAVED]);\n\n#endif\n"
    )


def _reset(code: KalmanCode, P: Array) -> str:
    """Reset, save and restore."""
    name, upper, n, nx = code.name, code.upper, code.n, code.model.state_size
    numbers = n * (n + 1) // 2
    start = ", ".join(literal(P[i, j]) for i in range(n) for j in range(i, n))

    def each(size: int, statement: str) -> str:
        return f"for (int i = 0; i < {size}; i++) {statement}"

    def finite(value: str) -> str:
        return f"if (!(({value} > R(-1e12)) && ({value} < R(1e12)))) return {upper}_REFUSED;"

    reset = [
        f"static const real start[{numbers}] = {{{start}}};",
        each(nx, f"{{ {finite('x[i]')} }}"),
        each(nx, "s->x[i] = x[i];"),
        each(numbers, "s->P[i] = start[i];"),
        f"return {upper}_OK;",
    ]
    save = [each(nx, "saved[i] = s->x[i];"), each(numbers, f"saved[{nx} + i] = s->P[i];")]
    back = [
        each(nx + numbers, f"{{ {finite('saved[i]')} }}"),
        each(nx, "s->x[i] = saved[i];"),
        each(numbers, f"s->P[i] = saved[{nx} + i];"),
        f"return {upper}_OK;",
    ]
    state, kept = f"{name}_state *s", f"real saved[{upper}_SAVED]"
    return "\n".join(
        [
            function(f"int {name}_reset({state}, const real x[{nx}])", reset),
            function(f"void {name}_save(const {state}, {kept})", save),
            function(f"int {name}_restore({state}, const {kept})", back),
        ]
    )
