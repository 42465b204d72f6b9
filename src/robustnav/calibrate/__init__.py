"""Sensor calibration from recordings: the errors of ranges, as lines or curves, by anchor or link."""

from robustnav.calibrate.bias_curve import BiasCurve, KnotChoice, choose_curve, fit_curve
from robustnav.calibrate.calibration_file import read_calibration, write_calibration
from robustnav.calibrate.held_out import HeldOut, held_out
from robustnav.calibrate.pairs import Pairs
from robustnav.calibrate.range_line import Fitted, RangeLine, fit_line
from robustnav.calibrate.ranges import RangeCalibration, calibrate_ranges
from robustnav.calibrate.robust import HUBER, LEAST_SQUARES, STUDENT_T, Loss

__all__ = [
    "HUBER",
    "LEAST_SQUARES",
    "STUDENT_T",
    "BiasCurve",
    "Fitted",
    "HeldOut",
    "KnotChoice",
    "Loss",
    "Pairs",
    "RangeCalibration",
    "RangeLine",
    "calibrate_ranges",
    "choose_curve",
    "fit_curve",
    "fit_line",
    "held_out",
    "read_calibration",
    "write_calibration",
]
