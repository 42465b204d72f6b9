import subprocess
import sys

import numpy as np
import pytest

from robustnav.errors import InputError, MissingExtra
from robustnav.evaluate import attitude_errors
from robustnav.evaluate.attitude import NOT_AN_ERROR
from robustnav.records import Innovations, Stream
from robustnav.report import figures
from robustnav.report.drawing import trace
from robustnav.report.style import new_figure


def lines(plot, row=0):
    return plot.figure.axes[row].get_lines()


def labels(plot):
    return [text.get_text() for text in plot.figure.legends[0].get_texts()]


def drawn(line):
    return np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)


def test_attitude_is_in_degrees_and_the_wrap_of_yaw_breaks_the_line(make_sample):
    run, truth, _ = make_sample()
    plot = figures.attitude(run, truth)
    assert labels(plot) == ["Reference (optical)", "MEKF"]
    roll = drawn(lines(plot)[0])[1]
    assert np.nanmax(roll) == pytest.approx(np.degrees(0.5), rel=1e-3)
    assert np.nanmax(drawn(lines(plot)[1])[1]) == pytest.approx(np.degrees(0.5), rel=0.1)
    yaw = drawn(lines(plot, 2)[0])[1]
    assert np.isnan(yaw).sum() == 1 and np.nanmax(np.abs(np.diff(yaw))) < 10
    assert "another estimator" not in plot.caption
    other = make_sample(kind="estimate")
    assert NOT_AN_ERROR in figures.attitude(other[0], other[1]).caption
    assert labels(figures.attitude(run)) == ["MEKF"]


def test_error_band_states_the_share_inside_from_all_data(make_sample):
    run, truth, _ = make_sample(n=6000)
    error = attitude_errors(run, truth).rotvec_n
    plot = figures.error_band(run.t, error, run.sd["q_nb"])
    share = 100 * np.mean(np.abs(error) <= 0.03)
    assert f"{share:.1f} % of the values" in plot.caption and "decimated" in plot.caption
    assert max(len(drawn(line)[0]) for line in lines(plot)) <= 2000
    small = figures.error_band(run.t[:10], error[:10])
    assert small.caption == "Attitude error."
    late = np.where(run.t[:, None] < 20, np.nan, error)
    assert figures.error_band(run.t, late).figure.axes[0].get_xlim() == (run.t[0], run.t[-1])
    nothing = figures.error_band(run.t[:10], error[:10] * np.nan, run.sd["q_nb"][:10])
    assert "no sample" in nothing.caption


def test_a_wide_start_does_not_flatten_the_error(make_sample):
    run, truth, _ = make_sample()
    sd = run.sd["q_nb"].copy()
    sd[:10] = 10.0
    plot = figures.error_band(run.t, attitude_errors(run, truth).rotvec_n, sd)
    assert plot.figure.axes[0].get_ylim()[1] < 5.0


def test_refused_readings_are_marked_and_far_ones_drawn_at_the_edge():
    t = np.arange(100.0)
    z = np.random.default_rng(0).normal(size=(100, 2))
    z[7], z[8], z[9, 1] = 1000.0, 5.0, np.nan
    used = ~np.isin(np.arange(100), [7, 8, 9])
    data = Innovations(t, z * 1e-6, np.full(z.shape, 1e-12), (z**2).sum(axis=1), used)
    plot = figures.innovations("mag", data, "T")
    assert "100 readings, 2 refused, 1 missing. Values beyond the plot, drawn at its edge: 2." in plot.caption
    (refused,) = [line for line in lines(plot) if line.get_label() == "Refused"]
    at, values = drawn(refused)
    assert refused.get_marker() == "x" and at[:2].tolist() == [7, 8] and values[1] == pytest.approx(5.0)
    assert 0 < values[0] <= plot.figure.axes[0].get_ylim()[1]
    assert plot.figure.axes[0].get_ylabel() == "1, µT"


def test_constant_gain_filters_have_no_band():
    t = np.arange(20.0)
    z = np.ones((20, 3))
    plot = figures.innovations("accel", Innovations(t, z, z * np.nan, t * np.nan, t >= 0), "m/s^2")
    assert labels(plot) == ["Used"]


def test_consistency_says_what_is_inside():
    values = np.random.default_rng(0).chisquare(6, size=(50, 300))
    plot = figures.consistency_band(np.arange(300.0), values, 6)
    assert "averaged over 50 runs" in plot.caption and "expected 6" in plot.caption
    values[3, 4] = np.nan
    assert "counted as outside: 1." in figures.consistency_band(np.arange(300.0), values, 6).caption


def test_bias_is_shown_in_its_unit(make_sample):
    run, _, _ = make_sample()
    plot = figures.bias(run)
    assert plot.figure.axes[0].get_ylabel() == "x, deg/s"
    assert drawn(lines(plot)[0])[1][0] == pytest.approx(np.degrees(0.002))
    with pytest.raises(InputError, match="no state block 'accel_bias'"):
        figures.bias(run, "accel_bias")


