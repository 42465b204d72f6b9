"""Pages and figures of the ranging verbs."""

import json
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from robustnav.calibrate import Pairs, calibrate_ranges, fit_line
from robustnav.calibrate.bias_curve import fit_curve
from robustnav.errors import InputError
from robustnav.records import Anchors
from robustnav.report.figures.gdop_map import LEVELS, gdop_map
from robustnav.report.figures.residual_ranges import residual_ranges
from robustnav.report.ranging_report import (
    Calibrated,
    calibration_rows,
    corrected,
    layout_verdict,
    shown_calibration,
    write_calibration_report,
    write_layout_report,
)
from robustnav.snapshot import Sensing
from robustnav.survey.layout import Box, Flight, plan_layout

ROOM = Anchors(tuple("ABCDE"), np.array([[0, 0, -2.5], [10, 0, -2.4], [10, 8, -2.5], [0, 8, -2.5], [5, 0, -0.3]]))
FLIGHT = Flight(-1.0, Box(0, 10, 0, 8), 1.0, 0.1, Sensing())


@pytest.fixture
def pairs():
    rng = np.random.default_rng(0)
    d = np.repeat(np.linspace(2, 40, 20), 10)
    anchor = np.tile(["a", "b"], 100)
    r = 1.005 * d + np.where(anchor == "a", 0.05, 0.2) + 0.03 * rng.standard_normal(d.size)
    return Pairs(d, r, anchor=anchor, file=np.repeat(np.arange(20), 10))


def texts(plot):
    return [text.get_text() for text in plot.figure.legends[0].get_texts()]


def test_residuals_before_and_after(pairs):
    calibration = calibrate_ranges(pairs, "anchor")
    after = corrected(pairs, calibration)
    assert np.abs(np.mean(after - pairs.distance_true)) < 0.01 < np.mean(pairs.measured - pairs.distance_true)
    plot = residual_ranges(pairs, after, calibration)
    assert texts(plot) == ["Measured", "Correction a", "Correction b", "±2 sd of a range"]
    before = plot.figure.axes[0].get_lines()[0]
    medians = [np.median((pairs.measured - pairs.distance_true)[pairs.file == k]) for k in range(20)]
    np.testing.assert_allclose(before.get_ydata(), medians)
    bare = Pairs(pairs.distance_true, pairs.measured)
    alone = calibrate_ranges(bare)
    plot = residual_ranges(bare, corrected(bare, alone), alone)
    assert texts(plot)[1] == "Correction" and "each place" in plot.caption


def test_rows_hold_everything_and_shown_ones_are_short(pairs):
    fit = partial(fit_line)
    rows = calibration_rows(Calibrated(pairs, calibrate_ranges(pairs, "anchor", fit), fit))
    assert [row["for"] for row in rows] == ["a", "b"]
    assert rows[0]["slope_interval"][0] < 1.005 < rows[0]["slope_interval"][1]
    assert shown_calibration(rows)[0]["slope_a"] == f"{rows[0]['slope']:.5f}"
    curve = partial(fit_curve, knots=(2.0, 20.0, 40.0))
    shown = shown_calibration(calibration_rows(Calibrated(pairs, calibrate_ranges(pairs, "all", curve), curve)))
    assert shown[0]["bias_at_knots_m"].count(":") == 3


def test_calibration_page_and_numbers(tmp_path, pairs):
    fit = partial(fit_line)
    done = Calibrated(pairs, calibrate_ranges(pairs, "anchor", fit, "made"), fit, ("left out: 1",), "robustnav x")
    page = write_calibration_report(done, tmp_path / "out")
    html = page.read_text()
    assert "left out: 1" in html and "robustnav x" in html and html.count("<svg") == 1
    assert json.loads((page.parent / "results.json").read_text())["corrections"][1]["for"] == "b"
    first = page.read_bytes()
    assert write_calibration_report(done, tmp_path / "out").read_bytes() == first
    with pytest.raises(InputError, match="a file"):
        write_calibration_report(done, page)


def test_map_shades_by_level_and_shows_anchors_from_above():
    plan = plan_layout(ROOM, FLIGHT)
    plot = gdop_map((plan.x, plan.y), plan.dop.gdop, ROOM, "GDOP", plan.extra)
    (axes,) = plot.figure.axes
    low, high = axes.get_ylim()
    assert low > high and axes.get_aspect() == 1.0
    np.testing.assert_array_equal(axes.get_lines()[0].get_xydata(), ROOM.p_a[:, :2])
    assert axes.texts[0].get_text() == "A (2.5 m)"
    shades = [label for label in texts(plot) if " to " in label]
    gdop = plan.dop.gdop
    inside = [f"{a:g} to {b:g}" for a, b in pairwise(LEVELS) if ((gdop >= a) & (gdop < b)).any()]
    assert shades == inside and texts(plot)[-2:] == ["Anchor", "One more helps most"]
    blind = gdop_map((plan.x, plan.y), np.full_like(plan.dop.gdop, np.inf), ROOM, "GDOP")
    assert texts(blind) == ["beyond 50", "Anchor"]


def test_layout_page(tmp_path):
    plan = plan_layout(ROOM, FLIGHT)
    page = write_layout_report(ROOM, plan, FLIGHT, tmp_path / "out", "robustnav gdop x")
    html = page.read_text()
    assert html.count("<svg") == 4 and "One more anchor helps most" in html and "robustnav gdop x" in html
    known = Flight(-1.0, Box(0, 10, 0, 8), 1.0, 0.1, Sensing(height_known=True))
    page = write_layout_report(ROOM, plan_layout(ROOM, known), known, tmp_path / "known")
    assert "VDOP" not in page.read_text() and page.read_text().count("<svg") == 3


def test_a_mirrored_layout_is_no_success():
    ceiling = Anchors(tuple("ABCD"), ROOM.p_a[:4] * [1, 1, 0] + [0, 0, -2.5])
    level, words = layout_verdict(plan_layout(ceiling, FLIGHT), FLIGHT)
    assert level == "error" and "mirrors the tag" in words
