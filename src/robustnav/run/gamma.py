"""The smallest H-infinity bound that a recording lets a filter keep."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.records import Log
from robustnav.run.estimators import HInfinity
from robustnav.run.loop import Start, run

LARGEST = 1e9  # beyond it the filter is the UKF to rounding
STEPS = 20  # of bisection, in the logarithm
CLOSE = 1e-3  # relative


def smallest_gamma(estimator: Callable[[float], HInfinity], log: Log, start: Start, *, margin: float = 1.1) -> float:
    """Return the smallest bound for which the filter exists at every reading of a log, times a margin.

    Existence is that of Hassibi, Sayed, Kailath, Indefinite-Quadratic Estimation and Control (1999), theorem 4.2.1.
    It belongs to this log and start: a filter that starts with larger doubt needs a larger bound.

    Parameters
    ----------
    estimator : returns the filter of a given bound.
    log, start : as for ``run``.
    margin : at least 1; at the smallest bound itself the covariance grows without limit.

    Raises
    ------
    InputError : a margin below 1, or a log that does not fit the model.
    EstimatorError : no bound up to 1e9 will do.
    """
    if not 1 <= margin < np.inf:
        raise InputError("margin", got=str(margin), expected="a factor, at least 1")
    high = 1.0
    while not _exists(estimator(high), log, start):
        high *= 10.0
        if high > LARGEST:
            raise EstimatorError(
                "no H-infinity filter exists",
                place=log.source,
                got=f"existence violated at every bound up to {LARGEST:g}",
                expected="a bound at which it holds",
                do="run a UKF on the log: its covariance breaks too",
            )
    low = high / 10.0
    while low > 1 / LARGEST and _exists(estimator(low), log, start):
        low, high = low / 10.0, low
    for _ in range(STEPS):
        if high < low * (1 + CLOSE):
            break
        middle = float(np.sqrt(low * high))
        if _exists(estimator(middle), log, start):
            high = middle
        else:
            low = middle
    return margin * high


def _exists(estimator: HInfinity, log: Log, start: Start) -> bool:
    """Say whether the condition holds at every reading that was fused, and the filter is whole at the end."""
    done = run(estimator, log, start)
    margins = np.concatenate([one.margin for one in done.innovations.values() if one.margin is not None])
    fused = margins[~np.isnan(margins)]
    whole = all(np.isfinite(sd[-1]).all() for sd in done.sd.values())
    return bool(whole and fused.size and (fused > 0).all())
