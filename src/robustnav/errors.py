"""The errors users meet: each names the thing, the place, what it got, what was expected and what to do."""

from __future__ import annotations


class RobustnavError(ValueError):
    """An error a user can act on.

    Parameters
    ----------
    thing : what is wrong, in a few words.
    place : where: file, stream, row, time, option or argument.
    got : what was found.
    expected : what would have been right.
    do : what the user can do next.
    """

    exit_code = 2

    def __init__(self, thing: str, *, place: str = "", got: str = "", expected: str = "", do: str = "") -> None:
        self.thing, self.place, self.got, self.expected, self.do = thing, place, got, expected, do
        super().__init__(self._text())

    def _text(self) -> str:
        lines = [self.thing + (f", {self.place}" if self.place else "")]
        for label, value in (("got", self.got), ("expected", self.expected), ("do", self.do)):
            if value:
                lines.append(f"  {label:<9} {value}")
        return "\n".join(lines)


class InputError(RobustnavError):
    """Data, a file, an option or an argument that cannot be used."""


class MissingExtra(RobustnavError):
    """An optional dependency that is not installed."""

    def __init__(self, module: str, extra: str) -> None:
        super().__init__(
            f"{module} is not installed",
            expected=f"the optional dependency group {extra!r}",
            do=f'pip install "robustnav[{extra}]"',
        )


class EstimatorError(RobustnavError):
    """An estimator or a design that fails its own checks."""

    exit_code = 3
