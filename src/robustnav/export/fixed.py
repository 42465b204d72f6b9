"""The nine-axis constant-gain filter in 32-bit integers as C, on raw sensor counts."""

from __future__ import annotations

import numpy as np

from robustnav.engine.filters import FilterSetup
from robustnav.export.budget import Budget
from robustnav.export.observer import ROWS, SENSORS, check_reference
from robustnav.export.scaling import CUT, WIDTH, Correcting, Counts, Scaling
from robustnav.export.schedule import Schedule
from robustnav.export.text import comment, function
from robustnav.export.unit import Block, Counted, Unit, functions_by_mask, switch
from robustnav.model.blocks import Model

_AXES = ("n", "e", "d")
_LONGEST = round(1.25 * 2**30)  # of a quaternion: one step at the end of the gyro's range makes it longer


def fixed_point(name: str, model: Model, setup: FilterSetup, rate_hz: float, counts: Counts) -> tuple[Unit, Scaling]:
    """Return the filter and its scaling.

    Raises
    ------
    InputError : a start-up schedule, or ranges and gains that 32 bits do not hold.
    """
    schedule = Schedule.of(setup, rate_hz)
    check_reference(schedule.gains, model)
    field = float(np.hypot(model.parameters["mag_north"], model.parameters["mag_down"]))
    scaling = Scaling.of(schedule, counts, 1.0 / rate_hz, field)
    errors = Budget.of(scaling, schedule.gains[0, -1], model)
    heads, bodies, says, calls = [], [], [], []
    for mask, suffix in functions_by_mask(SENSORS):
        present = [s for j, s in enumerate(SENSORS) if mask >> j & 1]
        given = ", ".join(f"const int16_t {s}[3]" for s in ["gyro", *present])
        heads.append(f"int {name}_{suffix}({name}_state *s, {given})")
        bodies.append(function(heads[-1], _body(name, scaling, mask, present)))
        readings = ", ".join(present) or "nothing else"
        says.append(
            comment(f"Move by {1.0 / rate_hz!r} s with gyro, then fuse {readings}; counts, body axes.")
            + heads[-1]
            + ";\n"
        )
        columns = [f"&row[{3 * (['gyro', *SENSORS].index(s))}]" for s in ["gyro", *present]]
        calls.append((mask, f"{name}_{suffix}(s, {', '.join(columns)})"))
    title = "Attitude and gyro bias from raw counts of gyro, accelerometer and magnetometer in 32-bit integers."
    unit = Unit(
        name=name,
        real="int32",
        title=title,
        header=_header(name, title, scaling, "\n".join(says)),
        source="\n".join([f'#include "{name}.h"\n#include "rn_fixed.h"\n', *bodies, _state_functions(name, scaling)]),
        heads=tuple(heads),
        kernel=("mcu/rn_fixed.h",),
        columns=tuple(f"{s}_{i}" for s in ("gyro", *SENSORS) for i in range(3)),
        step=switch(calls),
        counted=(Counted("update", (calls[0][1],)),),
        blocks=(
            Block("q", 4, errors.whole / 2, 2.0**-30),
            Block("bias", 3, 1e-3, 2.0**-scaling.bias * 2 / scaling.dt),
        ),
        notes=(_ranges(scaling), errors.said),
    )
    return unit, scaling