def test_timeline_names_gaps_and_rates():
    t = np.r_[np.arange(0, 10, 0.1), np.arange(12, 20, 0.1)]
    streams = [Stream("gyro", np.arange(0, 20, 0.1), np.zeros((200, 3)), "rad/s"), Stream("mag", t, t[:, None], "T")]
    plot = figures.timeline(streams)
    assert plot.caption == "Samples of each stream over time. Gaps in mag: 1, the longest 2.1 s."
    assert labels(plot) == ["Samples", "Gap"]
    assert [text.get_text() for text in plot.figure.axes[0].get_yticklabels()] == [
        "gyro  10 Hz",
        "mag  8.995 Hz",
    ]
    assert "no gaps" in figures.timeline(streams[:1]).caption


def test_a_visible_gap_breaks_the_line():
    _, (axes,) = new_figure(1)
    t = np.r_[np.arange(0, 10, 0.001), np.arange(12, 20, 0.001)]
    assert trace(axes, t, np.sin(t))
    at, values = drawn(axes.get_lines()[0])
    hole = np.flatnonzero(np.isnan(values))
    assert len(hole) == 1 and at[hole[0] - 1] < 10 <= 12 <= at[hole[0] + 1]


def test_gain_schedule_draws_the_entries_that_are_not_zero():
    t = np.array([0.0, 1.0, 10.0])
    gains = np.zeros((3, 2, 2))
    gains[:, 0, 1], gains[:, 1, 0] = [1, 0.5, 0.1], [-2, -1, -0.5]
    plot = figures.gain_schedule(t, gains, ["tilt", "bias"], ["accel", "mag"])
    assert labels(plot) == ["bias ← accel", "tilt ← mag"]
    assert drawn(lines(plot)[0])[0][0] == 0.5  # zero seconds have no logarithm
    many = figures.gain_schedule(t, np.ones((3, 4, 4)), list("abcd"), list("wxyz"))
    assert "not drawn: 4." in many.caption and len(lines(many)) == 12
    with pytest.raises(InputError, match="gain schedule"):
        figures.gain_schedule(t, gains, ["tilt"], ["accel", "mag"])


def test_comparison_puts_bound_and_published_figures_beside_the_bars():
    data = figures.Comparison(
        ("Roll", "Yaw"), {"H2": (0.03, 0.11), "EKF": (0.05, np.nan)}, bound=(0.02, 0.1), published={"EKF": (0.06, 0.2)}
    )
    plot = figures.comparison(data)
    assert sorted(labels(plot)) == ["Bound", "EKF", "H2", "Published"]
    assert {text.get_text() for text in plot.figure.axes[0].texts} == {"0.03", "0.11", "0.05", "none"}
    heights = [bar.get_height() for bar in plot.figure.axes[0].patches]
    assert heights == [0.03, 0.11, 0.05, 0.0]
    with pytest.raises(InputError, match="comparison, H2"):
        figures.Comparison(("Roll",), {"H2": (0.03, 0.11)})
    with pytest.raises(InputError, match="the bound"):
        figures.Comparison(("Roll",), {"H2": (0.03,)}, bound=(1.0, 2.0))


def test_percentile_band_counts_failed_runs():
    t = np.arange(50.0)
    values = np.arange(101.0)[:, None] * np.ones(50)
    values[3, 7] = np.nan
    plot = figures.percentile_band(t, values, "Error, deg", log=True)
    assert "of 100 runs. Runs left out for a NaN: 1." in plot.caption
    median = next(line for line in lines(plot) if line.get_label() == "Median")
    assert drawn(median)[1][0] == pytest.approx(np.median(np.delete(np.arange(101.0), 3)))
    with pytest.raises(InputError, match="all with NaN"):
        figures.percentile_band(t, values * np.nan, "Error, deg")


def test_figures_leave_no_global_state_and_need_no_pyplot():
    code = (
        "import sys, matplotlib, numpy as np\n"
        "from robustnav.report import figures\nfrom robustnav.report.page import Page\n"
        "before = matplotlib.rcParams.copy()\n"
        "page = Page('t')\n"
        "page.figure(figures.percentile_band(np.arange(9.0), np.ones((3, 9)), 'e'))\n"
        "page.html()\n"
        "sys.exit(matplotlib.rcParams.copy() != before or 'matplotlib.pyplot' in sys.modules)\n"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_without_matplotlib_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtra, match=r"robustnav\[report\]"):
        new_figure(1)


def test_growth_shows_who_diverges_on_a_logarithmic_axis():
    t = np.linspace(0.0, 10.0, 50)
    plot = figures.growth(t, {"holds": np.full(50, 0.03), "diverges": 0.03 * np.exp(t)}, "Two filters.")
    assert plot.figure.axes[0].get_yscale() == "log"
    assert labels(plot) == ["holds", "diverges"]
    np.testing.assert_allclose(drawn(lines(plot)[1])[1][-1], 0.03 * np.exp(10.0))
    assert plot.caption.startswith("Two filters.")
