"""How the gain of a fixed-gain filter runs down to its final value."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import CYCLE, add_legend, label_time, label_value, new_figure

MAX_ENTRIES = 12
LINES = ("-", "--")


def gain_schedule(t: Array, gains: Array, states: Sequence[str], readings: Sequence[str]) -> Plot:
    """Draw the size of the gain's entries against time, both logarithmic; each set holds until the next.

    Parameters
    ----------
    t : (k,) seconds since the start at which each set begins.
    gains : (k, n, m) gain sets.
    states, readings : names of the n corrected states and of the m readings.

    Raises
    ------
    InputError : shapes and names do not fit, or fewer than two times.
    """
    if gains.shape != (len(t), len(states), len(readings)) or len(t) < 2:
        raise InputError(
            "gain schedule",
            got=f"gains of shape {gains.shape}, {len(t)} times",
            expected=f"shape ({len(t)}, {len(states)}, {len(readings)}), two times or more",
        )
    figure, (axes,) = new_figure(1, row_in=3.4)
    sizes = np.abs(gains)
    largest = np.argsort(-sizes[-1], axis=None, kind="stable")[:MAX_ENTRIES]
    entries = [(int(k) // len(readings), int(k) % len(readings)) for k in largest]
    drawn = [(i, j) for i, j in entries if sizes[:, i, j].any()]
    # Zero has no logarithm: the first set is drawn from half the time of the second.
    since = np.where(t > 0, t, t[1] / 2)
    for k, (i, j) in enumerate(drawn):
        held = np.where(sizes[:, i, j] > 0, sizes[:, i, j], np.nan)
        axes.step(
            np.append(since, 2 * since[-1]),
            np.append(held, held[-1]),
            where="post",
            color=CYCLE[k % len(CYCLE)],
            linestyle=LINES[k // len(CYCLE)],
            label=f"{states[i]} ← {readings[j]}",
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    label_value(axes, "Size of gain entry, SI")
    label_time(axes)
    add_legend(figure, axes)
    left_out = int(np.count_nonzero(sizes.any(axis=0))) - len(drawn)
    words = [
        f"Gain schedule of {len(t)} sets.",
        f"Entries that end smallest, not drawn: {left_out}." if left_out else "",
    ]
    return Plot(figure, caption(words, False))
