"""The nine-axis constant-gain attitude filter as C.

Against the gain matrix this saves three things, all exact.  The magnetometer's reference drops out, because the gain
cannot tell the length of the field.  The bias part of a Kalman gain is a small matrix times its attitude part,
P_bt P_tt^-1.  And half the rotation matrix needs no doubling: the twos are in the gains.  docs/firmware.md, section 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.engine.filters import FilterSetup
from robustnav.errors import InputError
from robustnav.export.schedule import Schedule
from robustnav.export.text import Api, comment, function, header_text, state_functions, table
from robustnav.export.unit import Block, Counted, Unit, functions_by_mask, switch
from robustnav.frames import Array
from robustnav.model.blocks import Model

SENSORS = ("accel", "mag")
ROWS = (("accel", 0), ("accel", 1), ("mag", 0), ("mag", 1), ("mag", 2))
_AXES = ("n", "e", "d")
INCLUDES = '#include "{}.h"\n#include "rn_steps.h"\n'
_ZERO = 1e-9  # relative size below which a gain is none: what rounding leaves of a structural zero
HALF_TURN = [
    "const real half = R(0.5) * dt;",
    "real h[3];",
    "h[0] = (gyro[0] - s->gyro_bias[0]) * half;",
    "h[1] = (gyro[1] - s->gyro_bias[1]) * half;",
    "h[2] = (gyro[2] - s->gyro_bias[2]) * half;",
]
STATE = (
    ("q_nb", 4, "attitude, Hamilton, w first, body to magnetic north-east-down"),
    ("gyro_bias", 3, "in body axes [rad/s]"),
)
BLOCKS = (Block("q_nb", 4, 1e-4), Block("gyro_bias", 3, 1e-4))

Sums = tuple[tuple[tuple[int, str], ...], ...]  # by result, pairs of a gain's position and its factor


def split_gain(K: Array) -> tuple[Array, Array]:
    """Return attitude gain (3, rows) and the matrix M (3, 3) with which the bias gain is M times it.

    Raises
    ------
    InputError : the bias part is no such product, so the gain is not a Kalman gain.
    """
    attitude, bias = K[:3], K[3:]
    M = np.asarray(np.linalg.lstsq(attitude.T, bias.T, rcond=None)[0].T, float)
    if not np.abs(M @ attitude - bias).max() <= 1e-6 * np.abs(bias).max():
        raise InputError("constant gain", got="a bias part that no attitude part gives", expected="a Kalman gain")
    M[np.abs(M) < _ZERO * np.abs(M).max()] = 0.0
    return np.where(np.abs(attitude) < _ZERO * np.abs(attitude).max(axis=0), 0.0, attitude), M


def check_reference(gains: Array, model: Model) -> None:
    """Refuse gains (..., 6, 5) that see the length of the reference field: the C leaves the reference out."""
    north, down = model.parameters["mag_north"], model.parameters["mag_down"]
    used = gains[..., :3, 2] * north + gains[..., :3, 4] * down
    if not np.abs(used).max() <= 1e-6 * np.abs(gains[..., :3, 2:]).max() * np.hypot(north, down):
        raise InputError("constant gain", got="weight on the field's length", expected="a gain of this model's field")


@dataclass(frozen=True)
class Terms:
    """One subset's gain as sums of products: ``values`` (sets, n), t = K_theta rho and b = 4 M t, rho = C_nb z / 2."""

    values: Array
    turn: Sums
    bias: Sums

    @classmethod
    def of(cls, gains: Array, rows: list[int]) -> Terms:
        """Return the sums of gains (sets, 6, 5) over some rows; equal numbers are kept once."""
        split = [split_gain(K[:, rows]) for K in gains]
        values: list[Array] = []

        def sums(matrix: Array, factors: list[str]) -> Sums:
            out = []
            for i in range(3):
                used = [j for j in range(len(factors)) if matrix[:, i, j].any()]
                out.append(tuple((_position(values, matrix[:, i, j]), factors[j]) for j in used))
            return tuple(out)

        turn = sums(np.array([a for a, _ in split]), [f"{ROWS[r][0]}_{_AXES[ROWS[r][1]]}" for r in rows])
        bias = sums(4.0 * np.array([m for _, m in split]), [f"t[{i}]" for i in range(3)])
        return cls(np.array(values).T, turn, bias)


def _position(values: list[Array], wanted: Array) -> int:
    for i, known in enumerate(values):
        if np.allclose(known, wanted, rtol=1e-9, atol=0.0):
            return i
    values.append(wanted)
    return len(values) - 1


