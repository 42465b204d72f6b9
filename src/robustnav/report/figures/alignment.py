"""An initial alignment over time: misalignment of several methods, existence of the H-infinity filter, the wind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from robustnav.frames import Array
from robustnav.records import BoolArray
from robustnav.report.drawing import Plot, band, caption, trace
from robustnav.report.figures.courses import error_courses
from robustnav.report.style import BAND_ALPHA, CYCLE, MUTED, REFERENCE, add_legend, label_time, label_value, new_figure
from robustnav.units import ARCMIN, DEG, MILLI_G


class RateUnit(NamedTuple):
    """A unit to show a rate in: its name, and its size [rad/s]."""

    name: str
    size: float


def tilt_courses(t: Array, middle: Mapping[str, Array], high: Mapping[str, Array], words: str) -> Plot:
    """Draw the tilt of several methods: above the median over runs, below the 95th percentile.

    Parameters
    ----------
    t : (n,) times [s].
    middle, high : by method (n,) [arcmin], positive; NaN where it said nothing.
    words : what was run, for the caption.
    """
    return error_courses(t, middle, high, "tilt, arcmin", words)


def misalignment(t: Array, tilt: Array, sd: Array, name: str, limit_arcmin: float = 30.0) -> Plot:
    """Draw misalignment about north and east of one run with twice the standard deviation the filter claims.

    Parameters
    ----------
    t : (n,) times [s].
    tilt : (n, 2) about north and east [rad].
    sd : (n,) of one axis [rad].
    name : of the method.
    limit_arcmin : larger values are not drawn.
    """
    figure, axes = new_figure(2, row_in=1.8)
    bound = np.minimum(2 * sd / ARCMIN, 2 * limit_arcmin)
    fewer = False
    for one, values, label in zip(axes, tilt.T / ARCMIN, ("North, arcmin", "East, arcmin"), strict=True):
        fewer |= band(one, t, -bound, bound, "2 sd claimed")
        fewer |= trace(one, t, values, label=name, color=CYCLE[0], linewidth=1.2)
        one.set_ylim(-limit_arcmin, limit_arcmin)
        label_value(one, label)
    label_time(axes[-1])
    add_legend(figure, axes[0])
    words = f"Misalignment of {name} in one run; axes end at {limit_arcmin:g} arcmin."
    return Plot(figure, caption([words], fewer))


def existence(t: Array, margin: Array, words: str) -> Plot:
    """Draw the existence margin (n,) of an H-infinity filter: it exists where the margin is above zero."""
    figure, (axes,) = new_figure(1, row_in=1.8)
    fewer = trace(axes, t, 1 - margin, label="1 - margin", color=CYCLE[0], linewidth=1.2)
    axes.axhline(1.0, color=REFERENCE, linestyle="--", linewidth=1.0, label="No filter at and above")
    axes.set_yscale("log")
    label_value(axes, "1 - margin")
    label_time(axes)
    add_legend(figure, axes)
    return Plot(figure, caption([words], fewer))


def disturbance(t: Array, true: Array, found: Array, words: str) -> Plot:
    """Draw a velocity disturbance north and east, ``true`` and ``found`` (n, 2) [m/s]."""
    figure, axes = new_figure(2, row_in=1.6)
    fewer = False
    for k, (one, label) in enumerate(zip(axes, ("North, m/s", "East, m/s"), strict=True)):
        fewer |= trace(one, t, true[:, k], label="True", color=REFERENCE, linewidth=1.0)
        said = ~np.isnan(found[:, k])
        fewer |= trace(one, t[said], found[said, k], label="Estimated", color=CYCLE[1], linestyle="--", linewidth=1.2)
        label_value(one, label)
    label_time(axes[-1])
    add_legend(figure, axes[0])
    return Plot(figure, caption([words], fewer))


def tilt_radius(t: Array, radius: Array, goal: float, error: Array | None = None) -> Plot:
    """Draw the radius within which tilt is claimed to be.

    Parameters
    ----------
    t : (n,) times [s].
    radius : (n,) 95 % [rad]; NaN where nothing was said.
    goal : [rad]; NaN: none.
    error : (n,) size of the true error [rad], NaN where there is no truth.
    """
    figure, (axes,) = new_figure(1, row_in=2.6)
    said = ~np.isnan(radius)
    fewer = trace(axes, t[said], radius[said] / ARCMIN, label="Claimed, 95 %", color=CYCLE[0], linewidth=1.4)
    words = ["Radius within which the tilt is with 95 %."]
    if error is not None:
        known = said & ~np.isnan(error)
        fewer |= trace(axes, t[known], error[known] / ARCMIN, label="True error", color=REFERENCE, linewidth=0.9)
        share = 100 * float(np.mean(error[known] <= radius[known])) if known.any() else float("nan")
        words.append(
            f"The true error is within it in {share:.1f} % of the readings; neighbouring ones are not independent."
        )
    if not np.isnan(goal):
        words_of_goal = f"Goal, {goal / ARCMIN:g} arcmin"
        axes.axhline(goal / ARCMIN, color=CYCLE[1], linestyle="--", linewidth=1.2, label=words_of_goal)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")
    label_value(axes, "Tilt, arcmin")
    label_time(axes)
    add_legend(figure, axes)
    return Plot(figure, caption(words, fewer))


def heading_course(t: Array, heading: Array, sd: Array, observable: BoolArray, true: Array | None = None) -> Plot:
    """Draw the heading with two standard deviations, and shade where it is not observable.

    Parameters
    ----------
    t : (n,) times [s].
    heading, sd : (n,) [rad]; NaN where nothing was said.
    observable : (n,).
    true : (n,) [rad], NaN where there is no truth.
    """
    figure, (axes,) = new_figure(1, row_in=2.6)
    near, middle, fewer = np.full(len(t), np.nan), 0.0, False
    if observable.any():
        middle = heading[observable][-1] / DEG
        turned = np.unwrap(heading[observable]) / DEG  # no jump at half a turn
        near[observable] = turned - turned[-1] + middle
    for first, after in _runs(~observable):
        edges = t[first], t[min(after, len(t) - 1)]
        axes.axvspan(*edges, color=MUTED, alpha=BAND_ALPHA, linewidth=0, label="Not observable")
    if observable.any():
        seen, wide = near[observable], 2 * sd[observable] / DEG
        fewer |= band(axes, t[observable], seen - wide, seen + wide, "±2 sd claimed")
        fewer |= trace(axes, t[observable], seen, color=CYCLE[0], linewidth=1.2, label="Estimate")
    if true is not None and not np.isnan(true).all():
        known = ~np.isnan(true)
        truth = np.unwrap(true[known]) / DEG
        truth += 360.0 * np.round((middle - truth[-1]) / 360.0)
        fewer |= trace(axes, t[known], truth, label="True", color=REFERENCE, linewidth=1.0)
    axes.set_xlim(t[0], t[-1])
    half = _heading_half(near, sd / DEG) if observable[-1] else 190.0
    axes.set_ylim(middle - half, middle + half)
    label_value(axes, "Heading, deg")
    label_time(axes)
    add_legend(figure, axes)
    words = ["Heading of the forward axis, where it is observable."]
    return Plot(figure, caption(words + ["It never is."] * (not observable.any()), fewer))


def wind_course(t: Array, reference: Array, found: Array, true: Array | None = None) -> Plot:
    """Draw readings of the reference velocity and the disturbance found in them, north and east.

    Parameters
    ----------
    t : (n,) times [s].
    reference, found : (n, 2) [m/s]; NaN where missing.
    true : (n, 2) what disturbed the reference [m/s].
    """
    figure, axes = new_figure(2, row_in=1.7)
    beyond, fewer = np.zeros(len(t), bool), False
    for k, (one, label) in enumerate(zip(axes, ("North, m/s", "East, m/s"), strict=True)):
        middle = float(np.nanmedian(found[:, k]))
        half = 1.6 * float(np.nanmax(np.abs(found[:, k] - middle))) + 0.2  # gusts would make everything else small
        beyond |= np.abs(reference[:, k] - middle) > half
        one.plot(t, reference[:, k], ".", markersize=2.5, color=MUTED, label="Readings")
        if true is not None:
            fewer |= trace(one, t, true[:, k], label="True", color=REFERENCE, linewidth=1.0)
        said = ~np.isnan(found[:, k])
        fewer |= trace(one, t[said], found[said, k], label="Found", color=CYCLE[1], linewidth=1.2)
        one.set_ylim(middle - half, middle + half)
        label_value(one, label)
    label_time(axes[-1])
    add_legend(figure, axes[0])
    words = ["Reference velocity and what of it is disturbance and not noise."]
    return Plot(figure, caption([*words, f"{beyond.sum()} readings lie beyond the axes." * bool(beyond.any())], fewer))


def bias_courses(t: Array, gyro: tuple[Array, Array | None], accel: tuple[Array, Array | None], unit: RateUnit) -> Plot:
    """Draw gyro and accelerometer biases over time.

    Parameters
    ----------
    t : (n,) times [s].
    gyro, accel : estimate (n, 3) [rad/s], [m/s^2], and the truth where it is known.
    unit : of the gyro's axis.
    """
    figure, axes = new_figure(2, row_in=1.9)
    fewer, true = False, False
    parts = ((gyro, unit.size, f"Gyro bias, {unit.name}"), (accel, MILLI_G, "Accelerometer bias, mg"))
    for one, ((found, known), size, label) in zip(axes, parts, strict=True):
        said = ~np.isnan(found[:, 0])
        for k, axis in enumerate("xyz"):
            fewer |= trace(one, t[said], found[said, k] / size, label=axis, color=CYCLE[k], linewidth=1.2)
            if known is not None:
                true = True
                fewer |= trace(one, t, known[:, k] / size, color=CYCLE[k], linestyle="--", linewidth=0.9)
        label_value(one, label)
    label_time(axes[-1])
    figure.align_ylabels(axes)
    add_legend(figure, axes[0])
    return Plot(figure, caption(["Biases found, the true ones dashed." if true else "Biases found."], fewer))


def _runs(where: BoolArray) -> list[tuple[int, int]]:
    """Return first and one past the last index of each run of true values."""
    edges = np.flatnonzero(np.diff(where.astype(int), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _heading_half(near: Array, sd: Array) -> float:
    """Return how far the axis goes to either side: to show the last half, and no less than what is claimed there."""
    half = slice(len(near) // 2, None)
    return 1.3 * float(np.nanmax(np.abs(near[half] - near[-1]) + 2 * sd[half]))
