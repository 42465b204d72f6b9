"""A model whose numbers are part of its equations, so that the C of an export keeps no term that is zero."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from robustnav.model.blocks import Equations, Model, Symbols


def baked(model: Model) -> Model:
    """Return the model with its parameters as numbers and without the noises whose density is zero."""
    silent = {n.name: n.size for n in model.noises if n.density == 0}
    numbers = dict(model.parameters)

    def equations(s: Symbols) -> Equations:
        return model.equations(_Numbers(s, numbers, silent))

    kept = tuple(n for n in model.noises if n.name not in silent)
    return replace(model, parameters={}, noises=kept, equations=equations, shipped=None)


class _Numbers(Symbols):
    """A model's symbols with numbers in place of parameters and zeros in place of silent noises."""

    def __init__(self, symbols: Symbols, numbers: dict[str, float], silent: dict[str, int]) -> None:
        import sympy as sp

        super().__init__(
            {name: sp.Float(v) if v != int(v) else sp.Integer(int(v)) for name, v in numbers.items()}
            | {name: sp.zeros(size, 1) for name, size in silent.items()}
        )
        self._symbols = symbols

    def __getattr__(self, name: str) -> Any:
        """Return a number where there is one, else the symbol."""
        if name in self._entries:
            return self._entries[name]
        return getattr(self._symbols, name)
