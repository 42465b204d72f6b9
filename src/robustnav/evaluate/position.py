"""How far estimated positions are from the reference: rms with an interval, percentiles, maximum, counts."""

from __future__ import annotations

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.attitude import NOT_AN_ERROR
from robustnav.evaluate.reference import gaps
from robustnav.records import Array, BoolArray, Run, Score, Truth

AXES = {"2d": 2, "3d": 3}
CONFIDENCE = 0.95
LAGS_PER_TIME = 5.0  # Sokal's window: long enough for the sum of correlations, short enough for its noise


def position_figures(errors: Array) -> dict[str, float]:
    """Return the figures of position errors, in metres.

    Rows before the first estimate are no failure: they are counted as ``unstarted`` and left out.  A NaN after it is
    counted in ``nan_estimates`` and makes the figures NaN; nothing is dropped because an estimator failed.

    Parameters
    ----------
    errors : (n, 3) estimate minus reference [m], in time order, NaN where there is no estimate.

    Returns
    -------
    ``rmse_2d`` and ``rmse_3d``, of the first two axes and of all; each with ``_low`` and ``_high`` as ``rms_interval``
    gives them, ``median_``, ``p95_`` and ``max_`` of the distance; ``samples``, ``unstarted``, ``nan_estimates``, and
    ``independent``, what the 3D errors are worth in independent samples.

    Raises
    ------
    InputError : another shape.
    """
    if errors.ndim != 2 or errors.shape[1] != 3:
        raise InputError("position errors", got=f"shape {errors.shape}", expected="shape (n, 3)")
    known: BoolArray = np.asarray(np.isfinite(errors).all(axis=1))
    first = int(np.argmax(known)) if known.any() else len(errors)
    scored = errors[first:]
    out: dict[str, float] = {}
    for name, axes in AXES.items():
        out |= distance_figures(np.sum(scored[:, :axes] ** 2, axis=1), name)
    return out | {
        "samples": float(len(scored)),
        "unstarted": float(first),
        "nan_estimates": float(np.count_nonzero(~known[first:])),
        "independent": effective_samples(np.sum(scored**2, axis=1)),
    }


def distance_figures(squares: Array, name: str) -> dict[str, float]:
    """Return rms with its interval, median, 95th percentile and maximum of distances, from their squares (n,)."""
    keys = (f"rmse_{name}", f"rmse_{name}_low", f"rmse_{name}_high", f"median_{name}", f"p95_{name}", f"max_{name}")
    if not squares.size:
        return dict.fromkeys(keys, float("nan"))
    values = (np.sqrt(np.mean(squares)), *rms_interval(squares), *np.sqrt(np.percentile(squares, [50, 95, 100])))
    return dict(zip(keys, map(float, values), strict=True))


def effective_samples(values: Array) -> float:
    """Return how many independent samples a correlated series (n,) is worth for its mean, from 1 to n.

    n over the integrated autocorrelation time, summed to the first lag of five such times.  A. Sokal, Monte Carlo
    Methods in Statistical Mechanics, 1997, section 3.  A series that never changes counts as one sample, a NaN as none.
    """
    n = len(values)
    if not np.isfinite(values).all() or not n:
        return 0.0
    off = values - values.mean()
    if not (np.abs(off) > 1e-12 * np.abs(values).max()).any():
        return 1.0
    spectrum = np.abs(np.fft.rfft(off, 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[:n]
    times = 2 * np.cumsum(covariance / covariance[0]) - 1
    window = int(np.argmax(np.arange(n) >= LAGS_PER_TIME * times))
    return float(n / np.clip(times[window], 1.0, n))


def rms_interval(squares: Array, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return a two-sided interval of the root of a mean square, from correlated squared errors (n,) in time order.

    Student's interval of the logarithm of the mean with ``effective_samples``.  It speaks of the same recording gone
    on for longer, not of another one.  NaN with fewer than two independent samples.
    """
    count = effective_samples(squares)
    if count < 2:
        return float("nan"), float("nan")
    from scipy.special import stdtrit

    mean = float(np.mean(squares))
    spread = float(np.std(squares, ddof=1)) / np.sqrt(count) / mean
    factor = float(np.exp(0.5 * stdtrit(count - 1, 0.5 + 0.5 * confidence) * spread))
    return float(np.sqrt(mean)) / factor, float(np.sqrt(mean)) * factor


def position_at(t_ref: Array, p_ref: Array, t: Array) -> Array:
    """Return reference positions (k, 3) [m] at times ``t`` (k,) [s], linear between samples.

    NaN outside the reference's span and inside its gaps, see ``evaluate.reference.gaps``: none is invented.

    Raises
    ------
    InputError : no reference, or shapes that do not fit.
    """
    if not len(t_ref) or p_ref.shape != (len(t_ref), 3):
        expected = "positions (n, 3) at one time or more"
        raise InputError("reference positions", got=f"{len(t_ref)} times, shape {p_ref.shape}", expected=expected)
    columns = [np.interp(t, t_ref, column, left=np.nan, right=np.nan) for column in p_ref.T]
    out = np.column_stack(columns)
    for start, stop in gaps(t_ref):
        out[(t > start) & (t < stop)] = np.nan
    return out


def evaluate_position(run: Run, truth: Truth, *, skip: float = 0.0) -> Score:
    """Return the position score of a run at its own times, over the whole span of the reference.

    Parameters
    ----------
    run : needs the state block ``p_n`` (n, 3) [m].
    truth : needs ``p_n`` in the same frame.
    skip : seconds left out after the run's first time.

    Returns
    -------
    Score with the values of ``position_figures``.

    Raises
    ------
    InputError : no position in run or truth, or nothing to score.
    """
    p_n = run.state.get("p_n")
    if p_n is None or p_n.shape != (len(run.t), 3):
        got = f"state blocks {', '.join(run.state) or 'none'}" if p_n is None else f"shape {p_n.shape}"
        raise InputError(f"the run of {run.estimator} has no position", got=got, expected=f"p_n ({len(run.t)}, 3)")
    if truth.p_n is None:
        raise InputError("the truth has no position", got="no p_n", expected="p_n (n, 3) in NED")
    reference = position_at(truth.t, truth.p_n, run.t)
    scored = np.isfinite(reference).all(axis=1) & (run.t >= np.min(run.t, initial=np.inf) + skip)
    if not scored.any():
        raise InputError(
            f"nothing to score in the run of {run.estimator}",
            got=f"{len(run.t)} estimates, none with a reference after {skip:g} s",
            expected="at least one estimate with a reference position",
            do="compare the clocks of run and truth, or skip less",
        )
    figures = position_figures(p_n[scored] - reference[scored])
    return Score(
        estimator=run.estimator,
        reference=truth.kind + (f", {truth.accuracy}" if truth.accuracy else ""),
        values=figures,
        samples=int(figures["samples"]),
        notes=(NOT_AN_ERROR,) if truth.kind == "estimate" else (),
    )
