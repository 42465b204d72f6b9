"""The constant-gain filter: nonlinear propagation, a gain designed beforehand, no covariance at run time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robustnav.filter.steps import Seen
from robustnav.frames import Array
from robustnav.model.functions import ModelFunctions


def correct(
    model: ModelFunctions, x: Array, gain: Array, readings: Mapping[int, Array]
) -> tuple[Array, dict[int, Seen]]:
    """Correct the state with all readings of one instant.

    Parameters
    ----------
    model : the model's functions.
    x : state (nx,).
    gain : K (ne, rows of all sensors) designed for the sensors present; columns of absent sensors do not matter.
    readings : by position of the sensor in the model, finite readings (width,).

    Returns
    -------
    x, seen : the state after x [+] K r, body vectors of K r turned from navigation axes, and the residuals.
    """
    parts, seen = [], {}
    for i in range(len(model.model.sensors)):
        rows = model.rows[i]
        if i in readings:
            r = model.residual(i, x, readings[i])
            seen[i] = Seen(r, np.full(rows, np.nan), float("nan"), 1.0)
        else:
            r = np.zeros(rows)
        parts.append(r)
    return model.inject_turned(x, gain @ np.concatenate(parts)), seen
