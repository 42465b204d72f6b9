"""Pieces of C text that every exported filter shares: numbers, tables, headers, state functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import wrap

from robustnav.frames import Array
from robustnav.model.printer import constant

State = Sequence[tuple[str, int, str]]  # C name, how many numbers, what they are


def literal(value: float) -> str:
    """Return a real literal; numbers too small for a float are zero."""
    return constant(0.0 if abs(value) < 1.2e-38 else float(value))


def comment(text: str, indent: str = "") -> str:
    """Return text as a C comment of lines up to 118 characters."""
    lines = wrap(text, 112 - len(indent))
    return indent + "/* " + f"\n{indent} * ".join(lines) + " */\n"


def table(name: str, values: Array, columns: Sequence[str]) -> str:
    """Return a constant table (rows, columns) with its columns named in a comment."""
    rows = ",\n".join("    {" + ", ".join(literal(v) for v in row) + "}" for row in values)
    return comment(", ".join(columns)) + f"static const real {name}[{len(values)}][{len(values[0])}] = {{\n{rows}}};\n"


def function(head: str, body: Sequence[str]) -> str:
    """Return a function of a head and its lines."""
    return f"{head}\n{{\n" + "".join(f"    {line}\n" if line else "\n" for line in body) + "}\n"


@dataclass(frozen=True)
class Api:
    """What header and source say alike.

    ``rate_hz``: ticks that a start-up schedule counts, 0 without a schedule; ``unit_block``: number of leading state
    numbers whose length must be one.
    """

    name: str
    real: str
    title: str
    state: State
    rate_hz: float
    unit_block: int

    @property
    def numbers(self) -> int:
        """Numbers of the state that a user sets and reads."""
        return sum(size for _, size, _ in self.state)


def header_text(api: Api, declarations: str) -> str:
    """Return the public header."""
    name, upper = api.name, api.name.upper()
    fields = "".join(f"    real {n}[{size}]; /* {what} */\n" for n, size, what in api.state)
    if api.rate_hz:
        fields += "    uint32_t tick; /* updates since the start, while the start-up schedule lasts */\n"
        fields += "    uint32_t set;  /* gain set of the schedule in use */\n"
    start = ", ".join(f"const real {n}[{size}]" for n, size, _ in api.state)
    real = "#ifndef RN_FLOAT\n#define RN_FLOAT\n#endif\n" if api.real == "float" else ""
    about = comment(
        f"{api.title} SI units and radians; body axes are forward, right, down; at rest the accelerometer reads about "
        "(0, 0, -9.8).  No allocation, no globals, no library function; the caller owns the state.  Functions return "
        f"{upper}_OK, or {upper}_REFUSED and leave the state as it was."
    )
    saved = api.numbers + (2 if api.rate_hz else 0)
    return (
        f'{about}#ifndef {upper}_H\n#define {upper}_H\n\n#include <stdint.h>\n\n{real}#include "rn_real.h"\n\n'
        f"enum {{ {upper}_OK = 0, {upper}_REFUSED = 1 }};\n#define {upper}_SAVED {saved}\n\n"
        f"typedef struct {{\n{fields}}} {name}_state;\n\n"
        "/* Start. */\n"
        f"int {name}_reset({name}_state *s, {start});\n\n{declarations}\n"
        f"/* The state as {upper}_SAVED plain numbers, to keep over a restart, and back; refused if not finite. */\n"
        f"void {name}_save(const {name}_state *s, real saved[{upper}_SAVED]);\n"
        f"int {name}_restore({name}_state *s, const real saved[{upper}_SAVED]);\n\n#endif\n"
    )


def state_functions(api: Api) -> str:
    """Return reset, save and restore; restore takes every state that updates can reach, reset a unit one."""
    name, upper = api.name, api.name.upper()
    start = ", ".join(f"const real {n}[{size}]" for n, size, _ in api.state)
    places = [(n, i, k) for k, (n, i) in enumerate((n, i) for n, size, _ in api.state for i in range(size))]
    squares = [f"({n}[{i}] * {n}[{i}])" for n, i, _ in places]
    put = [
        f"const real unit = {' + '.join(squares[: api.unit_block])};",
        f"const real rest = {' + '.join(squares[api.unit_block :])};",
        f"if (!((unit > least) && (unit < most) && (rest < R(1e12)))) return {upper}_REFUSED;",
        *(f"s->{n}[{i}] = {n}[{i}];" for n, i, _ in places),
        *(["s->tick = 0u;", "s->set = 0u;"] if api.rate_hz else []),
        f"return {upper}_OK;",
    ]
    save = [f"saved[{k}] = s->{n}[{i}];" for n, i, k in places]
    back, count = [], []
    at = len(places)
    if api.rate_hz:
        save += [f"saved[{at}] = (real)s->tick;", f"saved[{at + 1}] = (real)s->set;"]
        back = [
            f"if (!((saved[{at}] >= R(0.0)) && (saved[{at}] < R(16777216.0)))) return {upper}_REFUSED;",
            f"if (!((saved[{at + 1}] >= R(0.0)) && (saved[{at + 1}] < (real){upper}_SETS))) return {upper}_REFUSED;",
        ]
        count = [f"s->tick = (uint32_t)saved[{at}];", f"s->set = (uint32_t)saved[{at + 1}];"]
    blocks = [n for n, _, _ in api.state]
    kept = [f"&saved[{sum(size for _, size, _ in api.state[:k])}]" for k in range(len(api.state))]
    state, numbers = f"{name}_state *s", f"real saved[{upper}_SAVED]"
    return "\n".join(
        [
            function(f"static int put({state}, {start}, real least, real most)", put),
            function(f"int {name}_reset({state}, {start})", [f"return put(s, {', '.join(blocks)}, R(0.99), R(1.01));"]),
            function(f"void {name}_save(const {state}, {numbers})", save),
            function(
                f"int {name}_restore({state}, const {numbers})",
                [
                    *back,
                    f"if (put(s, {', '.join(kept)}, R(0.1), R(3.0)) != {upper}_OK) return {upper}_REFUSED;",
                    *count,
                    f"return {upper}_OK;",
                ],
            ),
        ]
    )
