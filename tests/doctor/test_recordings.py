"""Figures and verdicts on three public recordings, found through ROBUSTNAV_DATA."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from robustnav.doctor import examine
from robustnav.logs import read

DATA = os.environ.get("ROBUSTNAV_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with px4/ and broad/")


def diagnosis(name):
    return examine(read(Path(DATA or ".") / name))


@pytest.fixture(scope="module")
def sample():
    return diagnosis("px4/sample.ulg")


@pytest.fixture(scope="module")
def small():
    return diagnosis("px4/sample_log_small.ulg")


@pytest.fixture(scope="module")
def tagged():
    return diagnosis("px4/sample_logging_tagged_and_default_params.ulg")


def only(found, check, level):
    hits = [f for f in found.of(check) if f.level == level]
    assert len(hits) == 1, found.of(check)
    return hits[0]


def test_sample_times(sample):
    t = sample.facts["timing"]
    gyro, mag = t["gyro"], t["mag"]
    assert (gyro["rows"], mag["rows"], gyro["gaps"]) == (17070, 6759, 8)
    assert gyro["rate_hz"] == pytest.approx(247.81, abs=0.005)
    assert mag["rate_hz"] == pytest.approx(98.11, abs=0.005)
    assert gyro["interval_s"] == pytest.approx(0.004, abs=5e-7)
    assert gyro["largest_gap_s"] == pytest.approx(0.0648, abs=5e-5)
    assert gyro["largest_gap_at_s"] == pytest.approx(41.24, abs=0.005)
    assert mag["largest_gap_s"] == pytest.approx(0.0600, abs=5e-5)
    assert gyro["stop_s"] - gyro["start_s"] == pytest.approx(68.88, abs=0.005)


def test_sample_sizes(sample):
    accel, mag = sample.facts["readings"]["accel"], sample.facts["readings"]["mag"]
    assert accel["norm_median"] == pytest.approx(9.703, abs=6e-4)
    assert accel["norm_mean"] == pytest.approx(9.703, abs=6e-4)
    assert accel["norm_sd"] == pytest.approx(0.149, abs=6e-4)
    np.testing.assert_allclose(accel["mean"], (1.091, -0.442, -9.618), atol=6e-4)
    assert mag["norm_mean"] == pytest.approx(0.4818e-4, abs=2e-8)
    assert mag["norm_sd"] == pytest.approx(0.0077e-4, abs=1e-8)


def test_sample_world(sample):
    world = sample.facts["world"]
    np.testing.assert_allclose(world["force_n"]["vector_n"], (-0.006, 0.006, -9.704), atol=2.5e-3)
    assert world["tilt_deg"] == pytest.approx(0.05, abs=0.006)
    assert world["declination_deg"] == pytest.approx(0.12, abs=0.015)
    np.testing.assert_allclose(sample.facts["dip"], (63.4, 1.0), atol=0.06)


def test_sample_axes_scale_and_lag(sample):
    turning, field = sample.facts["turning"], sample.facts["by_field"]["axes"]
    assert turning["axes"]["share"] == pytest.approx(0.992, abs=6e-4)
    assert turning["axes"]["next_share"] == pytest.approx(0.759, abs=6e-4)
    assert turning["scale"] == pytest.approx(0.997, abs=6e-4)
    assert turning["lag_ms"] == 6
    gravity = sample.facts["by_gravity"]["axes"]
    assert (gravity["share"], gravity["next_share"]) == pytest.approx((0.981, 0.946), abs=2e-3)
    # Where the first 0.2 s window begins moves the last digit here.
    assert (field["share"], field["next_share"]) == pytest.approx((0.959, 0.838), abs=6e-3)


def test_sample_motion(sample):
    m = sample.facts["motion"]
    np.testing.assert_allclose(m["swept_deg"], (41.6, 17.2, 35.6), atol=0.06)
    np.testing.assert_allclose(m["rms_dps"], (15.91, 6.72, 8.96), atol=6e-3)
    np.testing.assert_allclose(m["largest_dps"], (158.3, 71.0, 102.0), atol=0.06)
    assert m["moving_share"] == pytest.approx(0.051, abs=6e-4)
    assert (m["moving_from_s"], m["moving_to_s"]) == pytest.approx((2.2, 5.9), abs=0.06)
    assert m["quiet_at_s"] == pytest.approx(28.6, abs=0.06)
    np.testing.assert_allclose(m["quiet_mean_dps"], (-0.074, -0.125, -0.168), atol=6e-4)
    np.testing.assert_allclose(m["quiet_sd_dps"], (0.036, 0.035, 0.034), atol=6e-4)


def test_sample_is_usable_with_three_warnings(sample):
    assert sample.worst == "warning"
    assert [f.thing for f in sample.at("warning")] == [
        "no declination",
        "the log's own attitude is no truth",
        "little motion",
    ]
    assert "not EKF2" in only(sample, "R", "warning").got
    left_out = " ".join(f.got for f in sample.of("I"))
    for words in ("commander_state", "ekf2_innovations", "sensor_preflight", "barometer", "4 records, 119 ms"):
        assert words in left_out
    assert "x -1.50, y 1.19" in left_out


def test_small_has_a_wrong_magnetometer_and_a_wrong_heading(small):
    assert small.worst == "error"
    assert [f.check for f in small.at("error")] == ["D", "H"]
    assert only(small, "E", "warning").thing == "not enough rotation"
    field = only(small, "D", "error")
    assert "-7.7" in field.got
    assert "45.0" in field.got
    assert "+74.9" in field.expected
    assert "52.1" in field.expected
    heading = only(small, "H", "error").got
    assert "-11.9 deg" in heading
    assert "0.39" in heading
    force = only(small, "F", "warning")
    assert "9.623" in force.got
    assert "9.82" in force.expected


def test_tagged_stands_before_a_constant_truth(tagged):
    assert not tagged.at("error")
    assert only(tagged, "E", "warning").thing == "not enough rotation"
    assert "665 of 2027" in only(tagged, "T", "warning").got
    dip, declination = tagged.of("D")
    assert "+63.2" in dip.got
    assert tagged.facts["world"]["declination_deg"] == pytest.approx(3.00, abs=0.015)
    assert "2.98" in declination.got
    assert "constant" in only(tagged, "R", "warning").got


def test_optical_trials_pass():
    folder = Path(DATA or ".") / "broad"
    for name in ("01_undisturbed_slow_rotation_A.mat", "14_undisturbed_slow_translation_with_breaks_B.mat"):
        found = examine(read(folder / name))
        assert found.worst == "info", found.at(found.worst)


def test_diagnosis_is_plain_json():
    found = examine(read(Path(DATA or ".") / "px4" / "sample.ulg"))
    back = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert back["worst"] == "warning"
    assert len(back["findings"]) == len(found.findings)
