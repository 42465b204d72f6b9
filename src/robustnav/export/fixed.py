"""The nine-axis constant-gain filter in 32-bit integers as C, on raw sensor counts."""

from __future__ import annotations

from math import sqrt

import numpy as np

from robustnav.engine.filters import FilterSetup
from robustnav.export.observer import ROWS, SENSORS, check_reference
from robustnav.export.scaling import CUT, WIDTH, Correcting, Counts, Scaling
from robustnav.export.schedule import Schedule
from robustnav.export.text import comment, function
from robustnav.export.unit import Block, Counted, Unit, functions_by_mask, switch
from robustnav.model.blocks import Model

_AXES = ("n", "e", "d")


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
    heads, bodies, says, calls = [], [], [], []
    for mask, suffix in functions_by_mask(SENSORS):
        present = [s for j, s in enumerate(SENSORS) if mask >> j & 1]
        given = ", ".join(f"const int16_t {s}[3]" for s in ["gyro", *present])
        heads.append(f"int {name}_{suffix}({name}_state *s, {given})")
        bodies.append(function(heads[-1], _body(name, scaling, mask, present)))
        readings = ", ".join(present) or "nothing else"
        says.append(comment(f"Move by {1.0 / rate_hz!r} s with gyro, then fuse {readings}; counts, body axes.") + heads[-1] + ";\n")
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
            Block("q", 4, budget(scaling), 2.0**-30),
            Block("bias", 3, 1e-3, 2.0**-scaling.bias * 2 / scaling.dt),
        ),
        notes=(_ranges(scaling),),
    )
    return unit, scaling


def budget(scaling: Scaling) -> float:
    """Return the largest difference from the double filter in a number of the quaternion, by its parts.

    Attitude cut to Q15 when it turns a reading (one unit), what waits for the next step (one coarse unit on three axes),
    rounded corrections at equilibrium (one unit over the gain's share of a correction), and gains rounded by 2^-8 of a
    correction of 2 degrees.
    """
    waiting = sqrt(3) * 2.0**-scaling.coarse
    rounding = max(2.0**-s.turn / max(s.reach, 1e-9) for s in scaling.sets.values())
    return 2.0 * (2.0**-15 * sqrt(3) + waiting + rounding + 0.5 * 0.035 * 2.0**-8)


def _body(name: str, scaling: Scaling, mask: int, present: list[str]) -> list[str]:
    upper, keep = name.upper(), scaling.fine - scaling.coarse
    lines = ["int32_t a[3];", "int32_t h[3];", "int32_t q[4];"]
    checks = ["(rn_fixed_large(s->bias) != 0u)"]
    if "mag" in present:
        checks.append(f"(rn_fixed_wide(mag, {scaling.field_bits}) != 0u)")
    lines.append(f"if ({' || '.join(checks)}) return {upper}_REFUSED;")
    for i in range(3):
        lines.append(f"a[{i}] = s->wait[{i}] + (gyro[{i}] * {scaling.rate}) - (s->bias[{i}] >> {scaling.bias - scaling.fine});")
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
        terms = [(int(g), f"{ROWS[r][0]}_{_AXES[ROWS[r][1]]}") for r, g in zip(part.rows, part.gains[i], strict=True) if g]
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
    return [line.replace(f" >> {bias});", f") >> {bias});").replace("+ (((", "+ ((((") if "s->bias" in line else line for line in lines]


def _products(terms: list[tuple[int, str]]) -> str:
    return " + ".join(f"(({g}) * {factor})" if g < 0 else f"({g} * {factor})" for g, factor in terms) or "0"


def _ranges(scaling: Scaling) -> str:
    counts, unit = scaling.counts, scaling.resolution
    return (
        f"One count is {counts.gyro:.9g} rad/s, {counts.accel:.9g} m/s^2, {counts.mag:.9g} T; one update is {scaling.dt:.9g} s. "
        f"Attitude is in Q30, the bias as half a turn a step in Q{scaling.bias} ({unit['bias']:.1e} rad/s), good for "
        f"{counts.bias:.3g} rad/s and refused beyond twice that; magnetometer readings of {1 << (scaling.field_bits - 1)} counts "
        "or more on an axis are refused. A correction waits in `wait` until the next update turns the attitude by it."
    )


