"""The page, the numbers and the table of one alignment."""

import csv
import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import euler_from_quat, quat_from_euler
from robustnav.report.alignment_course import Against, Aligned, angle_rows, bias_rows, judge, truth_row
from robustnav.report.alignment_report import alignment_table, document, page, write_alignment
from robustnav.report.figures.alignment import heading_course, tilt_radius, wind_course
from robustnav.units import ARCMIN, DEG, DEG_PER_HOUR, DPS, MILLI_G

N = 300


@dataclass(frozen=True)
class Said:
    t: np.ndarray
    q_nb: np.ndarray
    tilt_radius: np.ndarray
    heading: np.ndarray
    heading_sd: np.ndarray
    heading_observable: np.ndarray
    gyro_bias: np.ndarray
    accel_bias: np.ndarray
    wind: np.ndarray
    tilt_goal: float = 10 * ARCMIN
    aligned_at: float = 112.0


def course(**changes):
    t = 100.0 + 0.1 * np.arange(1, N + 1)
    heading = np.full(N, 3.1)
    nothing = np.arange(N) < 19
    said = Said(
        t=t,
        q_nb=quat_from_euler(np.stack([np.full(N, 0.02), np.full(N, np.pi / 3), heading], axis=1)),
        tilt_radius=np.where(nothing, np.nan, 60 * ARCMIN * np.exp(-(t - 100) / 6)),
        heading=np.where(nothing, np.nan, heading),
        heading_sd=np.where(nothing, np.nan, 0.01),
        heading_observable=np.arange(N) > 100,
        gyro_bias=np.tile([1.0, 2.0, 3.0], (N, 1)) * DEG_PER_HOUR,
        accel_bias=np.tile([0.1, 0.2, 0.3], (N, 1)) * MILLI_G,
        wind=np.stack([2 + np.sin(t), np.cos(t)], axis=1),
    )
    return replace(said, **changes)


def truth(tilt=0.2 * ARCMIN):
    known = np.where(np.arange(N) < 150, np.nan, 1.0)
    return Against(tilt * known, 3.09 * known, -0.01 * known, np.zeros((N, 3)), np.zeros((N, 3)), np.zeros((N, 2)))


def made(said=None, **changes):
    reference = np.random.default_rng(0).standard_normal((N, 2))
    reference[::3] = np.nan
    run = Aligned("mooring.csv", course() if said is None else said, reference, 1 * DEG_PER_HOUR, 0.1, 1e-5)
    return replace(run, command="robustnav align mooring.csv", settings={"imu": "made", "period_s": 0.1}, **changes)


def test_an_alignment_is_judged_by_its_goal_and_by_the_truth():
    level, text, reasons = judge(made())
    assert level == "ok" and not reasons
    assert "aligned after 12.0 s" in text and "heading 177.62 deg, within 1.12 deg" in text
    level, text, reasons = judge(made(course(aligned_at=float("nan"), tilt_radius=np.full(N, 2 * DEG))))
    assert level == "error" and "never aligned: after 30.0 s tilt is within 2 deg" in text and reasons
    level, _, reasons = judge(made(course(tilt_radius=np.full(N, 11 * ARCMIN))))
    assert level == "warning" and "no longer" in reasons[0]
    assert judge(made(against=truth()))[0] == "ok"
    level, _, reasons = judge(made(against=truth(5 * ARCMIN)))
    assert level == "error" and "5.00 arcmin" in reasons[0]


def test_no_more_is_claimed_than_the_accelerometer_allows():
    level, _, reasons = judge(replace(made(), tilt_floor=1e-3))
    assert level == "warning" and "8.41 arcmin" in reasons[0]
    never = made(course(aligned_at=float("nan"), tilt_radius=np.full(N, 60 * ARCMIN)))
    assert "More time" in judge(never)[2][0]
    assert "bias alone leaves 42.1 arcmin" in judge(replace(never, tilt_floor=5e-3))[2][0]


def test_a_unit_upside_down_is_doubted():
    q = quat_from_euler(np.tile([np.pi, 0.0, 0.0], (N, 1)))
    level, _, reasons = judge(made(course(q_nb=q)))
    assert level == "warning" and "specific force" in reasons[0]


@pytest.mark.parametrize(
    ("bias", "floor", "words"),
    [
        (0.01 * DPS, 2.8, "a gyro bias of 0.01 deg/s leaves 160 deg"),
        (0.01 * DPS, 4.0, "leaves every heading open"),
        (1 * DEG_PER_HOUR, 0.1, "not observable yet: a gyro bias of 1 deg/h leaves 5.7 deg"),
    ],
)
def test_a_heading_that_cannot_be_had_says_why(bias, floor, words):
    run = replace(made(course(heading_observable=np.zeros(N, bool))), gyro_bias_sd=bias, heading_floor=floor)
    assert words in judge(run)[1]
    assert angle_rows(run)[2] == {"angle": "heading", "value_deg": None, "within_deg": None}
    assert (
        "It never is." in heading_course(run.said.t, run.said.heading, run.said.heading_sd, np.zeros(N, bool)).caption
    )


def test_roll_is_less_known_where_pitch_is_steep():
    roll, pitch, heading = (row["within_deg"] for row in angle_rows(made()))
    assert roll == pytest.approx(2 * pitch)
    assert pitch == pytest.approx(course().tilt_radius[-1] * 1.96 / 2.4477 / DEG)
    assert heading == pytest.approx(1.96 * 0.01 / DEG)


