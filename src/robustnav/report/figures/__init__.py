"""Figures, one idea a file: each function returns a ``Plot``, a matplotlib Figure and its caption."""

from robustnav.report.figures.attitude import attitude
from robustnav.report.figures.bias import bias
from robustnav.report.figures.comparison import Comparison, comparison
from robustnav.report.figures.consistency import consistency_band
from robustnav.report.figures.error import error_band
from robustnav.report.figures.gain import gain_schedule
from robustnav.report.figures.growth import growth
from robustnav.report.figures.innovations import innovations
from robustnav.report.figures.percentiles import percentile_band
from robustnav.report.figures.timeline import timeline

__all__ = [
    "Comparison",
    "attitude",
    "bias",
    "comparison",
    "consistency_band",
    "error_band",
    "gain_schedule",
    "growth",
    "innovations",
    "percentile_band",
    "timeline",
]
