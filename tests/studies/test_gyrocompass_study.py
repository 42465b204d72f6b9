"""The gyrocompass study on few seeds: what it must show, its bounds against independent ones, and what it refuses."""

import json
from dataclasses import replace
from math import hypot, pi, sqrt, tan

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav.errors import InputError
from robustnav.frames import quat_conjugate, quat_from_euler, quat_from_rotvec, quat_multiply, rotate
from robustnav.strapdown.increments import Increments
from robustnav.strapdown.static import Place
from robustnav.studies.gyrocompass import (
    afloat_rows,
    gyrocompass_study,
    outside_bands,
    results,
    standing_rows,
    steps_of,
)
from robustnav.studies.gyrocompass_report import write_study
from robustnav.studies.gyrocompass_runs import (
    GRADES,
    LATITUDE,
    TREMBLE,
    coarse_heading,
    setup_of,
    still_bound,
    velocity_bound,
)
from robustnav.units import DEG


@pytest.fixture(scope="module")
def study():
    steps = []
    done = gyrocompass_study(2, 10, lambda: steps.append(1))
    assert len(steps) == steps_of(2)
    return done


def test_at_rest_what_is_claimed_is_the_bound(study):
    assert len(study.standing) == 12
    for row in study.standing:
        assert row.claimed_deg == pytest.approx(row.velocity_bound_deg, rel=0.2 if row.grade == "1 deg/h" else 0.03)
        assert row.heading_nees < 5.3 and row.tilt_nees < 7.5
        assert row.velocity_bound_deg > row.still_bound_deg


def test_a_base_that_turns_takes_only_the_coarse_heading(study):
    """Of a tenth of a degree over a minute it makes six degrees an hour."""
    engine = [row for row in study.standing if row.base == "engine" and row.grade != "1 deg/h"]
    assert engine
    for row in engine:
        assert row.peer_rms_deg > 3 * row.rms_deg


def test_afloat_a_compass_gives_coarse_gyros_a_heading(study):
    for row in study.afloat:
        if row.compass:
            assert row.claimed_deg < (6.5 if row.grade == "3 deg/s" else 2.3) and row.observable_share == 1.0
            assert row.rms_deg < 2.5 * row.claimed_deg
        elif row.grade.endswith("deg/s"):
            assert row.observable_share == 0.0


def test_afloat_raw_sensors_claim_the_tilt_that_their_biases_leave(study):
    """An accelerometer off by 46 mg hides 2.6 degrees about each axis; a minute of sway shows little of them."""
    raw = [row for row in study.afloat if row.grade == "3 deg/s" and not row.compass]
    assert len(raw) == 3
    for row in raw:
        assert 2.0 < row.tilt_claimed_deg < 4.5
        assert row.tilt_nees < chi2.ppf(0.995, 4) / 2


def test_tables_and_plain_numbers(study):
    assert len(standing_rows(study)) == 12 and len(afloat_rows(study)) == 18
    plain = results(study)
    assert plain["seeds"] == 2 and len(plain["standing"]) == 12
    low, high = plain["heading_nees_band"]
    assert low < 1 < high


@pytest.mark.parametrize("heading", [0.0, 2.0, -1.2])
def test_the_coarse_heading_is_exact_for_a_unit_that_stands(heading):
    place = Place.at(LATITUDE)
    q, n = quat_from_euler(np.array([0.1, -0.3, heading])), 20
    turn = quat_multiply(quat_multiply(quat_conjugate(q), quat_from_rotvec(0.1 * place.earth_rate_n)), q)
    force = np.tile(rotate(quat_conjugate(q), -0.1 * place.gravity_n), (n, 1))
    still = Increments.of(np.tile(turn, (n, 1)), force, (np.zeros((n, 3, 3)), np.zeros((n, 3, 3))), 0.1)
    assert coarse_heading(still) == pytest.approx(heading, abs=1e-9)


def test_the_bounds_meet_where_velocity_is_known_well():
    """A base whose velocity is known to a hair shows its turn at once: what is left is what the sensors leave."""
    setup = replace(setup_of(GRADES["0.1 deg/h"], 1e-6), gyro_bias_walk=1e-12, accel_bias_walk=1e-12)
    assert velocity_bound(setup, 100.0) == pytest.approx(still_bound(setup, 100.0), rel=0.1)
    assert velocity_bound(replace(setup, reference_sd=TREMBLE), 60.0) > 1.1 * still_bound(setup, 60.0)


def test_the_still_bound_by_hand():
    setup = setup_of(GRADES["1 deg/h"], TREMBLE)
    rate = hypot(1.0 * DEG / 3600, 0.1 * DEG / 60 / sqrt(60.0)) / setup.horizontal_earth_rate
    assert still_bound(setup, 60.0) == pytest.approx(hypot(rate, 1e-3 * 9.80665 / setup.gravity * tan(pi / 4)))


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="at least 2"):
        gyrocompass_study(1)
    with pytest.raises(InputError, match="seed"):
        gyrocompass_study(2, -1)


def test_cases_that_claim_too_much_are_named(study):
    named = outside_bands(study)
    assert all("NEES of" in line for line in named)
    wrong = replace(study, standing=[replace(study.standing[0], heading_nees=50.0), *study.standing[1:]])
    assert outside_bands(wrong) == [
        f"0.01 deg/h, still, 60 s: NEES of heading 50.00, band up to {chi2.ppf(0.975, 2) / 2:.2f}",
        *named,
    ]
    hidden = [replace(row, heading_nees=50.0) if not row.observable_share else row for row in study.afloat]
    assert outside_bands(replace(study, afloat=hidden)) == named  # of what is not observable nothing is claimed


def test_page_and_numbers_are_written(study, tmp_path):
    page = write_study(study, tmp_path / "out", "robustnav demo gyrocompass --seeds 2")
    found = json.loads((tmp_path / "out" / "results.json").read_text())
    assert found["study"] == "gyrocompass" and len(found["standing"]) == 12
    html = page.read_text()
    assert "robustnav demo gyrocompass --seeds 2" in html and html.count("<figure>") == 2
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="output folder"):
        write_study(study, tmp_path / "file", "x")
