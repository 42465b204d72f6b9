"""The six-axis constant-gain filter as C: the down direction in body axes and the gyro bias.

Heading, of which gyro and accelerometer do not tell, is not carried: three numbers instead of a quaternion.  Turning
the estimate by the gain's correction is mixing a little of the reading into it: docs/firmware.md, section 3.
"""

from __future__ import annotations

import numpy as np

from robustnav.engine.filters import FilterSetup
from robustnav.errors import InputError
from robustnav.export.observer import HALF_TURN, INCLUDES, says
from robustnav.export.schedule import Schedule
from robustnav.export.text import Api, function, header_text, state_functions, table
from robustnav.export.unit import Block, Counted, Unit, switch
from robustnav.units import STANDARD_GRAVITY

STATE = (
    ("down_b", 3, "unit vector down in body axes: roll = atan2(down_b[1], down_b[2]), pitch = -asin(down_b[0])"),
    ("gyro_bias", 3, "in body axes [rad/s]; its part along the vertical is not observed"),
)
BLOCKS = (Block("down_b", 3, 1e-4), Block("gyro_bias", 3, 1e-4))


def six_axes(name: str, real: str, setup: FilterSetup, rate_hz: float) -> Unit:
    """Return the filter: state down_b and gyro bias.

    Raises
    ------
    InputError : the gain is not the same about north and east.
    """
    schedule = Schedule.of(setup, rate_hz)
    K = schedule.gains[:, 0]
    level, bias = K[:, 1, 0], K[:, 4, 0]
    if not (np.allclose(K[:, 0, 1], -level, rtol=1e-6) and np.allclose(K[:, 3, 1], -bias, rtol=1e-6)):
        raise InputError("constant gain", got="axes that differ", expected="the same gain about north and east")
    title = "Roll, pitch and gyro bias from gyro and accelerometer by a constant H2-optimal gain."
    api = Api(name, real, title, STATE, rate_hz if schedule.staged else 0.0, 3)
    values = np.stack([1.0 - level * STANDARD_GRAVITY, -level, bias], axis=1)
    gains = table("update_gain", values, ["kept of the direction", "taken of the reading", "bias"])
    moved = f"int {name}_propagate({name}_state *s, real dt, const real gyro[3])"
    fused = f"int {name}_update({name}_state *s, real dt, const real gyro[3], const real accel[3])"
    source = [gains, function(fused, _update(name, schedule)), function(moved, _propagate(name, schedule))]
    calls = [(1, f"{name}_update(s, row[0], &row[1], &row[4])"), (0, f"{name}_propagate(s, row[0], &row[1])")]
    return Unit(
        name=name,
        real=real,
        title=title,
        header=header_text(api, f"{says(['accel'])}{fused};\n\n{says([])}{moved};\n"),
        source="\n".join([INCLUDES.format(name), *filter(None, [schedule.code(name)]), *source, state_functions(api)]),
        kernel=("rn_real.h", "mcu/rn_steps.h"),
        columns=("dt", *(f"{s}_{i}" for s in ("gyro", "accel") for i in range(3))),
        heads=(fused, moved),
        step=switch(calls),
        counted=(Counted("update", (calls[0][1],)),),
        blocks=BLOCKS,
    )


def _update(name: str, schedule: Schedule) -> list[str]:
    return [
        *HALF_TURN,
        f"const real *const gain = update_gain[{schedule.index}];",
        "real d[3];",
        "real u[3];",
        "rn_turn_vector(s->down_b, h, d);",
        "rn_cross(d, accel, u);",
        *(f"d[{i}] = (gain[0] * d[{i}]) + (gain[1] * accel[{i}]);" for i in range(3)),
        *_normalized(name),
        *(f"s->gyro_bias[{i}] = s->gyro_bias[{i}] + (gain[2] * u[{i}]);" for i in range(3)),
        *schedule.tick,
        f"return {name.upper()}_OK;",
    ]


def _propagate(name: str, schedule: Schedule) -> list[str]:
    lines = ["real d[3];", "rn_turn_vector(s->down_b, h, d);", *_normalized(name)]
    return [*HALF_TURN, *lines, *schedule.tick, f"return {name.upper()}_OK;"]


def _normalized(name: str) -> list[str]:
    """One Newton step to unit length; a direction far from it is refused: its reading was no gravity."""
    return [
        "const real scale = R(1.5) - (R(0.5) * ((d[0] * d[0]) + (d[1] * d[1]) + (d[2] * d[2])));",
        f"if (!(scale > R(0.25))) return {name.upper()}_REFUSED;",
        *(f"s->down_b[{i}] = d[{i}] * scale;" for i in range(3)),
    ]
