"""What heading a base at rest gives: found, claimed, possible, over gyro grades."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from robustnav.report.drawing import Plot
from robustnav.report.style import CYCLE, ESTIMATE, INK, MUTED, add_legend, label_value, new_figure

MARKS = ("o", "s", "D", "^", "v")


def heading_by_grade(cases: Sequence[str], values: Mapping[str, Sequence[float]], bound: str, words: str) -> Plot:
    """Draw heading errors [deg] of cases side by side on a logarithmic axis.

    Parameters
    ----------
    cases : names along the horizontal axis.
    values : by name, one a case.
    bound : the name that is drawn as a bar to stand on.
    words : the caption.
    """
    figure, (axes,) = new_figure(1, row_in=2.8)
    places = range(len(cases))
    axes.bar(places, values[bound], width=0.7, color=MUTED, alpha=0.25, label=bound)
    others = [name for name in values if name != bound]
    for k, name in enumerate(others):
        colour = ESTIMATE if k == 0 else CYCLE[k % len(CYCLE)]
        aside = [place + 0.14 * (k - (len(others) - 1) / 2) for place in places]
        axes.plot(aside, values[name], MARKS[k % len(MARKS)], color=colour, markersize=6, label=name)
    axes.set_yscale("log")
    axes.set_xlim(-0.5, len(cases) - 0.5)
    axes.set_xticks(list(places), cases, color=INK)
    label_value(axes, "Heading, deg")
    add_legend(figure, axes)
    return Plot(figure, words)