def _header(name: str, title: str, scaling: Scaling, declarations: str) -> str:
    upper, half = name.upper(), scaling.dt / 2
    about = comment(
        f"{title} Counts of rad/s, m/s^2 and T as below, body axes forward, right, down; at rest the accelerometer reads about "
        f"(0, 0, -1 g).  No allocation, no globals, no library function; the caller owns the state.  Functions return "
        f"{upper}_OK, or {upper}_REFUSED and leave the state as it was."
    )
    return (
        f"{about}#ifndef {upper}_H\n#define {upper}_H\n\n#include <stdint.h>\n\n"
        f"enum {{ {upper}_OK = 0, {upper}_REFUSED = 1 }};\n#define {upper}_SAVED 10\n"
        f"#define {upper}_GYRO {scaling.counts.gyro!r}   /* rad/s a count */\n"
        f"#define {upper}_ACCEL {scaling.counts.accel!r}  /* m/s^2 a count */\n"
        f"#define {upper}_MAG {scaling.counts.mag!r}    /* T a count */\n"
        f"#define {upper}_ATTITUDE 9.313225746154785e-10 /* one unit of q: 2^-30 */\n"
        f"#define {upper}_BIAS {2.0**-scaling.bias / half!r} /* rad/s of one unit of bias */\n\n"
        "typedef struct {\n    int32_t q[4];    /* attitude, Hamilton, w first, body to magnetic north-east-down, Q30 */\n"
        f"    int32_t bias[3]; /* gyro bias, body axes, half a turn a step in Q{scaling.bias} */\n"
        f"    int32_t wait[3]; /* half turns not yet made, Q{scaling.fine} */\n}} {name}_state;\n\n"
        f"/* Start at an attitude (Q30, unit) and a bias (units of {upper}_BIAS). */\n"
        f"int {name}_reset({name}_state *s, const int32_t q[4], const int32_t bias[3]);\n\n{declarations}\n"
        f"/* The state as {upper}_SAVED plain numbers, to keep over a restart, and back; refused if no state. */\n"
        f"void {name}_save(const {name}_state *s, int32_t saved[{upper}_SAVED]);\n"
        f"int {name}_restore({name}_state *s, const int32_t saved[{upper}_SAVED]);\n\n#endif\n"
    )


def _state_functions(name: str, scaling: Scaling) -> str:
    upper = name.upper()
    most = int(2.0 ** (scaling.fine - scaling.coarse) + max(s.reach for s in scaling.sets.values()) * 2.0**scaling.fine) + 1
    waits = " || ".join(f"(saved[{k}] > {most}) || (saved[{k}] < -{most})" for k in (7, 8, 9))
    fields = [(f"q[{i}]", f"q[{i}]") for i in range(4)] + [(f"bias[{i}]", f"bias[{i}]") for i in range(3)]
    squares = " + ".join(f"(uint32_t)((q[{i}] >> 15) * (q[{i}] >> 15))" for i in range(4))
    inside = " || ".join(f"(q[{i}] > 1082130432) || (q[{i}] < -1082130432)" for i in range(4))
    reset = [
        f"if ({inside}) return {upper}_REFUSED;",
        f"const uint32_t squares = {squares};",
        f"if ((squares > 1084479242u) || (squares < 1063004406u)) return {upper}_REFUSED;",
        f"if (rn_fixed_large(bias) != 0u) return {upper}_REFUSED;",
        *(f"s->{a} = {b};" for a, b in fields),
        *(f"s->wait[{i}] = 0;" for i in range(3)),
        f"return {upper}_OK;",
    ]
    save = [f"saved[{k}] = s->{a};" for k, (a, _) in enumerate(fields)] + [f"saved[{7 + i}] = s->wait[{i}];" for i in range(3)]
    back = [
        f"if ({waits}) return {upper}_REFUSED;",
        f"if ({name}_reset(s, &saved[0], &saved[4]) != {upper}_OK) return {upper}_REFUSED;",
        *(f"s->wait[{i}] = saved[{7 + i}];" for i in range(3)),
        f"return {upper}_OK;",
    ]
    return "\n".join(
        [
            function(f"int {name}_reset({name}_state *s, const int32_t q[4], const int32_t bias[3])", reset),
            function(f"void {name}_save(const {name}_state *s, int32_t saved[{upper}_SAVED])", save),
            function(f"int {name}_restore({name}_state *s, const int32_t saved[{upper}_SAVED])", back),
        ]
    )
