"""From an estimator to its C: which form, which vectors."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from robustnav.engine.filters import FilterSetup
from robustnav.errors import InputError
from robustnav.export.covariance import kalman
from robustnav.export.fixed import fixed_point
from robustnav.export.level import six_axes
from robustnav.export.observer import nine_axes
from robustnav.export.replay import replay_header
from robustnav.export.scaling import Counts
from robustnav.export.unit import TYPES, Unit, symbol
from robustnav.export.vectors import Plan, Vectors, down_of, record
from robustnav.frames import Array
from robustnav.model.blocks import Model


class Exportable(Protocol):
    """An estimator: ``H2``, ``LevelH2`` or ``EKF``."""

    @property
    def model(self) -> Model:
        """The model, with its noise."""

    @property
    def name(self) -> str:
        """As users name it."""

    def setup(self, x: Array, P: Array) -> FilterSetup:
        """Return what a filter is started with."""


def build(
    estimator: Exportable, name: str, real: str, rate_hz: float, counts: Counts | None = None
) -> tuple[Unit, str]:
    """Return an estimator as C with its replay header.

    Parameters
    ----------
    estimator : what is exported.
    name : prefix of every symbol.
    real : ``float``, ``double`` or ``int32``.
    rate_hz : rate of the inputs [Hz]; a start-up schedule and the integer filter count its ticks.
    counts : of the sensors, for ``int32``; None: an MPU-9250's.

    Raises
    ------
    InputError : unknown type, no C form of this estimator in it, or the rate is not positive.
    """
    if real not in TYPES:
        raise InputError("export type", got=repr(real), expected=", ".join(TYPES))
    if not (np.isfinite(rate_hz) and rate_hz > 0):
        raise InputError("rate_hz", got=str(rate_hz), expected="a rate above zero")
    model, name, plan = estimator.model, symbol(name), Plan(rate_hz)
    setup = estimator.setup(_start(model), model.start_covariance())
    nine = setup.kind == "fixed" and model.name == "attitude" and model.prebuilt
    if real == "int32":
        if not nine:
            raise InputError("integer export", got=estimator.name, expected="a constant gain on models.attitude")
        counts = counts or Counts()
        unit, _ = fixed_point(name, model, setup, rate_hz, counts)
        seen = record(model, setup, replace(plan, counts=(counts.gyro, counts.accel, counts.mag)))
        rows = np.hstack([seen.u / counts.gyro, seen.z[0] / counts.accel, seen.z[1] / counts.mag])
        return unit, replay_header(unit, np.round(rows), seen.present, seen.start, seen.x)
    if setup.kind == "fixed" and model.name == "inclination":
        unit = six_axes(name, real, setup, rate_hz)
        seen = record(model, setup, plan)
        return unit, _replay(unit, seen, down_of(seen.x), down_of(seen.start))
    if nine:
        unit = nine_axes(name, real, model, setup, rate_hz)
    elif setup.kind == "ekf":
        unit = kalman(name, real, model, setup)
    else:
        got = f"{estimator.name} on model {model.name!r}"
        raise InputError("export", got=got, expected="EKF on any model, or H2 on attitude or inclination")
    seen = record(model, setup, plan)
    return unit, _replay(unit, seen, seen.x, seen.start)


def _start(model: Model) -> Array:
    """Return where test vectors start: the nominal state, an attitude a little off it."""
    x = model.nominal_state()
    if model.rotation is not None:
        x[model.state_slices[model.rotation.name]] = np.array([0.98, 0.06, -0.1, 0.15]) / np.linalg.norm(
            [0.98, 0.06, -0.1, 0.15]
        )
    return x


def _replay(unit: Unit, seen: Vectors, expected: Array, start: Array) -> str:
    rows = np.hstack([seen.dt[:, None], seen.u, *seen.z])
    return replay_header(unit, rows, seen.present, start, expected)
