"""Named intermediate results and common subexpressions: from expressions to ordered C statements."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from robustnav.model.printer import print_c


class Program:
    """Collects ``let`` definitions while a function is derived, then prints those its outputs need.

    Every definition keeps its name in the C, so generated code reads like the derivation.
    """

    def __init__(self) -> None:
        self._definitions: dict[str, Any] = {}
        self._known: dict[Any, Any] = {}

    def let(self, name: str, expression: Any) -> Any:
        """Name an expression and return its symbol; numbers, symbols and their negatives stay as they are."""
        import symengine as se

        expression = se.sympify(expression)
        bare = -expression if type(expression).__name__ == "Mul" else expression
        if bare.is_Symbol or expression.is_Number:
            return expression
        if expression in self._known:
            return self._known[expression]
        if name in self._definitions:
            raise KeyError(f"two different expressions named {name!r}")
        symbol = se.Symbol(name)
        self._definitions[name] = expression
        self._known[expression] = symbol
        return symbol

    def let_all(self, name: str, expressions: Sequence[Any]) -> list[Any]:
        """Name each of a list: ``name_0``, ``name_1``, ..."""
        return [self.let(f"{name}_{i}", e) for i, e in enumerate(expressions)]

    def let_matrix(self, name: str, rows: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """Name each entry of a matrix: ``name_i_j``."""
        return [[self.let(f"{name}_{i}_{j}", e) for j, e in enumerate(row)] for i, row in enumerate(rows)]

    def statements(self, outputs: Sequence[tuple[str, Any]]) -> list[str]:
        """Return C statements that assign every output (target text, expression), temporaries first.

        All inputs are read before the first output is stored, so a function may work in place.
        """
        import symengine as se

        names = list(self._definitions)
        wanted = [se.sympify(e) for _, e in outputs]
        shared, reduced = se.cse([*self._definitions.values(), *wanted])
        table = dict(zip(names, reduced[: len(names)], strict=True))
        table.update((str(symbol), expression) for symbol, expression in shared)
        results = reduced[len(names) :]

        alias = _named_temporaries(names, table)
        order: list[str] = []
        for result in results:
            _visit(result, table, alias, order)
        rename = {name: f"t_{i}" for i, name in enumerate(n for n in order if _TEMPORARY.fullmatch(n))} | alias

        def text(expression: Any) -> str:
            return re.sub(r"\bx\d+\b", lambda m: rename.get(m.group(), m.group()), _unwrap(print_c(expression)))

        lines = [f"const real {rename.get(name, name)} = {text(table[name])};" for name in order]
        return lines + [f"{target} = {text(e)};" for (target, _), e in zip(outputs, results, strict=True)]


_TEMPORARY = re.compile(r"x\d+")


def _named_temporaries(names: list[str], table: dict[str, Any]) -> dict[str, str]:
    """Give a shared subexpression that is a whole definition that definition's name."""
    alias: dict[str, str] = {}
    for name in names:
        temporary = str(table[name])
        if table[name].is_Symbol and temporary in table and _TEMPORARY.fullmatch(temporary) and temporary not in alias:
            alias[temporary] = name
            table[name] = table.pop(temporary)
    return alias


def _visit(expression: Any, table: dict[str, Any], alias: dict[str, str], order: list[str]) -> None:
    """Depth first over the definitions an expression needs, children by name, so the order never varies."""
    for name in sorted((alias.get(str(s), str(s)) for s in expression.free_symbols), key=_natural):
        if name in table and name not in order:
            _visit(table[name], table, alias, order)
            order.append(name)


def _natural(name: str) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]


def _unwrap(text: str) -> str:
    """Drop one pair of parentheses around a whole statement."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for i, letter in enumerate(text):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if depth == 0 and i < len(text) - 1:
            return text
    return text[1:-1]