def _body(name: str, scaling: Scaling, mask: int, present: list[str]) -> list[str]:
    upper, keep = name.upper(), scaling.fine - scaling.coarse
    lines = ["int32_t a[3];", "int32_t h[3];", "int32_t q[4];"]
    checks = ["(rn_fixed_large(s->bias) != 0u)"]
    if "mag" in present:
        checks.append(f"(rn_fixed_wide(mag, {scaling.field_bits}) != 0u)")
    lines.append(f"if ({' || '.join(checks)}) return {upper}_REFUSED;")
    for i in range(3):
        lines.append(
            f"a[{i}] = s->wait[{i}] + (gyro[{i}] * {scaling.rate}) - (s->bias[{i}] >> {scaling.bias - scaling.fine});"
        )
        lines.append(f"h[{i}] = a[{i}] >> {keep};")
        lines.append(f"a[{i}] = (int32_t)((uint32_t)a[{i}] & {(1 << keep) - 1}u);")
    lines.append(f"rn_fixed_turn(s->q, h, {scaling.coarse}, q);")
    if not mask:
        return [*lines, *(f"s->wait[{i}] = a[{i}];" for i in range(3)), f"return {upper}_OK;"]
    part = scaling.sets[mask]
    lines += ["int32_t c[9];", "int32_t t[3];", "rn_fixed_matrix(q, c);"]
    order = sorted(part.rows, key=lambda r: (ROWS[r][1], ROWS[r][0]))
    for r in order:
        sensor, axis = ROWS[r]
        lines.append(
            f"const int32_t {sensor}_{_AXES[axis]} = rn_fixed_row(&c[{3 * axis}], {sensor}) >> {15 - WIDTH[sensor]};"
        )
    for i in (1, 0, 2):
        terms = [
            (int(g), f"{ROWS[r][0]}_{_AXES[ROWS[r][1]]}") for r, g in zip(part.rows, part.gains[i], strict=True) if g
        ]
        cut = (1 << (part.gains_down - 1)) + sum(g for g, _ in terms) // 2  # what rounding down took of every rho, too
        lines.append(f"t[{i}] = ({_products(terms)} + {cut}) >> {part.gains_down};")
    return [*lines, *_corrected(part, scaling), f"return {upper}_OK;"]


def _corrected(part: Correcting, scaling: Scaling) -> list[str]:
    """Turn the correction into body axes: it waits for the next step, and a share of it goes to the bias."""
    lines, vectors = [], {}
    for j in range(3):
        terms = [(int(w), f"t[{k}]") for k, w in enumerate(part.rest[j]) if w]
        if terms:
            vectors[j] = f"v_{_AXES[j]}"
            lines.append(f"const int32_t {vectors[j]} = rn_scaled({_products(terms)}, {part.rest_down});")
    wait, bias = part.turn + 15 - scaling.fine, part.bias_bits - scaling.bias
    for i in range(3):
        lines.append(f"const int32_t r_{i} = (c[{i}] * t[0]) + (c[{3 + i}] * t[1]) + (c[{6 + i}] * t[2]);")
        lines.append(f"s->wait[{i}] = a[{i}] + (r_{i} >> {wait});")
        others = "".join(f" + (c[{3 * j + i}] * {v})" for j, v in vectors.items())
        lines.append(f"s->bias[{i}] = s->bias[{i}] + ((({part.level}) * (r_{i} >> {CUT})){others} >> {bias});")
    return [
        line.replace(f" >> {bias});", f") >> {bias});").replace("+ (((", "+ ((((") if "s->bias" in line else line
        for line in lines
    ]


def _products(terms: list[tuple[int, str]]) -> str:
    return " + ".join(f"(({g}) * {factor})" if g < 0 else f"({g} * {factor})" for g, factor in terms) or "0"


def _ranges(scaling: Scaling) -> str:
    counts, unit = scaling.counts, scaling.resolution
    return (
        f"One count is {counts.gyro:.9g} rad/s, {counts.accel:.9g} m/s^2, {counts.mag:.9g} T; one update is "
        f"{scaling.dt:.9g} s. Attitude is in Q30, the bias as half a turn a step in Q{scaling.bias} "
        f"({unit['bias']:.1e} rad/s), good for {counts.bias:.3g} rad/s. Magnetometer readings of "
        f"{1 << (scaling.field_bits - 1)} counts or more on an axis are refused. A correction waits in `wait` until "
        "the next update turns the attitude by it."
    )


