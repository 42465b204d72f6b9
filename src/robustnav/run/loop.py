"""Run an estimator over a recording: the one place where streams meet a filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robustnav.engine.backends import RunningFilter, running_filter
from robustnav.engine.filters import Output, SensorData
from robustnav.errors import InputError
from robustnav.filter.steps import unpack
from robustnav.frames import Array, matrix_from_quat
from robustnav.model.blocks import Model, Rotation
from robustnav.records import Innovations, Log, Run
from robustnav.run.estimators import H2, Estimator


@dataclass(frozen=True)
class Start:
    """Where a filter starts: state ``x`` (nx,) and covariance ``P`` (ne, ne) of its error."""

    x: Array
    P: Array

    @classmethod
    def at(cls, model: Model, sd: Mapping[str, ArrayLike] | None = None, **blocks: ArrayLike) -> Start:
        """Return a start at given blocks (``q_nb=...``; the model's nominal elsewhere) with ``sd`` by block."""
        x = model.nominal_state()
        for name, value in blocks.items():
            if name not in model.state_slices:
                raise InputError("start", got=f"block {name!r}", expected=", ".join(model.state_slices))
            x[model.state_slices[name]] = value
        return cls(x, model.start_covariance(sd))


def stream(estimator: Estimator, start: Start, *, backend: str = "auto") -> RunningFilter:
    """Return a filter to feed sample by sample: ``update(input, *readings, dt)``, then ``state``, ``covariance``."""
    return running_filter(estimator.model, estimator.setup(start.x, start.P), backend)


def run(
    estimator: Estimator,
    log: Log,
    start: Start,
    *,
    backend: str = "auto",
    max_gap: float = 1.0,
) -> Run:
    """Run an estimator over a log, every reading at its own time.

    Parameters
    ----------
    estimator : ``H2``, ``EKF`` or ``UKF`` with its model.
    log : streams named as the model's inputs and sensors; a sensor without a stream is not fused.  A model without
        inputs is reported at the times of its readings.
    start : state and covariance at the first input.
    backend : ``auto``, ``c``, ``float`` or ``numpy``.
    max_gap : a longer pause of the input [s] is named in the events.

    Returns
    -------
    Run : states and standard deviations at the input times, innovations of every sensor.

    Raises
    ------
    InputError : an input stream is missing or empty, no sensor has a stream, inputs have different times, or a
        stream has the wrong width.
    """
    model = estimator.model
    sensors = [_readings(model, j, log) for j in range(len(model.sensors))]
    if not any(sensors):
        raise InputError(
            "no sensor to fuse",
            place=log.source,
            got=f"streams {', '.join(log.streams)}",
            expected=f"one of {', '.join(s.name for s in model.sensors)}",
        )
    t, u = _inputs(model, log) if model.inputs else _reading_times(sensors)
    running = stream(estimator, start, backend=backend)
    output = running.run(t, u, sensors)
    state = {name: output.x[:, part] for name, part in model.state_slices.items()}
    innovations = {
        s.name: Innovations(d.t, seen.nu, seen.s, seen.nis, seen.weight)
        for s, d, seen in zip(model.sensors, sensors, output.seen, strict=True)
        if d is not None and seen is not None
    }
    return Run(
        estimator=estimator.name,
        model=model.name,
        t=t,
        state=state,
        sd=_deviations(estimator, t, u, output),
        innovations=innovations,
        events=_events(model, log, t, u, max_gap) + _broken(model, t[np.isfinite(u).all(axis=1)], sensors, output),
        settings=_settings(estimator, running.backend),
    )


def covariance_of(estimator: Estimator, t: Array, u: Array, output: Output) -> Array:
    """Return the covariance (n, ne, ne) an estimator claims at each input time, in the model's error coordinates."""
    if output.P is not None:
        return unpack(output.P)
    if not isinstance(estimator, H2):
        raise InputError("covariance", got="a run without covariances", expected="covariance=True")
    model = estimator.model
    valid = np.flatnonzero(np.isfinite(u).all(axis=1))
    begin = t[valid[0]] if valid.size else t[0]
    P = estimator.covariance_at(t - begin)
    rotation = model.rotation
    if rotation is None or rotation.error != "n":
        return P
    turn = np.tile(np.eye(model.error_size), (len(t), 1, 1))  # body vectors of the design are in navigation axes
    C_bn = np.swapaxes(matrix_from_quat(output.x[:, model.state_slices[rotation.name]]), -1, -2)
    for block in model.state:
        if block.frame == "b":
            part = model.error_slices[block.name]
            turn[:, part, part] = C_bn
    out: Array = turn @ P @ np.swapaxes(turn, -1, -2)
    return out


def _deviations(estimator: Estimator, t: Array, u: Array, output: Output) -> dict[str, Array]:
    P = covariance_of(estimator, t, u, output)
    with np.errstate(invalid="ignore"):  # NaN where the covariance is broken, which the events name
        sd = np.sqrt(np.diagonal(P, axis1=-2, axis2=-1))
    return {name: sd[:, part] for name, part in estimator.model.error_slices.items()}


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


def _reading_times(sensors: list[SensorData | None]) -> tuple[Array, Array]:
    t = np.unique(np.concatenate([d.t for d in sensors if d is not None]))
    return t, np.zeros((len(t), 0))


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


def _events(model: Model, log: Log, t: Array, u: Array, max_gap: float) -> tuple[str, ...]:
    events = []
    missing = int((~np.isfinite(u).all(axis=1)).sum())
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


def _broken(model: Model, t: Array, sensors: list[SensorData | None], output: Output) -> tuple[str, ...]:
    """Name readings within the input times ``t`` that were neither used nor refused by a gate."""
    events = []
    for sensor, data, seen in zip(model.sensors, sensors, output.seen, strict=True):
        if data is None or seen is None or not len(t):
            continue
        due = np.isfinite(data.z).all(axis=1) & (data.t >= t[0]) & (data.t <= t[-1])
        broken = ~np.isfinite(seen.nis) | (seen.s <= 0.999 * sensor.sd**2).any(axis=1)
        rows = np.flatnonzero(due & broken & ~seen.used)
        if rows.size:
            first = data.t[rows[0]]
            events.append(f"{rows.size} {sensor.name} readings refused, the first at {first:.3f} s: broken covariance")
    return tuple(events)


def _settings(estimator: Estimator, backend: str) -> dict[str, object]:
    model = estimator.model
    out: dict[str, object] = {f"{n.name} density [{n.unit}]": n.density for n in model.noises}
    out |= {f"{s.name} sd [{s.unit}]": s.sd for s in model.sensors}
    out |= {str(k): float(v) for k, v in model.parameters.items()}
    out["backend"] = backend
    rotation = next((b for b in model.state if isinstance(b, Rotation)), None)
    if rotation is not None:
        out["attitude error in"] = {"n": "navigation axes", "b": "body axes"}[rotation.error]
    if isinstance(estimator, H2):
        out["design rate [Hz]"] = estimator.rate_hz
        out["gain sets"] = len(estimator.table.times)
    return out
