"""The range line and the bias curve on real recordings: the published and measured figures."""

import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.calibrate import (
    LEAST_SQUARES,
    Pairs,
    RangeCalibration,
    RangeLine,
    choose_curve,
    fit_curve,
    fit_line,
    held_out,
)
from robustnav.frames import rotate
from robustnav.logs import read_uwb_hyu_static, read_uwb_lias, read_uwb_lias_sheet

DATA = os.environ.get("ROBUSTNAV_DATA")
UWB = Path(DATA or ".") / "uwb"
pytestmark = pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with uwb/")
KNOTS = (2, 5, 10, 15, 20, 30, 40, 50, 60)
GOLDEN = {  # height: readings, slope, offset, variance of a range, variance of a distance
    "height_50.0cm": (2689, 1.003573, 0.103669, 0.00274730, 0.00272777),
    "height_75.0cm": (2686, 1.004041, 0.096136, 0.00568516, 0.00563949),
    "height_100.0cm": (2686, 1.005234, 0.030025, 0.00207730, 0.00205572),
    "height_150.0cm": (2509, 1.005177, 0.067689, 0.00585658, 0.00579640),
    "height": (10570, 1.004464, 0.075158, 0.00438568, 0.00434678),
}


@pytest.fixture(scope="module")
def static():
    return read_uwb_hyu_static(UWB / "hyu" / "static" / "LOS")


@pytest.fixture(scope="module")
def pairs(static):
    return Pairs(static.distance_true, static.measured, np.array(static.anchor), file=static.file)


@pytest.mark.parametrize("height", GOLDEN)
def test_the_published_line_at_each_height(static, pairs, height):
    here = np.array([name.startswith(height) for name in static.files])[static.file]
    line = fit_line(pairs.where(here), LEAST_SQUARES)
    count, slope, offset, variance, of_distance = GOLDEN[height]
    assert line.fitted.samples == count
    np.testing.assert_allclose([line.slope, line.offset], [slope, offset], atol=6e-7)
    np.testing.assert_allclose([line.range_variance, line.variance], [variance, of_distance], atol=6e-9)


def test_one_gross_error_of_two_metres_at_75_cm(static, pairs):
    here = np.array([name.startswith("height_75") for name in static.files])[static.file]
    line = fit_line(pairs.where(here))
    np.testing.assert_allclose(line.slope, 1.00383, atol=6e-6)
    np.testing.assert_allclose([line.offset, np.sqrt(line.range_variance)], [0.1037, 0.0566], atol=6e-5)
    assert line.fitted.outliers == 1


def test_readings_of_one_file_are_far_from_independent(pairs):
    low, high = fit_line(pairs).intervals()["slope"]
    low_alone, high_alone = fit_line(Pairs(pairs.distance_true, pairs.measured)).intervals()["slope"]
    assert 8 < (high - low) / (high_alone - low_alone) < 11


def test_most_of_what_the_line_calls_noise_is_a_curve(static, pairs):
    bias = pairs.measured - pairs.distance_true
    medians = np.array([np.median(bias[static.file == k]) for k in range(len(static.files))])
    nominal = np.array([float(name.split("/")[1][:-5]) for name in static.files])
    by_tens = [medians[(nominal > low) & (nominal <= low + 10)].mean() for low in range(0, 60, 10)]
    of_all_heights = [0.044, 0.166, 0.235, 0.264, 0.286, 0.291]  # four of thirteen heights are here
    np.testing.assert_allclose(by_tens, of_all_heights, atol=0.02)
    spread = np.median([bias[static.file == k].std() for k in range(len(static.files))])
    np.testing.assert_allclose(spread, 0.025, atol=5e-4)


def test_held_out_by_file(pairs):
    none = np.sqrt(np.mean((pairs.measured - pairs.distance_true) ** 2))
    line = held_out(pairs, lambda p: fit_line(p, LEAST_SQUARES)).rms
    curve = held_out(pairs, lambda p: fit_curve(p, KNOTS), folds=20).rms
    np.testing.assert_allclose([none, line, curve], [0.235, 0.067, 0.053], atol=5e-4)


def test_the_chosen_knots_do_as_well_as_those_chosen_by_hand(pairs):
    choice = choose_curve(pairs)
    assert len(choice.curve.knots) == 5
    assert choice.errors[5].rms < 0.0535


@pytest.fixture(scope="module")
def trolley():
    return read_uwb_lias(
        UWB / "lias_mid" / "UWB_dynamic_exp_mid.csv", UWB / "lias_mid" / "motion_capture_dynamic_exp_mid.csv"
    )


def test_the_sheets_of_the_trolley_belong_to_these_columns(trolley):
    sheet = read_uwb_lias_sheet(UWB / "lias_mid" / "calibration" / "calibration.csv")
    lines = [RangeLine(1 + s, b, sd**2) for s, b, sd in zip(sheet.slope, sheet.bias, sheet.sd, strict=True)]
    keys = list(zip(sheet.anchor, sheet.tag, strict=True))
    ranges, reference = trolley.ranges.where(np.arange(len(trolley.ranges)) % 23 == 0), trolley.reference
    # The authors turn the tags by 7 deg; ranges agree best with motion capture 0.04 s earlier.
    turn = np.radians(-7)
    lever = ranges.lever_b @ np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]).T
    row = np.searchsorted(reference["position"].t, ranges.t - 0.04).clip(0, len(reference["position"]) - 1)
    tag = reference["position"].values[row] + rotate(reference["attitude"].values[row], lever[ranges.tag])
    d = np.linalg.norm(tag - ranges.anchors.p_a[ranges.anchor], axis=1)

    def medians(calibration):
        error = calibration.apply(ranges).distance - d
        return [abs(np.median(error[(ranges.anchor == a) & (ranges.tag == t)])) for a in range(8) for t in range(3)]

    right = np.mean(medians(RangeCalibration("link", dict(zip(keys, lines, strict=True)))))
    wrong = np.mean(medians(RangeCalibration("link", dict(zip(sorted(keys), lines, strict=True)))))
    raw = np.mean(medians(RangeCalibration("all", {(): RangeLine(1.0, 0.0, 1.0)})))
    assert right < 0.04
    assert wrong > 1.5 * right
    assert raw > 0.15
