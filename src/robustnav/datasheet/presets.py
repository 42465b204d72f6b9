"""Named data-sheet presets: ``presets.toml`` or a user's own file of the same form, checked and turned into SI.

The noise convention and the meaning of every key are at the head of ``presets.toml``.
"""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from functools import lru_cache
from importlib.resources import files
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from robustnav.datasheet.sensors import Imu, Magnetometer, SensorSpec
from robustnav.errors import InputError
from robustnav.units import DEG_PER_HOUR, DPS, MICRO_G, MICRO_TESLA, MILLI_G, STANDARD_GRAVITY

if TYPE_CHECKING:
    from pydantic import BaseModel

_UNIFORM = 1 / sqrt(3)  # standard deviation of a uniform draw within +-1
_PERCENT = 1e-2
_RANDOM_WALK = sqrt(2) / 60  # one-sided density per root hertz of a random walk per root hour


class _Key(NamedTuple):
    """Which figure a key of the file states, and the factor to SI."""

    figure: str
    factor: float


_GYRO = {
    "gyro_density_dps_rthz": _Key("density", DPS),
    "gyro_angle_random_walk_deg_rth": _Key("density", DPS * _RANDOM_WALK),
    "gyro_rms_dps": _Key("noise_rms_sd", DPS),
    "gyro_bandwidth_hz": _Key("bandwidth_hz", 1.0),
    "gyro_bias_instability_dph": _Key("bias_instability", DEG_PER_HOUR),
    "gyro_random_walk_dps_rts": _Key("random_walk", DPS),
    "gyro_turn_on_bias_max_dps": _Key("turn_on_bias_sd", DPS * _UNIFORM),
    "gyro_turn_on_bias_sd_dps": _Key("turn_on_bias_sd", DPS),
    "gyro_scale_percent": _Key("scale_sd", _PERCENT * _UNIFORM),
    "gyro_cross_axis_percent": _Key("misalignment_sd", _PERCENT * _UNIFORM),
    "gyro_range_dps": _Key("range_max", DPS),
    "gyro_resolution_dps": _Key("resolution", DPS),
}
_ACCEL = {
    "accel_density_ug_rthz": _Key("density", MICRO_G),
    "accel_velocity_random_walk_mps_rth": _Key("density", _RANDOM_WALK),
    "accel_rms_mg": _Key("noise_rms_sd", MILLI_G),
    "accel_bandwidth_hz": _Key("bandwidth_hz", 1.0),
    "accel_bias_instability_ug": _Key("bias_instability", MICRO_G),
    "accel_random_walk_ug_rts": _Key("random_walk", MICRO_G),
    "accel_turn_on_bias_max_mg": _Key("turn_on_bias_sd", MILLI_G * _UNIFORM),
    "accel_turn_on_bias_sd_mg": _Key("turn_on_bias_sd", MILLI_G),
    "accel_scale_percent": _Key("scale_sd", _PERCENT * _UNIFORM),
    "accel_cross_axis_percent": _Key("misalignment_sd", _PERCENT * _UNIFORM),
    "accel_range_g": _Key("range_max", STANDARD_GRAVITY),
    "accel_resolution_mg": _Key("resolution", MILLI_G),
}
_MAG = {
    "mag_density_ut_rthz": _Key("density", MICRO_TESLA),
    "mag_rms_ut": _Key("noise_rms_sd", MICRO_TESLA),
    "mag_bandwidth_hz": _Key("bandwidth_hz", 1.0),
    "mag_bias_instability_ut": _Key("bias_instability", MICRO_TESLA),
    "mag_random_walk_ut_rts": _Key("random_walk", MICRO_TESLA),
    "mag_turn_on_bias_max_ut": _Key("turn_on_bias_sd", MICRO_TESLA * _UNIFORM),
    "mag_turn_on_bias_sd_ut": _Key("turn_on_bias_sd", MICRO_TESLA),
    "mag_scale_percent": _Key("scale_sd", _PERCENT * _UNIFORM),
    "mag_cross_axis_percent": _Key("misalignment_sd", _PERCENT * _UNIFORM),
    "mag_range_ut": _Key("range_max", MICRO_TESLA),
    "mag_resolution_ut": _Key("resolution", MICRO_TESLA),
}
_SENSORS = {"imu": {"gyro": _GYRO, "accel": _ACCEL}, "magnetometer": {"mag": _MAG}}


def imu(name_or_path: str | Path) -> Imu:
    """Return an inertial measurement unit in SI units.

    Parameters
    ----------
    name_or_path : a name of ``names()["imu"]``, or a ``.toml`` file with one ``[imu.<name>]`` table.

    Raises
    ------
    InputError : the name is unknown, or the file cannot be used; all its mistakes are listed at once.
    """
    name, table = _find("imu", name_or_path)
    return Imu(name, _spec(table, _GYRO), _spec(table, _ACCEL), table["document"], tuple(table["assumed"]))


