"""PX4 ULog: traps of the format on files made here, and the public recordings."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.logs import read

DATA = os.environ.get("ROBUSTNAV_DATA")


def test_streams_keep_their_own_stamps(ulog):
    log = read(ulog({"sensor_combined": ulog.imu(), "vehicle_attitude": ulog.attitude()}))
    assert log.origin_ns == 2_000_000_000
    np.testing.assert_allclose(log.streams["gyro"].t, 0.004 * np.arange(50), atol=1e-12)
    np.testing.assert_allclose(log.streams["accel"].t, 0.004 * np.arange(50) + 1e-4, atol=1e-12)
    np.testing.assert_allclose(log.streams["gyro"].values[1], [0.1, 0.2, 1.3], rtol=1e-6)
    np.testing.assert_allclose(log.streams["accel"].values[7], [0, 0.5, -9.75])


def test_repeated_magnetometer_samples_are_dropped_and_gauss_is_tesla(ulog):
    log = read(ulog({"sensor_combined": ulog.imu(48)}))
    mag = log.streams["mag"]
    np.testing.assert_allclose(mag.t, 0.012 * np.arange(16) - 7e-6, atol=1e-12)
    np.testing.assert_allclose(mag.values[:3], [[0.25e-4, 0, k + 0.5e-4] for k in (0, 1e-4, 2e-4)], atol=1e-12)
    assert "magnetometer: 32 of 48 rows repeat the sample before" in log.skipped
    assert "barometer: invalid in every row" in log.skipped


def test_new_magnetometer_topic_counts_from_when_it_was_measured(ulog):
    fields = [("uint64_t", 1, "timestamp"), ("uint64_t", 1, "timestamp_sample"), ("float", 3, "magnetometer_ga")]
    rows = [[2_020_000 + 20_000 * k, 2_004_000 + 20_000 * k, 0.2, 0.0, 0.4] for k in range(5)]
    log = read(ulog({"sensor_combined": ulog.imu(old=False), "vehicle_magnetometer": (fields, rows)}))
    np.testing.assert_allclose(log.streams["mag"].t, 0.004 + 0.02 * np.arange(5), atol=1e-12)
    np.testing.assert_allclose(log.streams["mag"].values[0], [2e-5, 0, 4e-5], rtol=1e-6)


def test_a_signalling_nan_is_a_missing_reading(ulog):
    path = ulog({"sensor_combined": ulog.imu()})
    path.write_bytes(path.read_bytes().replace(struct.pack("<f", -9.75), b"\x00\x00\x81\x7f", 1))
    assert np.isnan(read(path).streams["accel"].values[0]).tolist() == [False, False, True]


def test_invalid_relative_stamps_drop_the_reading(ulog):
    fields, rows = ulog.imu()
    rows[3][4] = 2147483647
    log = read(ulog({"sensor_combined": (fields, rows)}))
    assert len(log.streams["accel"]) == 49
    assert "accelerometer: 1 of 50 rows invalid" in log.skipped
    for row in rows:
        row[4] = 2147483647
    assert "accel" not in read(ulog({"sensor_combined": (fields, rows)})).streams


@pytest.mark.parametrize(("sample", "first"), [(True, 0.001), (False, 0.003)])
def test_attitude_is_the_logs_estimate(ulog, sample, first):
    topics = {"sensor_combined": ulog.imu(), "vehicle_attitude": ulog.attitude(sample=sample)}
    log = read(ulog(topics, {"EKF2_MAG_DECL": 0.0}))
    assert log.truth is None
    assert (log.estimate.kind, log.estimate.north) == ("estimate", "magnetic")
    assert log.estimate.t[0] == pytest.approx(first)
    np.testing.assert_allclose(log.estimate.q_nb[5], [0.6, 0, 0, 0.8], atol=1e-7)
    assert read(ulog(topics, {"EKF2_MAG_DECL": 2.5})).estimate.north == "true"


def test_simulator_attitude_is_the_truth(ulog):
    log = read(ulog({"sensor_combined": ulog.imu(), "vehicle_attitude_groundtruth": ulog.attitude()}))
    assert (log.truth.kind, log.truth.north, log.estimate) == ("simulated", "true", None)


def test_declination_comes_from_the_estimator_in_use(ulog):
    both = {"EKF2_MAG_DECL": 2.5, "ATT_MAG_DECL": 1.0}
    for group, want in ((1, 1.0), (2, 2.5), (3, 1.0)):
        log = read(ulog({"sensor_combined": ulog.imu()}, both | {"SYS_MC_EST_GROUP": group}))
        assert log.info["declination_deg"] == pytest.approx(want)
    assert "declination_deg" not in read(ulog({"sensor_combined": ulog.imu()})).info


@pytest.mark.parametrize("new", [False, True])
def test_position_and_year_come_from_fixes_only(ulog, new):
    names = ("latitude_deg", "longitude_deg", "altitude_ellipsoid_m") if new else ("lat", "lon", "alt_ellipsoid")
    kind, scale, mm = ("double", 1.0, 1.0) if new else ("int32_t", 10_000_000, 1000)
    fields = [("uint64_t", 1, "timestamp"), ("uint64_t", 1, "time_utc_usec")]
    fields += [(kind, 1, name) for name in names] + [("uint8_t", 1, "fix_type")]
    number = float if new else int
    fix = [1_656_763_200_000_000, number(47.4 * scale), number(8.5 * scale), number(488 * mm), 3]
    rows = [[2_000_000, 0, number(0), number(0), number(0), 0]] * 3 + [[2_200_000, *fix], [2_400_000, *fix]]
    info = read(ulog({"sensor_combined": ulog.imu(), "vehicle_gps_position": (fields, rows)})).info
    assert info["latitude_deg"] == pytest.approx(47.4)
    assert info["longitude_deg"] == pytest.approx(8.5)
    assert info["height_m"] == pytest.approx(488)
    assert info["year"] == pytest.approx(2022.5, abs=2e-3)  # noon of 2 July
    none = read(ulog({"sensor_combined": ulog.imu(), "vehicle_gps_position": (fields, rows[:3])})).info
    assert not {"latitude_deg", "year"} & set(none)


@pytest.mark.parametrize("stamp", [0, 2_069_758])
def test_topics_without_time_are_refused(ulog, stamp):
    fields, rows = ulog.attitude(sample=False)
    dead = [[stamp, *row[1:]] for row in rows]
    log = read(ulog({"sensor_combined": ulog.imu(), "vehicle_attitude": (fields, dead)}))
    assert log.estimate is None
    assert any(line.startswith("vehicle_attitude: every stamp is") for line in log.skipped)
    fields, rows = ulog.imu()
    with pytest.raises(InputError, match="sensor_combined"):
        read(ulog({"sensor_combined": (fields, [[stamp, *row[1:]] for row in rows])}))


def test_time_that_goes_backwards_is_refused_with_its_row(ulog):
    fields, rows = ulog.imu()
    rows[30][0] -= 1_000_000
    with pytest.raises(InputError, match=r"goes backwards in stream 'gyro', row 30"):
        read(ulog({"sensor_combined": (fields, rows)}))


def test_what_is_no_attitude_is_left_out(ulog):
    fields, rows = ulog.attitude()
    rows[4][2:] = [0.0, 0.0, 0.0, 0.0]
    log = read(ulog({"sensor_combined": ulog.imu(), "vehicle_attitude": (fields, rows)}))
    assert log.estimate is None
    assert "vehicle_attitude: row 4 is no unit quaternion, its norm is 0" in log.skipped


def test_a_log_without_imu_names_what_it_has(ulog):
    with pytest.raises(InputError, match=r"made\.ulg(.|\n)*vehicle_attitude(.|\n)*sensor_combined(.|\n)*SDLOG_PROFILE"):
        read(ulog({"vehicle_attitude": ulog.attitude()}))


def test_a_cut_file_says_so(ulog):
    whole = {"sensor_combined": ulog.imu()}
    assert "incomplete" not in read(ulog(whole)).info
    log = read(ulog(whole, cut=-10))
    assert len(log.streams["gyro"]) == 49
    assert "ends inside a message" in log.info["incomplete"]
    with pytest.raises(InputError):
        read(ulog(whole, cut=30))


def test_nothing_is_printed(ulog, capfd):
    path = ulog({"sensor_combined": ulog.imu()})
    path.write_bytes(path.read_bytes().replace(b"gyro_rad", b"gyro rad"))
    with pytest.raises(InputError):
        read(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with px4/")
def test_recordings_hold_what_their_readme_says():
    folder = Path(DATA or ".") / "px4"
    sample = read(folder / "sample.ulg")
    assert {n: len(s) for n, s in sample.streams.items()} == {"gyro": 17070, "accel": 17070, "mag": 6759}
    assert len(sample.estimate.t) == 6461
    assert (sample.info["dropouts"], sample.info["dropout_ms"], sample.info["hardware"]) == (4, 119, "AUAV_X21")
    assert sample.info["SYS_MC_EST_GROUP"] == 1
    small = read(folder / "sample_log_small.ulg")
    assert small.streams["gyro"].t[-1] < 6.6  # not the 1174 s of the header
    assert (small.info["latitude_deg"], small.info["longitude_deg"]) == pytest.approx((63.417, 10.408), abs=1e-3)
    assert int(small.info["year"]) == 2021
    tagged = read(folder / "sample_logging_tagged_and_default_params.ulg")
    assert len(tagged.truth.t) == 1078
    np.testing.assert_allclose(np.abs(tagged.truth.q_nb[:, 0]), 1, atol=1e-9)
    assert tagged.info["declination_deg"] == pytest.approx(2.98, abs=5e-3)
