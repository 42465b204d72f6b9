"""Run an estimator over a recording: the one place where streams meet a filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robustnav.engine.backends import RunningFilter, running_filter
from robustnav.engine.filters import Output
from robustnav.errors import InputError
from robustnav.filter.steps import unpack
from robustnav.frames import Array, matrix_from_quat
from robustnav.model.blocks import Model
from robustnav.records import Log, Run
from robustnav.run.estimators import H2, Estimator
from robustnav.run.feed import broken, deviations, events_of, feed_of, innovations_of, settings_of


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
    fed = feed_of(model, log)
    running = stream(estimator, start, backend=backend)
    output = running.run(fed.t, fed.u, fed.sensors)
    return Run(
        estimator=estimator.name,
        model=model.name,
        t=fed.t,
        state={name: output.x[:, part] for name, part in model.state_slices.items()},
        sd=deviations(model, covariance_of(estimator, fed.t, fed.u, output)),
        innovations=innovations_of(model, fed, output.seen),
        events=events_of(model, log, fed, max_gap) + broken(model, fed, output.seen),
        settings=settings_of(model, running.backend) | _design(estimator),
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


def _design(estimator: Estimator) -> dict[str, object]:
    if not isinstance(estimator, H2):
        return {}
    return {"design rate [Hz]": estimator.rate_hz, "gain sets": len(estimator.table.times)}
