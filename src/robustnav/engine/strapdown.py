"""Strapdown integration in C: the functions of ``robustnav.strapdown``, in the same words.

Everything is called as the NumPy form is, gives the same to rounding and raises the same errors.  ``real="float"`` runs
the firmware's single precision; a position is then good for about a metre.
"""

from __future__ import annotations

import numpy as np

from robustnav.engine import _kernel
from robustnav.frames import Array
from robustnav.strapdown.increments import WIDTH, ImuSamples, Increments
from robustnav.strapdown.navigation import SIZE, Navigation, beyond_the_limit, checked_start
from robustnav.strapdown.preintegration import checked_history
from robustnav.strapdown.static import Place


def preintegrate(samples: ImuSamples, every: int, history: Array | None = None, *, real: str = "double") -> Increments:
    """Integrate samples over intervals, as ``robustnav.strapdown.preintegrate``; ``real``: ``double`` or ``float``."""
    before = np.ascontiguousarray(checked_history(samples, every, history))
    rows = np.empty((len(samples) // every, WIDTH))
    _kernel.preintegrate(real, samples.angle, samples.velocity, before, every, samples.dt, rows)
    return Increments(rows, samples.dt * every)


def navigate(
    start: Navigation, samples: ImuSamples, every: int = 1, history: Array | None = None, *, real: str = "double"
) -> Navigation:
    """Integrate samples to a path, as ``robustnav.strapdown.navigate``; ``real``: ``double`` or ``float``."""
    row, before = checked_start(start), np.ascontiguousarray(checked_history(samples, every, history))
    out = np.empty((len(samples) // every, SIZE))
    done = _kernel.navigate(real, row, samples.angle, samples.velocity, before, every, samples.dt, out)
    if done < len(out):
        raise beyond_the_limit(done, samples.dt * every)
    return Navigation.from_rows(out)


def carry(
    q_nb: Array,
    v_n: Array,
    increments: Increments,
    place: Place,
    bias: tuple[Array, Array] | None = None,
    *,
    real: str = "double",
) -> tuple[Array, Array]:
    """Carry attitude and velocity at one place, as ``robustnav.strapdown.carry``; ``real``: ``double`` or ``float``."""
    n, start = len(increments), np.concatenate([q_nb, v_n])
    biases = np.zeros((n, 6))
    if bias is not None:
        biases[:, :3], biases[:, 3:] = bias
    out = np.empty((n + 1, 7))
    out[0] = start
    where = np.concatenate([place.earth_rate_n, place.gravity_n])
    _kernel.carry(real, start, increments.rows, where, biases, increments.dt, out[1:])
    return out[:, :4], out[:, 4:]
