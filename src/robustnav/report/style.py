"""The one place for colours, type sizes and figure sizes, on the page and in the figures.

The colours of data are those of Okabe and Ito, which readers with any colour vision can tell apart.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from robustnav.errors import MissingExtra

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#1b2733"
MUTED = "#5b6b7a"
GRID = "#e4e9ee"

BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = "#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00", "#56B4E9"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
ESTIMATE, REFERENCE, REFUSED, BOUND, BAND = BLUE, INK, VERMILION, INK, SKY
BAND_ALPHA = 0.25

WIDTH_IN = 8.0
ROW_IN = 1.45
MARGIN_IN = 0.85  # for the time axis and the legend
TEXT_PT, SMALL_PT = 9.5, 8.5
LEGEND_LINE = 60  # letters that fit beside five keys


def new_figure(rows: int, *, row_in: float = ROW_IN) -> tuple[Figure, list[Axes]]:
    """Return an empty figure of ``rows`` plots under each other with one common horizontal axis.

    Raises
    ------
    MissingExtra : matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as why:
        raise MissingExtra("matplotlib", "report") from why
    figure = Figure(figsize=(WIDTH_IN, rows * row_in + MARGIN_IN), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    axes = list(figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0])
    for one in axes:
        _restrain(one)
    return figure, axes


def label_time(axes: Axes) -> None:
    """Name the time axis."""
    axes.set_xlabel("Time, s", fontsize=TEXT_PT, color=INK)


def label_value(axes: Axes, text: str) -> None:
    """Name the value axis."""
    axes.set_ylabel(text, fontsize=TEXT_PT, color=INK)


def add_legend(figure: Figure, axes: Axes) -> None:
    """Put one legend for the whole figure above the plots, where it can hide no data."""
    handles, labels = axes.get_legend_handles_labels()
    first = dict(zip(reversed(labels), reversed(handles), strict=True))  # one entry a label
    labels = list(dict.fromkeys(labels))
    columns = 5 if sum(map(len, labels)) < LEGEND_LINE else 4
    style = {"frameon": False, "fontsize": TEXT_PT, "labelcolor": INK, "columnspacing": 1.4, "handlelength": 1.8}
    figure.legend([first[label] for label in labels], labels, loc="outside upper left", ncols=columns, **style)


def _restrain(axes: Axes) -> None:
    axes.grid(True, color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=SMALL_PT, colors=MUTED, labelcolor=INK, length=3)
    axes.margins(x=0.0)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(MUTED)
