"""Several estimators side by side, with the bound no estimator can beat and published figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import BOUND, CYCLE, INK, SMALL_PT, add_legend, label_value, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GROUP = 0.8  # share of a group's width that its bars fill


@dataclass(frozen=True)
class Comparison:
    """Figures of several estimators.

    Parameters
    ----------
    groups : what each figure is of, e.g. roll, pitch, yaw.
    rms : by estimator, one figure a group, NaN where it has none.
    bound : one figure a group, or None.
    published : by estimator, one figure a group; may be empty.
    unit : of all figures.
    """

    groups: Sequence[str]
    rms: Mapping[str, Sequence[float]]
    bound: Sequence[float] | None = None
    published: Mapping[str, Sequence[float]] = field(default_factory=dict)
    unit: str = "deg"

    def __post_init__(self) -> None:
        for name, figures in [*self.rms.items(), *self.published.items(), ("the bound", self.bound or self.groups)]:
            if len(figures) != len(self.groups):
                raise InputError(
                    f"comparison, {name}", got=f"{len(figures)} figures", expected=f"{len(self.groups)}, one a group"
                )


def comparison(data: Comparison) -> Plot:
    """Draw one bar an estimator and group, the bound as a line across, published figures as diamonds."""
    figure, (axes,) = new_figure(1, row_in=3.2)
    width = GROUP / max(len(data.rms), 1)
    middle = np.arange(float(len(data.groups)))
    for k, (name, figures) in enumerate(data.rms.items()):
        at = middle + (k + 0.5) * width - GROUP / 2
        axes.bar(at, np.nan_to_num(figures), 0.92 * width, color=CYCLE[k % len(CYCLE)], label=name)
        _write(axes, at, figures)
        if name in data.published:
            label = "Published" if name == next(iter(data.published)) else "_"
            style: dict[str, Any] = {
                "marker": "D",
                "linestyle": "none",
                "markerfacecolor": "white",
                "color": INK,
                "markersize": 6,
            }
            axes.plot(at, data.published[name], label=label, **style)
    if data.bound is not None:
        axes.hlines(data.bound, middle - GROUP / 2, middle + GROUP / 2, color=BOUND, linestyle="--", label="Bound")
    axes.set_xticks(middle, list(data.groups))
    axes.tick_params(axis="x", length=0)
    axes.grid(False, axis="x")
    axes.margins(x=0.03, y=0.12)
    label_value(axes, f"RMS error, {data.unit}")
    add_legend(figure, axes)
    bound = "The dashed line is the bound that no estimator can beat on average." if data.bound is not None else ""
    return Plot(figure, caption([f"RMS error of {', '.join(data.rms)}.", bound], False))


def _write(axes: Axes, at: Array, figures: Sequence[float]) -> None:
    for place, figure in zip(at, figures, strict=True):
        text = f"{figure:.3g}" if np.isfinite(figure) else "none"
        height = figure if np.isfinite(figure) else 0.0
        axes.annotate(
            text,
            (place, height),
            (0, 4),
            textcoords="offset points",
            ha="center",
            fontsize=SMALL_PT,
            color=INK,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},  # the bound's line may cross it
            zorder=4,
        )
