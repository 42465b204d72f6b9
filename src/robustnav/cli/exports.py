"""``export``: a filter as C99 for firmware."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from robustnav.cli.designs import STANDARD, Setting
from robustnav.cli.options import Flag
from robustnav.cli.show import note, say, say_json, say_table
from robustnav.errors import InputError

if TYPE_CHECKING:
    from robustnav.export.build import Exportable

MODELS = ("attitude", "inclination", "uwb_2d", "uwb_3d")


def export(
    model: str,
    filter: str,
    *,
    out: Path,
    type: Literal["float", "double", "int32"] = "float",
    name: str | None = None,
    setting: Setting = STANDARD,
    log: Path | None = None,
    steady: Flag = False,
    json: Flag = False,
) -> None:
    """Write a filter as a self-contained C99 tree with test vectors and, where it can be measured, its cost.

    Parameters
    ----------
    model
        attitude (nine axes), inclination (no magnetometer), uwb_2d or uwb_3d (ranges).
    filter
        h2 (constant gain, on attitude and inclination) or mekf, ekf (Kalman, on any).
    out
        Folder to write to.
    type
        Number type; int32 is the constant gain on raw counts, on attitude.
    name
        Prefix of every symbol; default rn_<model>_<filter>.
    setting
        Sensors and place the filter is designed for.
    log
        Design on this recording instead: noise for a carrier that moves, rates and field as recorded.
    steady
        The steady gain alone, without a start-up schedule.
    json
        Print one JSON document.
    """
    from robustnav.export import export as write

    estimator, rate_hz = _estimator(model, filter, setting, log, steady=steady or type == "int32")
    done = write(estimator, out, name=name, real=type, rate_hz=rate_hz)
    if json:
        say_json({"folder": str(done.folder), "name": done.name, "files": done.files, "cost": done.cost})
        return
    say(f"{done.name}: {len(done.files)} files in {done.folder}")
    if done.cost:
        say_table("Instructions an update, bytes; -O2", done.cost)
    else:
        note("cost not measured: arm-none-eabi-gcc and qemu-system-arm are not installed")


def _estimator(model: str, kind: str, setting: Setting, log: Path | None, *, steady: bool) -> tuple[Exportable, float]:
    from robustnav.run import EKF, H2

    if kind not in ("h2", "mekf", "ekf") or (kind == "h2" and model.startswith("uwb")):
        raise InputError(
            f"filter {kind!r}", place=f"model {model!r}", expected="h2 on attitude or inclination; mekf, ekf"
        )
    if log is not None:
        return _recorded(model, kind, setting, log, steady=steady)
    if model.startswith("uwb") and model in MODELS:
        from robustnav.models import uwb

        ranging = uwb(range_sd=0.1, acceleration_density=1.0, dimensions=int(model[4]))
        return EKF(ranging), setting.rate_hz
    if model == "inclination":
        from robustnav.models.inclination import inclination
        from robustnav.run.inclination import LevelH2

        level = inclination(setting.noise())
        return (LevelH2(level, setting.rate_hz, steady=steady) if kind == "h2" else EKF(level)), setting.rate_hz
    if model != "attitude":
        raise InputError(f"model {model!r}", expected=", ".join(MODELS))
    nine = setting.model()
    start = "steady" if steady else None
    return (H2(nine, setting.rate_hz, start_sd=start) if kind == "h2" else EKF(nine)), setting.rate_hz


def _recorded(model: str, kind: str, setting: Setting, log: Path, *, steady: bool) -> tuple[Exportable, float]:
    """Return the estimator that ``run`` would use on a recording."""
    from robustnav import logs
    from robustnav.run import H2
    from robustnav.run.recorded import Sensors, estimator_for

    if model != "attitude":
        raise InputError("--log", got=f"model {model!r}", expected="attitude")
    recording = logs.read(log)
    estimator, _ = estimator_for(
        "h2" if kind == "h2" else "mekf", recording, Sensors(setting.imu, setting.magnetometer)
    )
    rate_hz = recording.stream("gyro").rate_hz
    if kind == "h2" and steady:
        estimator = H2(estimator.model, rate_hz, start_sd="steady")
    return estimator, rate_hz