def test_rows_of_biases_and_errors():
    assert bias_rows(made())[1] == pytest.approx({"axis": "y", "gyro_bias,_deg/h": 2.0, "accel_bias,_mg": 0.2})
    coarse = bias_rows(replace(made(against=truth()), gyro_bias_sd=1 * DPS))[0]
    assert list(coarse) == [
        "axis",
        "gyro_bias,_deg/s",
        "true_gyro_bias,_deg/s",
        "accel_bias,_mg",
        "true_accel_bias,_mg",
    ]
    assert truth_row(made()) == {}
    errors = truth_row(made(against=truth()))
    assert errors["tilt_rms_arcmin"] == pytest.approx(0.2) and errors["heading_deg"] == pytest.approx(-0.01 / DEG)
    hidden = made(course(heading_observable=np.zeros(N, bool)), against=truth())
    assert list(truth_row(hidden)) == ["tilt_arcmin", "tilt_rms_arcmin"]


def test_the_table_says_what_was_said(tmp_path):
    run = made()
    rows = list(csv.DictReader(alignment_table(run).splitlines()))
    assert len(rows) == N
    assert rows[0]["tilt_95_arcmin"] == "" and rows[50]["heading_95_deg"] == ""
    last = {name: float(cell) for name, cell in rows[-1].items()}
    np.testing.assert_array_equal([last[f"q_nb_{axis}"] for axis in "wxyz"], run.said.q_nb[-1])
    angles = euler_from_quat(run.said.q_nb[-1]) / DEG
    np.testing.assert_allclose([last["roll_deg"], last["pitch_deg"], last["heading_deg"]], angles)
    assert last["tilt_95_arcmin"] == run.said.tilt_radius[-1] / ARCMIN
    assert last["gyro_bias_z_rad_s"] == run.said.gyro_bias[-1, 2] and last["wind_east_m_s"] == run.said.wind[-1, 1]


@pytest.mark.parametrize("changes", [{}, {"against": truth(), "reference": np.full((N, 2), np.nan)}])
def test_page_numbers_and_table_are_written_together(tmp_path, changes):
    run = made(events=("a gap",), wind_words="Mean 2 m/s.") if not changes else replace(made(), **changes)
    written = write_alignment(run, tmp_path / "out")
    assert {p.name for p in written.parent.iterdir()} == {"report.html", "results.json", "alignment.csv"}
    html = written.read_text()
    assert html.count("<svg") == (3 if "reference" in changes else 4)
    assert "robustnav align mooring.csv" in html and "177.6" in html
    assert ("a gap" in html) == ("Mean 2 m/s." in html) == (not changes)
    assert ("True tilt error" in html) == ("against" in changes)
    told = json.loads((written.parent / "results.json").read_text())
    assert told["final"]["heading"]["value_deg"] == pytest.approx(3.1 / DEG)
    assert told["aligned_after_s"] == pytest.approx(12.0) and told["aligned_at_s"] == 112.0
    assert (told["errors"] is None) == ("against" not in changes)


def test_equal_arguments_give_equal_bytes():
    first = page(replace(made(), reference=np.full((N, 2), np.nan))).html()
    assert page(replace(made(), reference=np.full((N, 2), np.nan))).html() == first


def test_a_file_in_the_way_is_left_alone(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(InputError, match="a file"):
        write_alignment(made(), tmp_path / "out")
    assert (tmp_path / "out").read_text() == "mine"


def test_one_that_never_aligned_is_a_page_too(tmp_path):
    said = course(aligned_at=float("nan"), tilt_radius=np.full(N, 2 * DEG), heading_observable=np.zeros(N, bool))
    run = made(said)
    assert document(run)["aligned_after_s"] != document(run)["aligned_after_s"]
    html = write_alignment(run, tmp_path).read_text()
    assert "Failed:" in html and ">never<" in html and ">open<" in html
    assert json.loads((tmp_path / "results.json").read_text())["aligned_after_s"] is None


def test_figures_count_what_they_leave_out():
    run = made()
    plot = tilt_radius(run.said.t, run.said.tilt_radius, run.said.tilt_goal, truth(100 * ARCMIN).tilt)
    assert "0.0 % of the readings" in plot.caption
    reference = run.reference.copy()
    reference[[4, 7]] = 30.0
    plot = wind_course(run.said.t, reference, run.said.wind)
    north = plot.figure.axes[0].get_ylim()
    assert (
        north[1] < 30
        and "2 readings lie beyond the axes" not in wind_course(run.said.t, run.reference, run.said.wind).caption
    )
    assert "readings lie beyond the axes" in plot.caption


def test_a_heading_near_south_does_not_jump():
    heading = np.where(np.arange(N) % 2 == 0, 3.14, -3.14)
    plot = heading_course(course().t, heading, np.full(N, 0.02), np.ones(N, bool), np.full(N, -3.1))
    for line in plot.figure.axes[0].get_lines():
        assert np.nanmax(np.asarray(line.get_ydata(), float)) - np.nanmin(line.get_ydata()) < 10


def test_a_carrier_that_turns_round_is_drawn_without_a_jump():
    t = np.linspace(0.0, 60.0, 601)
    turned = 4 * np.pi * t / 60
    for heading in (turned, -turned):
        wrapped = np.angle(np.exp(1j * heading))
        known = t > 5.0
        plot = heading_course(t, np.where(known, wrapped, np.nan), np.full(601, 0.02), known, wrapped)
        drawn = {line.get_label(): line.get_ydata() for line in plot.figure.axes[0].lines}
        for name in ("Estimate", "True"):
            assert np.nanmax(np.abs(np.diff(drawn[name]))) < 5.0
            assert drawn[name][-1] == pytest.approx(np.degrees(wrapped[-1]), abs=1e-6)
