"""The constant gain without a magnetometer: designed on the part of the error that the accelerometer sees."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robustnav.design.schedule import GainTable, SensorRows, Startup, gain_table
from robustnav.engine.backends import functions_of
from robustnav.errors import InputError
from robustnav.model.blocks import Model
from robustnav.run.estimators import H2

_SEEN = [0, 1, 3, 4]  # tilt about north and east, and the bias along them


class LevelH2(H2):
    """H2-optimal constant gain on ``models.inclination``: roll, pitch and the bias across the vertical.

    Heading and the bias along the vertical get no correction and no variance: ``covariance_at`` says NaN of them.

    Parameters
    ----------
    model : ``models.inclination``.
    rate_hz : rate of gyro and accelerometer [Hz].
    steady : the steady gain alone; else a start-up schedule from the model's ``start_sd``.
    sets : gain sets in the schedule.

    Raises
    ------
    InputError : another model, or a rate that is not positive.
    EstimatorError : the gain fails its certificate.
    """

    def __init__(self, model: Model, rate_hz: float, *, steady: bool = False, sets: int = 32) -> None:
        if model.name != "inclination":
            raise InputError("LevelH2", got=f"model {model.name!r}", expected="models.inclination", do="use H2")
        if not (np.isfinite(rate_hz) and rate_hz > 0):
            raise InputError("rate_hz", got=str(rate_hz), expected="a rate above zero")
        self.model, self.rate_hz, self.steady = model, float(rate_hz), steady
        functions, x, dt = functions_of(model), model.nominal_state(), 1.0 / rate_hz
        F, Q = functions.transition(x, model.nominal_input(), dt)
        H = functions.jacobian(0, x)
        square = np.ix_(_SEEN, _SEEN)
        startup = None if steady else Startup(model.start_covariance()[square], sets)
        rows = SensorRows("accel", H[:, _SEEN], model.sensors[0].sd ** 2, 1)
        self.table = _whole(gain_table(F[square], Q[square], [rows], dt, startup), model.error_size)


def _whole(table: GainTable, size: int) -> GainTable:
    """Put a table of the seen part back among all errors: no gain, and no known variance, elsewhere."""
    gains = np.zeros((*table.gains.shape[:2], size, table.gains.shape[3]))
    gains[:, :, _SEEN] = table.gains
    covariance = np.zeros((len(table.covariance), size, size))
    unseen = [i for i in range(size) if i not in _SEEN]
    covariance[:, unseen, unseen] = np.nan
    seen = np.array(_SEEN)
    covariance[:, seen[:, None], seen] = table.covariance
    return replace(table, gains=gains, covariance=covariance)
