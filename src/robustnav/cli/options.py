"""Options that several verbs share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from robustnav.errors import InputError

Flag = Annotated[bool, Parameter(negative="")]


@Parameter(name="*")
@dataclass(frozen=True)
class Kit:
    """Data-sheet presets of what recorded a log."""

    imu: str = "mpu9250"
    """Data-sheet preset of the IMU."""
    magnetometer: str = "ak8963"
    """Data-sheet preset of the magnetometer."""


KIT = Kit()


def split(names: str) -> list[str]:
    """Return names given with commas."""
    out = [name.strip() for name in names.split(",") if name.strip()]
    if not out:
        raise InputError("estimators", got=repr(names), expected="names with commas, as in h2,mekf")
    return out
