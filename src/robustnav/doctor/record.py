"""What the doctor says: findings in words, and the numbers behind them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Literal

import numpy as np

Level = Literal["ok", "info", "warning", "error"]
LEVELS: tuple[Level, ...] = ("ok", "info", "warning", "error")


@dataclass(frozen=True)
class Finding:
    """One statement about a recording.

    Parameters
    ----------
    check : id of the check: T time, Q readings, F accelerometer size, B magnetometer size, G gravity, D field,
        E rotation, A axes by attitude, V axes by gravity and field, S gyro scale, L lag, H heading, N north,
        R reference, M motion, I notes of the reader.
    level : ``error`` would poison an estimator, ``warning`` limits what the recording proves, ``info`` is worth
        knowing, ``ok`` passed.
    thing, got, expected, do : what it is about, what was measured, what would be right, the remedy.
    """

    check: str
    level: Level
    thing: str
    got: str = ""
    expected: str = ""
    do: str = ""


@dataclass(frozen=True)
class Diagnosis:
    """Findings on one recording in the order of the checks, and the ``facts`` they rest on, by name with unit."""

    source: str
    findings: tuple[Finding, ...]
    facts: Mapping[str, object] = field(default_factory=dict)

    @property
    def worst(self) -> Level:
        """The highest level among the findings; ``ok`` without any."""
        return max((f.level for f in self.findings), key=LEVELS.index, default="ok")

    def at(self, level: Level) -> tuple[Finding, ...]:
        """Return the findings of one level."""
        return tuple(f for f in self.findings if f.level == level)

    def of(self, check: str) -> tuple[Finding, ...]:
        """Return the findings of one check."""
        return tuple(f for f in self.findings if f.check == check)

    def to_dict(self) -> dict[str, object]:
        """Return plain lists, numbers and strings for JSON; what is not a number becomes None."""
        return {
            "source": self.source,
            "worst": self.worst,
            "findings": [asdict(f) for f in self.findings],
            "facts": plain(self.facts),
        }


def plain(value: object) -> object:
    """Return ``value`` with arrays as lists, NumPy scalars as Python's, and NaN or infinity as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