def magnetometer(name_or_path: str | Path) -> Magnetometer:
    """Return a magnetometer in SI units; arguments and errors as for ``imu``, table ``[magnetometer.<name>]``."""
    name, table = _find("magnetometer", name_or_path)
    return Magnetometer(name, _spec(table, _MAG), table["document"], tuple(table["assumed"]))


def names() -> dict[str, tuple[str, ...]]:
    """Return the names of the presets by kind: ``imu`` and ``magnetometer``."""
    return {kind: tuple(tables) for kind, tables in _builtin().items()}


def _find(kind: str, name_or_path: str | Path) -> tuple[str, dict[str, Any]]:
    if str(name_or_path).endswith(".toml"):
        return _only(kind, Path(name_or_path))
    name, known = str(name_or_path), _builtin()[kind]
    if name not in known:
        near = get_close_matches(name.lower(), known, n=1)
        raise InputError(
            f"unknown {kind} {name!r}",
            expected=f"one of {', '.join(known)}, or the path of a .toml file",
            do=f"did you mean {near[0]!r}?" if near else "",
        )
    return name, known[name]


def _only(kind: str, path: Path) -> tuple[str, dict[str, Any]]:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as why:
        raise InputError("sensor file cannot be read", place=str(path), got=str(why), expected="a TOML file") from why
    tables = _parse(text, str(path))[kind]
    if len(tables) != 1:
        raise InputError(
            f"sensor file for {kind}",
            place=str(path),
            got=f"{len(tables)} tables: {', '.join(tables) or 'none'}",
            expected=f"one table [{kind}.<name>]",
        )
    return next(iter(tables.items()))


@lru_cache(maxsize=1)
def _builtin() -> dict[str, dict[str, dict[str, Any]]]:
    return _parse(files("robustnav.datasheet").joinpath("presets.toml").read_text(encoding="utf-8"), "presets.toml")


def _spec(table: Mapping[str, Any], keys: Mapping[str, _Key]) -> SensorSpec:
    figures = {key.figure: table[name] * key.factor for name, key in keys.items() if table.get(name) is not None}
    return SensorSpec(**figures)


def _parse(text: str, place: str) -> dict[str, dict[str, dict[str, Any]]]:
    """Return the tables of a file by kind and name, checked, or raise one ``InputError`` with every mistake."""
    import tomllib

    from pydantic import ValidationError

    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as why:
        raise InputError("sensor file is not TOML", place=place, got=str(why), expected="TOML 1.0") from why
    try:
        parsed = _file_model().model_validate(raw).model_dump()
    except ValidationError as why:
        raise _refused([f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in why.errors()], place) from why
    mistakes = [
        f"{kind}.{name}: {text}"
        for kind, sensors in _SENSORS.items()
        for name, table in parsed[kind].items()
        for text in _contradictions(table, sensors)
    ]
    if mistakes:
        raise _refused(mistakes, place)
    return parsed


def _refused(mistakes: list[str], place: str) -> InputError:
    return InputError(
        f"sensor file has {len(mistakes)} mistake{'s' if len(mistakes) > 1 else ''}",
        place=place,
        got="\n            ".join(mistakes),
        expected="the keys of presets.toml, with positive numbers",
    )


def _contradictions(table: Mapping[str, Any], sensors: Mapping[str, Mapping[str, _Key]]) -> list[str]:
    """Return what a table says twice, forgets, or marks as assumed without saying it."""
    found = [f"assumed: no figure {name!r} here" for name in table["assumed"] if table.get(name) is None]
    for sensor, keys in sensors.items():
        stated: dict[str, str] = {}
        for name, key in keys.items():
            if table[name] is None:
                continue
            if key.figure in stated:
                found.append(f"{name}: the same figure as {stated[key.figure]}")
            stated[key.figure] = name
        if not {"density", "noise_rms_sd"} & stated.keys():
            found.append(f"no noise figure for {sensor!r}: a density, a random walk per root hour or an rms")
    return found


@lru_cache(maxsize=1)
def _file_model() -> type[BaseModel]:
    from pydantic import ConfigDict, Field, create_model

    strict = ConfigDict(extra="forbid", strict=True)

    def table(kind: str) -> type[BaseModel]:
        positive = Field(default=None, gt=0, allow_inf_nan=False)
        figures: dict[str, Any] = {key: (float | None, positive) for keys in _SENSORS[kind].values() for key in keys}
        figures |= {"document": (str, Field(min_length=1)), "assumed": (list[str], [])}
        return create_model(kind, __config__=strict, **figures)

    kinds: dict[str, Any] = {kind: (dict[str, table(kind)], {}) for kind in _SENSORS}  # type: ignore[misc]
    return create_model("sensors", __config__=strict, **kinds)
