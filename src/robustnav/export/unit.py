"""What an exported filter is made of, whatever filter it is."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from robustnav.errors import InputError

TYPES = ("float", "double", "int32")
_NAME = re.compile(r"[a-z][a-z0-9_]{0,30}")


@dataclass(frozen=True)
class Counted:
    """Work whose cost is stated: a label and the C calls that do it, with state ``s`` and the numbers ``row``."""

    label: str
    calls: tuple[str, ...]


@dataclass(frozen=True)
class Block:
    """Numbers of the state that a user sets and reads.

    ``name`` of the C field; ``size``; ``bound``: largest accepted difference from Python over the test vectors;
    ``unit``: what one is worth where the field is an integer.
    """

    name: str
    size: int
    bound: float
    unit: float = 1.0


@dataclass(frozen=True)
class Unit:
    """One filter as C99.

    Parameters
    ----------
    name : prefix of every symbol.
    real : ``float``, ``double`` or ``int32``.
    title : one line on what it is.
    header, source : text of ``<name>.h`` and ``<name>.c``.
    heads : heads of the public functions that take readings.
    kernel : hand-written headers of ``csrc`` it includes.
    columns : of a row of test vectors: what each number is.
    step : C statements that feed ``row`` and set ``refused``; sensors in the bits of ``present`` are fused.
    counted : the work whose cost is stated; the first is a whole update with every reading.
    blocks : of the state that a user sets and reads.
    notes : paragraphs for the README: ranges, bounds, what differs from the Python form.
    """

    name: str
    real: str
    title: str
    header: str
    source: str
    heads: tuple[str, ...]
    kernel: tuple[str, ...]
    columns: tuple[str, ...]
    step: tuple[str, ...]
    counted: tuple[Counted, ...]
    blocks: tuple[Block, ...]
    notes: tuple[str, ...] = field(default=())

    @property
    def row_type(self) -> str:
        """C type of the numbers in a row."""
        return "int16_t" if self.real == "int32" else "real"

    @property
    def numbers(self) -> int:
        """Numbers of the state that a user sets and reads."""
        return sum(block.size for block in self.blocks)


def switch(calls: list[tuple[int, str]]) -> tuple[str, ...]:
    """Return C statements that choose among calls by the sensors present."""
    lines = []
    for k, (mask, call) in enumerate(calls):
        lines += [f"{'else if' if k else 'if'} (present == {mask}) refused = {call};"]
    return tuple(lines)


def symbol(name: str) -> str:
    """Return a name that every symbol of an export may start with.

    Raises
    ------
    InputError : it is no lower-case C identifier of at most 31 characters.
    """
    if not _NAME.fullmatch(name):
        raise InputError("export name", got=repr(name), expected="lower-case letters, digits and _, at most 31")
    return name


def functions_by_mask(sensors: tuple[str, ...]) -> list[tuple[int, str]]:
    """Return (mask, function suffix) of every set of sensors, the full one first."""
    full = (1 << len(sensors)) - 1
    out = []
    for mask in sorted(range(full + 1), reverse=True):
        names = [s for j, s in enumerate(sensors) if mask >> j & 1]
        suffix = "update" if mask == full else "propagate" if not mask else f"update_{'_'.join(names)}"
        out.append((mask, suffix))
    return out
