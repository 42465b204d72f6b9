"""Alignment scenarios from ``alignment.toml`` by name, or from a user's own TOML file, checked and turned into SI."""

from __future__ import annotations

import tomllib
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from robustnav.errors import InputError
from robustnav.sim.alignment_scenario import Scenario, SensorErrors
from robustnav.sim.sway import Sway, Swing
from robustnav.sim.wind import Gusts, Line, Markov, Vector, WindPart
from robustnav.units import DEG, DEG_PER_HOUR, DPS, MILLI_G

DEFAULT_WIND = "lines"

Number = Annotated[float, Field(allow_inf_nan=False)]
Size = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Three = Annotated[list[Number], Field(min_length=3, max_length=3)]
Sizes = Annotated[list[Size], Field(min_length=3, max_length=3)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class _Swing(_Table):
    mean_deg: Number = 0.0
    amplitude_deg: Number = 0.0
    frequency_hz: Size = 0.0
    phase_rad: Number = 0.0

    def record(self) -> Swing:
        return Swing(self.mean_deg * DEG, self.amplitude_deg * DEG, self.frequency_hz, self.phase_rad)


class _Errors(_Table):
    bias: Size
    white_sd: Size
    markov_sd: Size
    markov_time_s: Positive

    def record(self, unit: float) -> SensorErrors:
        return SensorErrors(self.bias * unit, self.white_sd * unit, self.markov_sd * unit, self.markov_time_s)


class _Line(_Table):
    frequency_radps: Positive
    amplitude_ned_mps: Three
    phase_rad: Number = 0.0

    def record(self) -> Line:
        return Line(self.frequency_radps, _vector(self.amplitude_ned_mps), self.phase_rad)


class _Markov(_Table):
    sd_ned_mps: Sizes
    time_s: Positive


class _Gusts(_Table):
    sd_ned_mps: Sizes
    probability: Annotated[float, Field(ge=0, le=1)]


class _Wind(_Table):
    start_s: Size = 0.0
    mean_ned_mps: Three
    lines: list[_Line] = []
    random_phases: bool = False
    markov: _Markov | None = None
    gusts: _Gusts | None = None

    def record(self) -> WindPart:
        return WindPart(
            start=self.start_s,
            mean_n=_vector(self.mean_ned_mps),
            lines=tuple(line.record() for line in self.lines),
            random_phases=self.random_phases,
            markov=Markov(_vector(self.markov.sd_ned_mps), self.markov.time_s) if self.markov else None,
            gusts=Gusts(_vector(self.gusts.sd_ned_mps), self.gusts.probability) if self.gusts else None,
        )


class _Scenario(_Table):
    duration_s: Positive
    imu_rate_hz: Positive
    filter_rate_hz: Positive
    latitude_deg: Annotated[float, Field(ge=-90, le=90)]
    height_m: Number
    heading_deg: Number | None = None
    velocity_sd_mps: Size
    roll: _Swing
    pitch: _Swing
    yaw: _Swing = _Swing()
    gyro_dps: _Errors | None = None
    gyro_dph: _Errors | None = None
    accel_mg: _Errors
    misalignment_deg: Sizes
    wind: Annotated[list[_Wind], Field(min_length=1)]

    @model_validator(mode="after")
    def _one_gyro_and_winds_in_order(self) -> _Scenario:
        if (self.gyro_dps is None) == (self.gyro_dph is None):
            raise ValueError("one of gyro_dps and gyro_dph is needed")
        starts = [part.start_s for part in self.wind]
        if starts[0] != 0 or sorted(set(starts)) != starts:
            raise ValueError(f"wind: start_s {starts}, the first must be 0 and the others increase")
        return self

    def record(self, name: str) -> Scenario:
        gyros = ((self.gyro_dps, DPS), (self.gyro_dph, DEG_PER_HOUR))
        return Scenario(
            name=name,
            sway=Sway(self.roll.record(), self.pitch.record(), self.yaw.record()),
            heading=None if self.heading_deg is None else self.heading_deg * DEG,
            latitude=self.latitude_deg * DEG,
            height=self.height_m,
            duration=self.duration_s,
            imu_rate_hz=self.imu_rate_hz,
            filter_rate_hz=self.filter_rate_hz,
            gyro=next(errors.record(unit) for errors, unit in gyros if errors is not None),
            accel=self.accel_mg.record(MILLI_G),
            velocity_sd=self.velocity_sd_mps,
            misalignment=_vector([angle * DEG for angle in self.misalignment_deg]),
            wind=tuple(part.record() for part in self.wind),
        )


def scenario_names() -> tuple[str, ...]:
    """Return the names of the built-in scenarios."""
    return tuple(_builtin()["scenarios"])


def wind_names() -> tuple[str, ...]:
    """Return the names of the built-in winds."""
    return tuple(_builtin()["winds"])


def load_scenario(name_or_path: str | Path, wind: str | None = None) -> Scenario:
    """Return an alignment scenario.

    Parameters
    ----------
    name_or_path : one of ``scenario_names()``, or a ``.toml`` file with one scenario; ``alignment.toml`` beside this
        module shows the keys and their units.
    wind : one of ``wind_names()``; None takes the file's own wind, or ``lines`` for a built-in scenario.

    Raises
    ------
    InputError : an unknown name, a file that cannot be read or is not TOML, or wrong tables: all mistakes at once.
    """
    builtin = _builtin()
    place = str(name_or_path)
    if place.endswith(".toml"):
        raw = _toml(_text(Path(name_or_path)), place)
        name = Path(name_or_path).stem
    else:
        raw = {**builtin["common"], **_named(builtin["scenarios"], place, "alignment scenario")}
        name, wind = place, wind or DEFAULT_WIND
    if wind is not None:
        raw, name = {**raw, "wind": _named(builtin["winds"], wind, "wind")}, f"{name}, wind {wind}"
    if isinstance(raw.get("wind"), list):
        raw = {**raw, "wind": [_with_lines(part) for part in raw["wind"]]}
    try:
        return _Scenario.model_validate(raw).record(name)
    except ValidationError as why:
        mistakes = [f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in why.errors()]
        raise InputError(
            f"alignment scenario has {len(mistakes)} mistake{'s' if len(mistakes) > 1 else ''}",
            place=place,
            got="\n            ".join(mistakes),
            expected="the keys of alignment.toml",
        ) from why


@lru_cache(maxsize=1)
def _builtin() -> dict[str, Any]:
    return _toml(files("robustnav.sim").joinpath("alignment.toml").read_text(encoding="utf-8"), "alignment.toml")


def _named(table: dict[str, Any], name: str, thing: str) -> Any:
    if name not in table:
        raise InputError(f"unknown {thing} {name!r}", expected=f"one of {', '.join(table)}")
    return table[name]


def _with_lines(part: Any) -> Any:
    """Return a part of a wind with its lines, where they are given by name."""
    if isinstance(part, dict) and isinstance(part.get("lines"), str):
        return {**part, "lines": _named(_builtin()["lines"], part["lines"], "lines of a wind")}
    return part


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError) as why:
        raise InputError("scenario cannot be read", place=str(path), got=str(why), expected="a TOML file") from why


def _toml(text: str, place: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as why:
        raise InputError("scenario is not TOML", place=place, got=str(why), expected="TOML 1.0") from why


def _vector(numbers: list[float]) -> Vector:
    x, y, z = numbers
    return x, y, z
