"""Constant gains as tables in C: one set, or a start-up schedule that a tick counter steps through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.engine.filters import FilterSetup
from robustnav.errors import InputError
from robustnav.frames import Array


@dataclass(frozen=True)
class Schedule:
    """Gains by tick: ``starts`` (s,) first tick of each set, ``gains`` (s, 2^k - 1, ne, rows)."""

    starts: Array
    gains: Array

    @classmethod
    def of(cls, setup: FilterSetup, rate_hz: float) -> Schedule:
        """Return the schedule of a constant-gain filter in ticks of its design rate."""
        if setup.times is None or setup.gains is None:
            raise InputError("export", got="a filter without gains", expected="a constant-gain filter")
        return cls(np.ceil(np.asarray(setup.times) * rate_hz - 1e-6).astype(int), np.asarray(setup.gains))

    @property
    def staged(self) -> bool:
        """Whether there is more than the one steady set."""
        return len(self.starts) > 1

    def code(self, name: str) -> str:
        """Return the table of starts and the function that counts a tick; nothing for one set."""
        if not self.staged:
            return ""
        upper = name.upper()
        starts = ", ".join(f"{t}u" for t in self.starts)
        return (
            f"#define {upper}_SETS {len(self.starts)}u\n/* first tick of each gain set */\n"
            f"static const uint32_t starts[{upper}_SETS] = {{{starts}}};\n\n"
            f"static void count({name}_state *s)\n{{\n    if ((s->set + 1u) < {upper}_SETS) {{\n"
            "        s->tick = s->tick + 1u;\n"
            "        if (s->tick >= starts[s->set + 1u]) s->set = s->set + 1u;\n    }\n}\n"
        )

    @property
    def index(self) -> str:
        """C index of the set in use."""
        return "s->set" if self.staged else "0"

    @property
    def tick(self) -> list[str]:
        """Statements that count a tick."""
        return ["count(s);"] if self.staged else []
