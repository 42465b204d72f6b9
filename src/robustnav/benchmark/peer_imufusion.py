"""The library imufusion (x-io Technologies, Fusion) with the settings of its own example, gyro bias included."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from robustnav.benchmark.nine_axes import NineAxes
from robustnav.benchmark.peer import Peer
from robustnav.frames import Array, quat_normalize
from robustnav.units import DPS, MICRO_TESLA, STANDARD_GRAVITY

EXAMPLE = {
    "gain": 0.5,
    "gyroscope_range": 2000.0,  # deg/s
    "acceleration_rejection": 10.0,  # deg
    "magnetic_rejection": 10.0,  # deg
    "rejection_timeout": 5.0,  # s
}


def ahrs(imufusion: ModuleType, rate_hz: float) -> Any:
    """Return an ``Ahrs`` with the example's settings, in NED axes."""
    settings = imufusion.AhrsSettings()
    # As an argument of AhrsSettings the convention is ignored without a word; as an attribute it is kept.
    for name, value in {"sample_rate": rate_hz, "convention": imufusion.CONVENTION_NED, **EXAMPLE}.items():
        setattr(settings, name, value)
    return imufusion.Ahrs().set_settings(settings)


def in_its_units(axes: NineAxes) -> tuple[Array, Array, Array]:
    """Return gyro [deg/s], specific force [g] and field [uT], each (n, 3)."""
    return axes.gyro / DPS, axes.accel / STANDARD_GRAVITY, axes.mag / MICRO_TESLA


def _attitude(imufusion: ModuleType, axes: NineAxes) -> Array:
    estimator = ahrs(imufusion, axes.rate_hz)
    settings = imufusion.BiasSettings()
    settings.sample_rate = axes.rate_hz
    bias = imufusion.Bias().set_settings(settings)
    q_nb = np.empty((len(axes.t), 4))
    for k, (gyro, accel, mag) in enumerate(zip(*in_its_units(axes), strict=True)):
        estimator.update(bias.update(gyro), accel, mag)
        q_nb[k] = estimator.get_quaternion()
    return quat_normalize(q_nb)  # it works in single precision


PEERS = (Peer("imufusion", "imufusion", _attitude, {"settings": "the library's example, with Bias", **EXAMPLE}),)
