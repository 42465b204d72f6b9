"""A model at its nominal point as the continuous plant that the H2 and H-infinity designs take."""

from __future__ import annotations

import numpy as np

from robustnav.design import Plant
from robustnav.engine.backends import functions_of
from robustnav.errors import InputError
from robustnav.model.blocks import Model


def plant_of(model: Model, rate_hz: float) -> Plant:
    """Return the error dynamics of a model with a rotation, sampled noise as intensity variance / rate.

    Disturbances are of unit intensity: the model's noises first, then one for each sensor row; z is the whole error.

    Parameters
    ----------
    model : with a Rotation block; its step is then first order in time, so one second gives A and the noise exactly.
    rate_hz : rate of the sensors' samples [Hz].

    Raises
    ------
    InputError : the model has no Rotation block, or the rate is not positive.
    """
    if model.rotation is None:
        raise InputError(f"model {model.name!r}", got="no Rotation block", expected="a model with an attitude")
    if not (np.isfinite(rate_hz) and rate_hz > 0):
        raise InputError("rate_hz", got=str(rate_hz), expected="a rate above zero")
    functions, x = functions_of(model), model.nominal_state()
    n = model.error_size
    F, Q = functions.transition(x, model.nominal_input(), 1.0)
    H = [functions.jacobian(j, x, model.nominal_known(j)) for j in range(len(model.sensors))]
    sd = np.concatenate([np.full(len(h), np.sqrt(v / rate_hz)) for h, v in zip(H, model.variances, strict=True)])
    values, vectors = np.linalg.eigh(Q)
    B = vectors * np.sqrt(np.maximum(values, 0.0))
    m = len(sd)
    return Plant(
        F - np.eye(n),
        np.hstack([B, np.zeros((n, m))]),
        np.vstack(H),
        np.hstack([np.zeros((m, n)), np.diag(sd)]),
        np.eye(n),
    )