def _header(name: str, title: str, scaling: Scaling, declarations: str) -> str:
    upper, half = name.upper(), scaling.dt / 2
    about = comment(
        f"{title} Counts of rad/s, m/s^2 and T as below, body axes forward, right, down; at rest the "
        "accelerometer reads about (0, 0, -1 g).  No allocation, no globals, no library function; the caller owns the "
        f"state.  Functions return {upper}_OK, or {upper}_REFUSED and leave the state as it was."
    )
    return (
        f"{about}#ifndef {upper}_H\n#define {upper}_H\n\n#include <stdint.h>\n\n"
        f"enum {{ {upper}_OK = 0, {upper}_REFUSED = 1 }};\n#define {upper}_SAVED 10\n"
        f"#define {upper}_GYRO {scaling.counts.gyro!r}   /* rad/s a count */\n"
        f"#define {upper}_ACCEL {scaling.counts.accel!r}  /* m/s^2 a count */\n"
        f"#define {upper}_MAG {scaling.counts.mag!r}    /* T a count */\n"
        f"#define {upper}_ATTITUDE 9.313225746154785e-10 /* one unit of q: 2^-30 */\n"
        f"#define {upper}_BIAS {2.0**-scaling.bias / half!r} /* rad/s of one unit of bias */\n\n"
        "typedef struct {\n    int32_t q[4];    /* attitude, Hamilton, w first, body to magnetic NED, Q30 */\n"
        f"    int32_t bias[3]; /* gyro bias, body axes, half a turn a step in Q{scaling.bias} */\n"
        f"    int32_t wait[3]; /* half turns not yet made, Q{scaling.fine} */\n}} {name}_state;\n\n"
        f"/* Start at an attitude (Q30, unit) and a bias (units of {upper}_BIAS). */\n"
        f"int {name}_reset({name}_state *s, const int32_t q[4], const int32_t bias[3]);\n\n{declarations}\n"
        f"/* The state as {upper}_SAVED plain numbers, to keep over a restart, and back; refused if no state. */\n"
        f"void {name}_save(const {name}_state *s, int32_t saved[{upper}_SAVED]);\n"
        f"int {name}_restore({name}_state *s, const int32_t saved[{upper}_SAVED]);\n\n#endif\n"
    )


def _state_functions(name: str, scaling: Scaling) -> str:
    """Reset, save and restore; restore takes every state that updates can reach, reset a unit one."""
    upper = name.upper()
    reach = max(s.reach for s in scaling.sets.values())
    most = int(2.0 ** (scaling.fine - scaling.coarse) + reach * 2.0**scaling.fine) + 1
    waits = " || ".join(f"(saved[{k}] > {most}) || (saved[{k}] < -{most})" for k in (7, 8, 9))
    squares = " + ".join(f"(uint32_t)((q[{i}] >> 15) * (q[{i}] >> 15))" for i in range(4))
    inside = " || ".join(f"(q[{i}] > {_LONGEST}) || (q[{i}] < -{_LONGEST})" for i in range(4))
    fields = [f"q[{i}]" for i in range(4)] + [f"bias[{i}]" for i in range(3)]
    put = [
        f"if ({inside}) return {upper}_REFUSED;",
        f"const uint32_t squares = {squares};",
        f"if ((squares < least) || (squares > most) || (rn_fixed_large(bias) != 0u)) return {upper}_REFUSED;",
        *(f"s->{field} = {field};" for field in fields),
        *(f"s->wait[{i}] = 0;" for i in range(3)),
        f"return {upper}_OK;",
    ]
    save = [f"saved[{k}] = s->{field};" for k, field in enumerate(fields)]
    state, start = f"{name}_state *s", "const int32_t q[4], const int32_t bias[3]"
    unit = f"return put(s, q, bias, {round(0.99 * 2**30)}u, {round(1.01 * 2**30)}u);"
    wide = f"put(s, &saved[0], &saved[4], {round(0.5 * 2**30)}u, {round(1.5 * 2**30)}u)"
    back = [
        f"if ({waits}) return {upper}_REFUSED;",
        f"if ({wide} != {upper}_OK) return {upper}_REFUSED;",
        *(f"s->wait[{i}] = saved[{7 + i}];" for i in range(3)),
        f"return {upper}_OK;",
    ]
    return "\n".join(
        [
            function(f"static int put({state}, {start}, uint32_t least, uint32_t most)", put),
            function(f"int {name}_reset({state}, {start})", [unit]),
            function(
                f"void {name}_save(const {state}, int32_t saved[{upper}_SAVED])",
                [*save, *(f"saved[{7 + i}] = s->wait[{i}];" for i in range(3))],
            ),
            function(f"int {name}_restore({state}, const int32_t saved[{upper}_SAVED])", back),
        ]
    )
