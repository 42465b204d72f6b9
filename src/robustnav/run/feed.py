"""A log as filters take it, and what a run says of it: innovations, events, settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robustnav.engine.filters import SensorData, SensorSeen
from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.records import BoolArray, Innovations, Log


@dataclass(frozen=True)
class Feed:
    """Times ``t`` (n,) [s] at which a run is reported, inputs ``u`` (n, nu) there, readings by sensor or None."""

    t: Array
    u: Array
    sensors: tuple[SensorData | None, ...]

    @property
    def whole(self) -> BoolArray:
        """Which inputs (n,) are there."""
        whole: BoolArray = np.asarray(np.isfinite(self.u).all(axis=1))
        return whole


def feed_of(model: Model, log: Log) -> Feed:
    """Return what a log feeds to a filter; a model without inputs is reported at the times of its readings.

    Raises
    ------
    InputError : an input stream is missing or empty, no sensor has a stream, inputs have different times, or a
        stream has the wrong width.
    """
    sensors = tuple(_readings(model, j, log) for j in range(len(model.sensors)))
    if not any(sensors):
        raise InputError(
            "no sensor to fuse",
            place=log.source,
            got=f"streams {', '.join(log.streams)}",
            expected=f"one of {', '.join(s.name for s in model.sensors)}",
        )
    if model.inputs:
        return Feed(*_inputs(model, log), sensors)
    t = np.unique(np.concatenate([d.t for d in sensors if d is not None]))
    return Feed(t, np.zeros((len(t), 0)), sensors)


def innovations_of(model: Model, feed: Feed, seen: Sequence[SensorSeen | None]) -> dict[str, Innovations]:
    """Return what the readings said, by sensor."""
    return {
        sensor.name: Innovations(data.t, one.nu, one.s, one.nis, one.weight, one.margin)
        for sensor, data, one in zip(model.sensors, feed.sensors, seen, strict=True)
        if data is not None and one is not None
    }


def deviations(model: Model, P: Array) -> dict[str, Array]:
    """Return standard deviations by block of covariances (n, ne, ne)."""
    with np.errstate(invalid="ignore"):  # NaN where the covariance is broken, which the events name
        sd = np.sqrt(np.diagonal(P, axis1=-2, axis2=-1))
    return {name: sd[:, part] for name, part in model.error_slices.items()}


def events_of(model: Model, log: Log, feed: Feed, max_gap: float) -> tuple[str, ...]:
    """Name in words what is missing in a log, and pauses of its input longer than ``max_gap`` [s]."""
    events, t = [], feed.t
    missing = int((~feed.whole).sum())
    if missing:
        events.append(f"{missing} of {len(t)} input samples missing; each next one covered the time")
    events += [
        f"input pause of {t[k + 1] - t[k]:.3f} s at {t[k]:.3f} s" for k in np.flatnonzero(np.diff(t) > max_gap)[:20]
    ]
    for sensor in model.sensors:
        if sensor.name not in log.streams:
            events.append(f"no {sensor.name} stream: not fused")
            continue
        values = log.streams[sensor.name].values
        missing = int((~np.isfinite(values).all(axis=1)).sum())
        if missing:
            events.append(f"{missing} of {len(values)} {sensor.name} readings missing: not fused")
    return tuple(events)


def broken(model: Model, feed: Feed, seen: Sequence[SensorSeen | None]) -> tuple[str, ...]:
    """Name readings within the input times that were neither used nor refused by a gate."""
    events, t = [], feed.t[feed.whole]
    for sensor, data, one in zip(model.sensors, feed.sensors, seen, strict=True):
        if data is None or one is None or not len(t):
            continue
        due = np.isfinite(data.z).all(axis=1) & (data.t >= t[0]) & (data.t <= t[-1])
        lost = ~np.isfinite(one.nis) | (one.s <= 0.999 * sensor.sd**2).any(axis=1)
        tight = due & (one.margin <= 0)
        if tight.any():
            events.append(
                f"no filter with this bound at {tight.sum()} of {due.sum()} {sensor.name} readings, the first at "
                f"{data.t[tight][0]:.3f} s: the bound did not hold there, gamma is too small"
            )
        rows = np.flatnonzero(due & lost & ~one.used)
        if rows.size:
            first = data.t[rows[0]]
            events.append(f"{rows.size} {sensor.name} readings refused, the first at {first:.3f} s: broken covariance")
    return tuple(events)


def settings_of(model: Model, backend: str) -> dict[str, object]:
    """Return a model's numbers and axes, and which backend ran."""
    out: dict[str, object] = {f"{n.name} density [{n.unit}]": n.density for n in model.noises}
    out |= {f"{s.name} sd [{s.unit}]": s.sd for s in model.sensors}
    out |= {str(k): float(v) for k, v in model.parameters.items()}
    out["backend"] = backend
    if model.rotation is not None:
        out["attitude error in"] = {"n": "navigation axes", "b": "body axes"}[model.rotation.error]
    return out


def _inputs(model: Model, log: Log) -> tuple[Array, Array]:
    streams = [log.stream(block.name) for block in model.inputs]
    if not streams or not len(streams[0]):
        raise InputError("no input samples", place=log.source, expected=", ".join(b.name for b in model.inputs))
    first = streams[0]
    for block, one in zip(model.inputs, streams, strict=True):
        if one.values.shape[1] != block.size:
            got = f"{one.values.shape[1]} columns"
            raise InputError(f"stream {block.name!r}", place=log.source, got=got, expected=f"{block.size}")
        if len(one) != len(first) or not np.array_equal(one.t, first.t):
            raise InputError(
                f"inputs {first.name!r} and {one.name!r}", place=log.source, got="different times", expected="the same"
            )
    return first.t, np.hstack([s.values for s in streams])


def _readings(model: Model, j: int, log: Log) -> SensorData | None:
    sensor = model.sensors[j]
    if sensor.name not in log.streams or not len(log.streams[sensor.name]):
        return None
    one = log.streams[sensor.name]
    if one.values.shape[1] != sensor.width:
        got = f"{one.values.shape[1]} columns"
        columns = ", ".join([f"{sensor.size} of {sensor.name}", *(f"{k.size} of {k.name}" for k in sensor.known)])
        raise InputError(
            f"stream {sensor.name!r}", place=log.source, got=got, expected=f"{sensor.width} columns: {columns}"
        )
    return SensorData(one.t, one.values)
