"""The header ``<name>_replay.h`` that feeds test vectors to an exported filter, on a host or on a target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robustnav.export.text import comment, literal
from robustnav.export.unit import Unit
from robustnav.frames import Array

Bits = NDArray[np.int_]


def replay_header(unit: Unit, rows: Array, present: Bits, start: Array, expected: Array) -> str:
    """Return the header: vectors, one function that feeds a row, one that does the work whose cost is stated.

    Parameters
    ----------
    unit : the filter.
    rows : (n, columns) numbers that go in, integers for ``int32``.
    present : (n,) bits of the sensors to fuse.
    start : state that the replay starts at.
    expected : (n, numbers) of the state that Python reached.
    """
    name, row = unit.name, unit.row_type
    integer = unit.real == "int32"
    kind = "int32_t" if integer else "real"
    first, arguments, outputs, bounds, begin = 0, [], [], [], []
    for block in unit.blocks:
        arguments.append(f"&replay_start[{first}]")
        scale = f" * {literal(block.unit)}" if integer else ""
        cast = "(real)" if integer else ""
        outputs += [f"out[{first + i}] = {cast}s->{block.name}[{i}]{scale};" for i in range(block.size)]
        bounds += [repr(float(block.bound))] * block.size
        mine = start[first : first + block.size]
        begin += [str(round(v / block.unit)) if integer else literal(v) for v in mine]
        first += block.size
    counted = "\n".join(
        f"{'#if' if k == 0 else '#elif'} RN_COUNT == {k} /* {work.label} */\n"
        + "".join(f"    refused |= {call};\n" for call in work.calls)
        for k, work in enumerate(unit.counted)
    )
    return (
        comment(f"Test vectors of {name}: {', '.join(unit.columns)}; what the Python filter made of them.")
        + f'#ifndef {name.upper()}_REPLAY_H\n#define {name.upper()}_REPLAY_H\n\n#include "{name}.h"\n'
        + ("typedef float real;\n#define R(v) v##f\n\n" if integer else "\n")
        + f"#define RN_ROWS {len(rows)}\n#define RN_COLUMNS {rows.shape[1]}\n#define RN_OUTPUTS {unit.numbers}\n"
        "#ifndef RN_COUNT\n#define RN_COUNT 0\n#endif\n"
        f"typedef {name}_state rn_replay_state;\ntypedef {row} rn_row_number;\n\n"
        f"static const {kind} replay_start[RN_OUTPUTS] = {{{', '.join(begin)}}};\n"
        f"static const double replay_bound[RN_OUTPUTS] = {{{', '.join(bounds)}}};\n"
        + _numbers(f"static const {row} replay_row[RN_ROWS][RN_COLUMNS]", rows, integer=row != "real")
        + f"static const unsigned char replay_present[RN_ROWS] = {{{', '.join(str(int(p)) for p in present)}}};\n"
        + _numbers("static const real replay_expected[RN_ROWS][RN_OUTPUTS]", expected, integer=False)
        + "\nstatic int replay_reset(rn_replay_state *s)\n"
        + f"{{\n    return {name}_reset(s, {', '.join(arguments)});\n}}\n\n"
        + "static void replay_output(const rn_replay_state *s, real out[RN_OUTPUTS])\n"
        + f"{{\n    {' '.join(outputs)}\n}}\n\n"
        + f"static int replay_step(rn_replay_state *s, const {row} row[RN_COLUMNS], int present)\n"
        + "{\n    int refused = 0;\n"
        + "".join(f"    {line}\n" for line in unit.step)
        + "    return refused;\n}\n\n#ifdef RN_COUNTED\n"
        + f"static int replay_counted(rn_replay_state *s, const {row} row[RN_COLUMNS])\n{{\n    int refused = 0;\n"
        + f"{counted}#endif\n    return refused;\n}}\n#endif\n\n#endif\n"
    )


def _numbers(head: str, values: Array, *, integer: bool) -> str:
    def one(value: float) -> str:
        return str(int(value)) if integer else literal(float(np.float32(value)) if abs(value) < 3e38 else value)

    rows = ",\n".join("    {" + ", ".join(one(v) for v in row) + "}" for row in values)
    return f"{head} = {{\n{rows}}};\n"
