"""Figures and one self-contained page from the numbers of a run."""

from robustnav.report import figures
from robustnav.report.drawing import Plot
from robustnav.report.page import Page, Tile
from robustnav.report.run_report import report, versions
from robustnav.report.verdict import Verdict, innovation_rows, judge

__all__ = ["Page", "Plot", "Tile", "Verdict", "figures", "innovation_rows", "judge", "report", "versions"]
