"""Symengine expressions as C99 text: a direct walk over the nodes, the same text in every run.

Powers are always parenthesised products; ``pow`` never appears.  Constants print as ``R(0.5)``, which is a float or
a double literal; functions print with the prefix ``rn_``, which maps to the f-suffixed call in float.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from robustnav.errors import InputError

_FUNCTIONS = {
    "sin": "rn_sin",
    "cos": "rn_cos",
    "tan": "rn_tan",
    "asin": "rn_asin",
    "acos": "rn_acos",
    "atan": "rn_atan",
    "atan2": "rn_atan2",
    "log": "rn_log",
    "Abs": "rn_abs",
}
_FLOAT_SMALLEST, _FLOAT_LARGEST = 1.2e-38, 3.4e38
_POWERS = {
    Fraction(2): "({0} * {0})",
    Fraction(3): "({0} * {0} * {0})",
    Fraction(4): "(({0} * {0}) * ({0} * {0}))",
    Fraction(1, 2): "rn_sqrt({0})",
    Fraction(3, 2): "({0} * rn_sqrt({0}))",
}


def constant(value: float) -> str:
    """Return a real literal ``R(...)``; refuse what a float cannot hold."""
    if value != 0 and not _FLOAT_SMALLEST <= abs(value) <= _FLOAT_LARGEST:
        raise InputError("constant in a model", got=repr(value), expected="a number that a float can hold, or zero")
    return f"R({float(value)!r})"


def print_c(expression: Any) -> str:
    """Return the C text of a symengine expression."""
    kind = type(expression).__name__
    if kind == "Symbol":
        return str(expression)
    if expression.is_Number or kind in ("Pi", "Exp1"):
        return constant(_real(expression))
    if kind == "Add":
        return _print_sum(expression)
    if kind == "Mul":
        return _print_product(expression)
    if kind == "Pow":
        base, exponent = expression.args
        return f"rn_exp({print_c(exponent)})" if type(base).__name__ == "Exp1" else _print_power(base, exponent)
    if kind == "FunctionSymbol" and expression.get_name() == "rn_wrap":
        return f"rn_wrap({print_c(expression.args[0])})"
    if kind in _FUNCTIONS:
        return f"{_FUNCTIONS[kind]}({', '.join(print_c(a) for a in expression.args)})"
    raise InputError(
        f"cannot print {kind} as C", place=str(expression)[:80], expected=f"+, *, powers, exp, {', '.join(_FUNCTIONS)}"
    )


def _real(number: Any) -> float:
    try:
        return float(number)
    except RuntimeError as why:
        raise InputError("constant in a model", got=str(number), expected="a real number") from why


def _print_sum(expression: Any) -> str:
    terms = sorted(((_negative(a), a) for a in expression.args), key=lambda p: (p[0], str(p[1])))
    text = ""
    for negative, term in terms:
        body = print_c(-term if negative else term)
        body = f"({body})" if type(-term if negative else term).__name__ == "Add" else body
        if text:
            text += f" - {body}" if negative else f" + {body}"
        else:
            text = f"-{body}" if negative else body
    return f"({text})"


def _print_product(expression: Any) -> str:
    if _negative(expression):
        return f"-{_factor(-expression)}"
    above: list[str] = []
    below: list[str] = []
    for factor in sorted(expression.args, key=str):
        if type(factor).__name__ == "Pow" and factor.args[1].is_Number and _negative(factor.args[1]):
            below.append(print_c(1 / factor))
        elif factor.is_Number:
            above.insert(0, constant(_real(factor)))
        else:
            above.append(_factor(factor))
    top = " * ".join(above) or constant(1.0)
    if not below:
        return top
    bottom = below[0] if len(below) == 1 else f"({' * '.join(below)})"
    return f"{top} / {bottom}"


def _print_power(base: Any, exponent: Any) -> str:
    power = _fraction(exponent)
    if power is None or (power != 1 and abs(power) not in _POWERS and abs(power) != 1):
        raise InputError(
            "cannot print a power as C",
            place=f"({base})**({exponent})"[:80],
            expected="exponents +-1, +-2, +-3, +-4, +-1/2, +-3/2",
        )
    text = _factor(base)
    if abs(power) == Fraction(1, 2):
        text = print_c(base)
    if abs(power) != 1:
        text = _POWERS[abs(power)].format(text)
    return text if power > 0 else f"({constant(1.0)} / {text})"


def _fraction(exponent: Any) -> Fraction | None:
    if not exponent.is_Number:
        return None
    value = Fraction(float(exponent)).limit_denominator(64)
    return value if float(value) == float(exponent) else None


def _factor(expression: Any) -> str:
    """Print with parentheses where a product would otherwise change the meaning."""
    text = print_c(expression)
    return f"({text})" if type(expression).__name__ == "Mul" or text.startswith("-") else text


def _negative(expression: Any) -> bool:
    if expression.is_Number:
        return _real(expression) < 0
    return type(expression).__name__ == "Mul" and any(a.is_Number and _real(a) < 0 for a in expression.args)
