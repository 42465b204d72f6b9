"""The smoother over a whole recording: compiled with the interpreter lock released, or in NumPy, with one result."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from robustnav.engine import _kernel
from robustnav.engine.compiled import CompiledModel
from robustnav.errors import EstimatorError, InputError
from robustnav.filter import smoother
from robustnav.filter.steps import pack, unpack
from robustnav.frames import Array
from robustnav.model.functions import ModelFunctions
from robustnav.streams import check_time


def smooth(
    functions: CompiledModel | ModelFunctions,
    t: ArrayLike,
    u: ArrayLike,
    x: ArrayLike,
    P: ArrayLike,
    breaks: Sequence[int] = (),
) -> tuple[Array, Array]:
    """Return what the whole recording says of every row that an extended or unscented filter went through.

    Parameters
    ----------
    functions : of the filter's model; a ``CompiledModel`` smooths in the kernel.
    t : (n,) times of the rows [s]; every instant at which the filter fused a reading must be one of them.
    u : (n, nu) inputs; row k is held from row k - 1 on.  A row with a NaN counts as absent, as in the time loop: the
        filter did not move, and the next one covers its time.
    x, P : the filter's states (n, nx) and packed covariances (n, ne (ne + 1) / 2) at the rows, readings included.
    breaks : rows at which the filter was started anew; what comes behind them says nothing of what lies before.

    Returns
    -------
    x, P : smoothed, in the same form; the last row, and the last before a break, stay the filter's.

    Raises
    ------
    InputError : shapes that do not fit, times that go back, infinite inputs, breaks outside the rows.
    EstimatorError : a filter's state or covariance that is not finite.
    """
    model = functions.model
    t = np.ascontiguousarray(t, float)
    ne, n = model.error_size, len(t)
    arrays = {"inputs": (u, model.input_size), "states": (x, model.state_size), "covariances": (P, ne * (ne + 1) // 2)}
    inputs, x_out, P_out = (_checked(name, a, (n, width)) for name, (a, width) in arrays.items())
    for name, values in (("state", x_out), ("covariance", P_out)):
        rows = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if rows.size:
            place = f"row {rows[0]}, {t[rows[0]]:.3f} s"
            raise EstimatorError(f"the filter's {name} is not finite", place=place, do="find why the filter failed")
    dt = intervals(t, inputs, breaks)
    if isinstance(functions, CompiledModel):
        numbers = functions.intensities, functions.parameters
        _kernel.smooth(functions.handle, dt, np.nan_to_num(inputs), *numbers, x_out, P_out)
        return x_out, P_out
    beliefs = smoother.smooth(functions, dt, inputs, list(zip(x_out, unpack(P_out), strict=True)))
    if not beliefs:
        return x_out, P_out
    return np.array([one[0] for one in beliefs]), np.array([pack(one[1]) for one in beliefs])


def intervals(t: Array, u: Array, breaks: Sequence[int] = ()) -> Array:
    """Return how far a filter moved to reach each row (n,) [s]: NaN where it was started, zero where it stayed.

    Its clock starts with the first input that is there; before, and at absent ones, it stays.
    """
    n = len(t)
    check_time(t, "the smoother's rows")
    infinite = np.flatnonzero(np.isinf(u).any(axis=1))
    if infinite.size:
        raise InputError("smoother inputs", place=f"row {infinite[0]}", got="infinity", expected="NaN where missing")
    starts = np.asarray(breaks)
    if starts.size and (starts.dtype.kind not in "iu" or starts.ndim != 1 or starts.min() < 0 or starts.max() >= n):
        raise InputError("breaks", got=str(breaks), expected=f"rows from 0 to {n - 1}")
    again = starts[starts > 0].astype(int)  # row 0 is a start by itself
    moved = np.asarray(np.isfinite(u).all(axis=1))
    moved[again] = True
    first = int(np.argmax(moved)) if moved.any() else 0
    last = np.maximum.accumulate(np.where(moved, np.arange(n), first))
    out: Array = np.diff(t[last], prepend=np.nan)
    out[again] = np.nan
    return out


def _checked(name: str, values: ArrayLike, shape: tuple[int, int]) -> Array:
    out = np.array(values, float, order="C")
    if out.shape != shape:
        raise InputError(f"smoother {name}", got=f"shape {out.shape}", expected=f"shape {shape}")
    return out