def nine_axes(name: str, real: str, model: Model, setup: FilterSetup, rate_hz: float) -> Unit:
    """Return the filter: state q_nb and gyro bias, one function for each set of sensors."""
    schedule = Schedule.of(setup, rate_hz)
    check_reference(schedule.gains, model)
    title = "Attitude and gyro bias from gyro, accelerometer and magnetometer by a constant H2-optimal gain."
    api = Api(name, real, title, STATE, rate_hz if schedule.staged else 0.0, 4)
    source, calls, heads = [], [], []
    declarations: list[str] = []
    for mask, suffix in functions_by_mask(SENSORS):
        present = [s for j, s in enumerate(SENSORS) if mask >> j & 1]
        given = ["real dt", "const real gyro[3]", *(f"const real {s}[3]" for s in present)]
        head = f"int {name}_{suffix}({name}_state *s, {', '.join(given)})"
        heads.append(head)
        declarations.append(says(present) + head + ";\n")
        gains, body = _body(name, suffix, schedule, mask)
        source += [gains, function(head, body)] if gains else [function(head, body)]
        columns = ["row[0]", "&row[1]", *(f"&row[{4 + 3 * SENSORS.index(s)}]" for s in present)]
        calls.append((mask, f"{name}_{suffix}(s, {', '.join(columns)})"))
    return Unit(
        name=name,
        real=real,
        title=title,
        header=header_text(api, "\n".join(declarations)),
        source="\n".join([INCLUDES.format(name), *filter(None, [schedule.code(name)]), *source, state_functions(api)]),
        kernel=("rn_real.h", "mcu/rn_steps.h"),
        columns=("dt", *(f"{s}_{i}" for s in ("gyro", *SENSORS) for i in range(3))),
        heads=tuple(heads),
        step=switch(calls),
        counted=(Counted("update", (calls[0][1],)),),
        blocks=BLOCKS,
    )


def says(present: list[str]) -> str:
    """Return the comment on a function for some sensors."""
    units = {"accel": "accel: specific force [m/s^2]", "mag": "mag: field [T]"}
    readings = ", ".join(units[s] for s in present)
    text = "Move by dt [s], above 0, with gyro [rad/s], body axes"
    return comment(f"{text}{', then fuse ' + readings if present else ' alone'}.")


def _body(name: str, suffix: str, schedule: Schedule, mask: int) -> tuple[str, list[str]]:
    upper = name.upper()
    lines = [*HALF_TURN, "real q[4];"]
    if not mask:
        turn = ["if (!(rn_turn_body(s->q_nb, h, q) > R(0.0))) return " + f"{upper}_REFUSED;"]
        stored = [f"s->q_nb[{i}] = q[{i}];" for i in range(4)]
        return "", [*lines, *turn, *stored, *schedule.tick, f"return {upper}_OK;"]
    rows = [i for i, (sensor, _) in enumerate(ROWS) if mask >> SENSORS.index(sensor) & 1]
    part = Terms.of(schedule.gains[:, mask - 1], rows)
    gains = table(f"{suffix}_gain", part.values, _columns(part))
    lines += [
        f"const real *const gain = {suffix}_gain[{schedule.index}];",
        "real c[9];",
        "real t[3];",
        "real b[3];",
        "const real margin = rn_turn_body(s->q_nb, h, q);",
        "rn_half_matrix(q, c);",
    ]
    by_axis = sorted((ROWS[r] for r in rows), key=lambda row: (row[1], row[0]))
    used = {factor for row in part.turn for _, factor in row}
    lines += [
        f"const real {sensor}_{_AXES[axis]} = rn_row(&c[{3 * axis}], {sensor});"
        for sensor, axis in by_axis
        if f"{sensor}_{_AXES[axis]}" in used
    ]
    lines += [f"t[{i}] = {_sum(part.turn[i])};" for i in (0, 2, 1)]
    absurd = "!((margin - (t[0] * t[0]) - (t[1] * t[1]) - (t[2] * t[2])) > R(0.0))"
    lines += [f"if ({absurd}) return {upper}_REFUSED;"]
    lines += [f"b[{i}] = {_sum(part.bias[i])};" for i in (0, 1, 2)]
    lines += ["rn_add_in_body(c, b, s->gyro_bias);", "rn_turn_navigation(q, t, s->q_nb);"]
    return gains, [*lines, *schedule.tick, f"return {upper}_OK;"]


def _columns(part: Terms) -> list[str]:
    names: dict[int, str] = {}
    for result, rows in (("t", part.turn), ("b", part.bias)):
        for i, row in enumerate(rows):
            for k, factor in row:
                names.setdefault(k, f"{result}[{i}] of {factor}")
    return [names[k] for k in sorted(names)]


def _sum(products: tuple[tuple[int, str], ...]) -> str:
    return " + ".join(f"(gain[{k}] * {factor})" for k, factor in products) or "R(0.0)"
