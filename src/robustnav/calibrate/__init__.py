"""Sensor calibration from recordings: the errors of ranges, as lines or curves, by anchor or link."""

from robustnav.calibrate.bias_curve import BiasCurve, KnotChoice, choose_curve, fit_curve
from robustnav.calibrate.calibration_file import read_calibration, write_calibration
from robustnav.calibrate.held_out import HeldOut, held_out
from robustnav.calibrate.pairs import Pairs
from robustnav.calibrate.range_line import Fitted, RangeLine, fit_line
from robustnav.calibrate.ranges import RangeCalibration, calibrate_ranges
from robustnav.calibrate.robust import HUBER, LEAST_SQUARES, STUDENT_T, Loss
from robustnav.calibrate.time_offset import TimeOffset, offset_of_positions, offset_of_ranges
from robustnav.calibrate.time_offset_fit import OffsetOptions

__all__ = [
    "HUBER",
    "LEAST_SQUARES",
    "STUDENT_T",
    "BiasCurve",
    "Fitted",
    "HeldOut",
    "KnotChoice",
    "Loss",
    "OffsetOptions",
    "Pairs",
    "RangeCalibration",
    "RangeLine",
    "TimeOffset",
    "calibrate_ranges",
    "choose_curve",
    "fit_curve",
    "fit_line",
    "held_out",
    "offset_of_positions",
    "offset_of_ranges",
    "read_calibration",
    "write_calibration",
]
