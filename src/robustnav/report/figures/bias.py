"""Estimated sensor biases and how sure the filter is of them."""

from __future__ import annotations

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Run
from robustnav.report.drawing import Plot, axis_names, band, caption, shown_in, trace
from robustnav.report.style import ESTIMATE, add_legend, label_time, label_value, new_figure

UNITS = {"gyro_bias": "rad/s", "accel_bias": "m/s^2", "mag_bias": "T"}


def bias(run: Run, block: str = "gyro_bias") -> Plot:
    """Draw a bias block with three standard deviations.

    Raises
    ------
    InputError : the run has no such block.
    """
    if block not in run.state:
        raise InputError(f"no state block {block!r}", got=", ".join(run.state) or "none", expected="a bias of the run")
    unit, factor = shown_in(UNITS.get(block, "SI"))
    values, sd = run.state[block] / factor, run.sd.get(block)
    figure, rows = new_figure(values.shape[1])
    fewer = False
    for k, (axes, name) in enumerate(zip(rows, axis_names(values.shape[1]), strict=True)):
        fewer |= trace(axes, run.t, values[:, k], color=ESTIMATE, linewidth=1.0, label="Estimate")
        if sd is not None:
            low, high = axes.get_ylim()
            claimed = 3 * sd[:, k] / factor
            edges = values[:, k] - claimed, values[:, k] + claimed
            fewer |= band(axes, run.t, *edges, "±3 standard deviations claimed")
            # The claim at the start may be hundreds of times wider than the estimate ever moves.
            settled = 1.5 * float(np.nanmedian(claimed))
            axes.set_ylim(min(low, values[-1, k] - settled), max(high, values[-1, k] + settled))
        label_value(axes, f"{name}, {unit}")
    label_time(rows[-1])
    figure.align_ylabels(rows)
    add_legend(figure, rows[0])
    return Plot(figure, caption([f"{block.replace('_', ' ').capitalize()} estimated by {run.estimator}."], fewer))
