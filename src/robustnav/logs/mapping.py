"""What a foreign table means, in TOML: columns, units, frames; every choice is written down, none is guessed.

::

    delimiter = ","
    [time]
    column = "Time (s)"                 # or rate_hz = 100.0 for a table without a time column
    unit = "s"                          # s, ms, us, ns
    [gyro]
    columns = ["gx", "gy", "gz"]
    unit = "deg/s"                      # rad/s, deg/s, mrad/s
    frame = "FLU"                       # FRD, FLU
    [accel]
    columns = ["ax", "ay", "az"]
    unit = "g"                          # m/s^2, g, mg
    frame = "FLU"
    sign = 1                            # -1 for a device that reports minus the specific force
    [mag]
    columns = ["mx", "my", "mz"]
    unit = "uT"                         # T, uT, nT, G, mG
    frame = "FLU"
    [velocity]                          # measured from outside: GNSS, a log at a mooring
    columns = ["ve", "vn"]              # two horizontal ones, or three
    unit = "kn"                         # m/s, km/h, kn
    frame = "ENU"                       # NED, ENU: the order of the columns above
    [gnss_velocity]
    columns = ["ve", "vn", "vu"]
    unit = "m/s"                        # m/s, cm/s, mm/s, km/h, kn
    frame = "ENU"
    [gnss_position]                     # or [gnss_place] with latitude, longitude, height
    columns = ["e", "n", "u"]
    unit = "m"                          # m, cm, mm
    frame = "ENU"
    [gnss_place]
    columns = ["lat", "lon", "alt"]     # in this order
    unit = "deg"                        # deg, 1e-7deg, rad: of latitude and longitude
    height_unit = "m"                   # m, mm
    fix_column = "fix"                  # optional: rows whose number there is below 3 have no fix
    [attitude]
    columns = ["qw", "qx", "qy", "qz"]
    order = "wxyz"                      # wxyz, xyzw: the order of the columns above
    direction = "body_to_world"         # or world_to_body
    body = "FLU"                        # FRD, FLU
    world = "ENU"                       # NED, ENU
    north = "magnetic"                  # magnetic, true
    role = "truth"                      # truth, estimate
    kind = "optical"                    # what made it, in a word
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from robustnav.logs.files import read_text, unusable
from robustnav.units import (
    DEG,
    DPS,
    GAUSS,
    KILOMETRE_PER_HOUR,
    KNOT,
    MICRO_TESLA,
    MILLI_G,
    MILLI_GAUSS,
    NANO_TESLA,
    STANDARD_GRAVITY,
)

_SPEEDS = {"m/s": 1.0, "cm/s": 0.01, "mm/s": 1e-3, "km/h": KILOMETRE_PER_HOUR, "kn": KNOT}
FACTORS = {
    "gyro": {"rad/s": 1.0, "deg/s": DPS, "mrad/s": 1e-3},
    "accel": {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "mg": MILLI_G},
    "mag": {"T": 1.0, "uT": MICRO_TESLA, "nT": NANO_TESLA, "G": GAUSS, "mG": MILLI_GAUSS},
    "velocity": _SPEEDS,
    "gnss_velocity": _SPEEDS,
    "gnss_position": {"m": 1.0, "cm": 0.01, "mm": 1e-3},
}
PLACE_FACTORS = {"deg": 1.0, "1e-7deg": 1e-7, "rad": 1 / DEG}
HEIGHT_FACTORS = {"m": 1.0, "mm": 1e-3}
Positive = Annotated[float, Field(ge=1e-6, le=1e6)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


class TimeColumn(_Table):
    """Where time comes from: a column and its unit, or a rate."""

    column: str | None = None
    unit: Literal["s", "ms", "us", "ns"] | None = None
    rate_hz: Positive | None = None

    @model_validator(mode="after")
    def _one_source(self) -> TimeColumn:
        if (self.column is None) == (self.rate_hz is None) or (self.column is None) != (self.unit is None):
            raise ValueError("give column and unit, or rate_hz alone")
        return self


class SensorColumns(_Table):
    """Three columns of a sensor, their unit, frame and sign."""

    columns: tuple[str, str, str]
    unit: str
    frame: Literal["FRD", "FLU"]
    sign: Literal[1, -1] = 1


class LevelColumns(_Table):
    """Two or three columns of a velocity against the ground or of a position, their unit and frame."""

    columns: Annotated[tuple[str, ...], Field(min_length=2, max_length=3)]
    unit: str
    frame: Literal["NED", "ENU"]


class PlaceColumns(_Table):
    """Latitude, longitude and height, their units, and the column that says what is a fix."""

    columns: tuple[str, str, str]
    unit: Literal["deg", "1e-7deg", "rad"]
    height_unit: Literal["m", "mm"]
    fix_column: str | None = None


class AttitudeColumns(_Table):
    """Four columns of an attitude and everything its convention leaves open."""

    columns: tuple[str, str, str, str]
    order: Literal["wxyz", "xyzw"]
    direction: Literal["body_to_world", "world_to_body"]
    body: Literal["FRD", "FLU"]
    world: Literal["NED", "ENU"]
    north: Literal["magnetic", "true"]
    role: Literal["truth", "estimate"]
    kind: str


class Mapping(_Table):
    """A whole mapping; ``skip_lines`` counts the lines before the header."""

    time: TimeColumn
    gyro: SensorColumns | None = None
    accel: SensorColumns | None = None
    mag: SensorColumns | None = None
    velocity: LevelColumns | None = None
    gnss_velocity: LevelColumns | None = None
    gnss_position: LevelColumns | None = None
    gnss_place: PlaceColumns | None = None
    attitude: AttitudeColumns | None = None
    delimiter: Annotated[str, Field(pattern=r"^[,;\t |]$")] = ","
    skip_lines: Annotated[int, Field(ge=0, le=1000)] = 0

    @model_validator(mode="after")
    def _known_units(self) -> Mapping:
        for name, part in (self.sensors() | self.levels()).items():
            if part.unit not in FACTORS[name]:
                raise ValueError(f"{name}.unit {part.unit!r}: one of {', '.join(FACTORS[name])}")
        if self.gnss_position is not None and self.gnss_place is not None:
            raise ValueError("give gnss_position or gnss_place, not both")
        return self

    def sensors(self) -> dict[str, SensorColumns]:
        """Return the sensors on the body that the mapping names."""
        parts = {"gyro": self.gyro, "accel": self.accel, "mag": self.mag}
        return {name: part for name, part in parts.items() if part is not None}

    def levels(self) -> dict[str, LevelColumns]:
        """Return the velocities and positions in level axes that the mapping names."""
        parts = {name: getattr(self, name) for name in ("velocity", "gnss_velocity", "gnss_position")}
        return {name: part for name, part in parts.items() if part is not None}


def load_mapping(path: Path) -> Mapping:
    """Return the mapping in a TOML file; raise ``InputError`` naming all its mistakes at once."""
    expected = (
        "a mapping: [time], and [gyro] [accel] [mag] [velocity] [gnss_...] [attitude] as far as the table has them"
    )
    text = read_text(path, expected)
    try:
        return Mapping.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as why:
        raise unusable(path, str(why), expected, do="correct the TOML") from why
    except (ValidationError, RecursionError) as why:
        wrong = why.errors(include_url=False) if isinstance(why, ValidationError) else []
        got = "; ".join(f"{'.'.join(str(k) for k in e['loc']) or 'mapping'}: {e['msg']}" for e in wrong)
        raise unusable(path, got or "tables nested without end", expected, do="correct these entries") from why
