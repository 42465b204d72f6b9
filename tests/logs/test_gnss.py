"""Satellite readings from files: units and frames of old and new firmware, what is no fix, mapped and own tables."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.earth import ned_from_geodetic
from robustnav.errors import InputError
from robustnav.logs import read, write_table
from robustnav.logs.gnss import Fixes, gnss_streams
from robustnav.records import Log
from robustnav.units import DEG

DATA = os.environ.get("ROBUSTNAV_DATA")
PLACES = np.array([[47.4, 8.5, 488.0], [47.4001, 8.5, 488.0], [47.4, 8.5001, 490.5], [47.4, 8.5, 487.0]])
P_N = ned_from_geodetic(PLACES * [DEG, DEG, 1.0], PLACES[0] * [DEG, DEG, 1.0])
V_N = np.array([[1.0, 2.0, 3.0], [-1.0, 0.0, 0.5], [4.0, 5.0, -6.0], [0.0, 0.25, 0.0]])


def gps_topic(new, fix=(3, 3, 3, 3), valid=(1, 1, 1, 1), sea=False):
    height = ("altitude_msl_m", "alt") if sea else ("altitude_ellipsoid_m", "alt_ellipsoid")
    names = ("latitude_deg", "longitude_deg", height[0]) if new else ("lat", "lon", height[1])
    kind = "double" if new else "int32_t"
    scaled = PLACES if new else np.rint(PLACES * [1e7, 1e7, 1e3]).astype(int)
    fields = [("uint64_t", 1, "timestamp"), *((kind, 1, name) for name in names)]
    fields += [("float", 1, f"vel_{axis}_m_s") for axis in "ned"]
    fields += [("uint8_t", 1, "vel_ned_valid"), ("uint8_t", 1, "fix_type"), ("float", 1, "eph"), ("float", 1, "epv")]
    rows = [
        [2_000_000 + 200_000 * k, *(n.item() for n in scaled[k]), *V_N[k], valid[k], fix[k], 1.5, 2.5] for k in range(4)
    ]
    return fields, rows


@pytest.mark.parametrize("name", ["vehicle_gps_position", "sensor_gps"])
@pytest.mark.parametrize("sea", [False, True])
@pytest.mark.parametrize("new", [False, True])
def test_firmware_old_and_new_tell_the_same(ulog, new, sea, name):
    log = read(ulog({"sensor_combined": ulog.imu(), name: gps_topic(new, sea=sea)}))
    position, velocity = log.streams["gnss_position"], log.streams["gnss_velocity"]
    np.testing.assert_allclose(position.values, P_N, atol=0.02)  # a step of 1e-7 deg
    np.testing.assert_allclose(velocity.values, V_N, atol=1e-6)
    np.testing.assert_allclose(position.t, 0.2 * np.arange(4), atol=1e-9)
    assert (position.unit, velocity.unit, position.frame, velocity.frame) == ("m", "m/s", "n", "n")
    assert P_N[1, 0] == pytest.approx(11.12, abs=0.01) and P_N[2, 2] == pytest.approx(-2.5, abs=1e-3)
    assert (log.info["gnss_horizontal_sd_m"], log.info["gnss_vertical_sd_m"]) == (1.5, 2.5)
    assert log.info["origin_latitude_deg"] == pytest.approx(47.4)


def test_rows_without_a_fix_are_missing_and_named(ulog):
    log = read(
        ulog({"sensor_combined": ulog.imu(), "vehicle_gps_position": gps_topic(True, (0, 2, 3, 4), (1, 1, 0, 1))})
    )
    assert np.isnan(log.streams["gnss_position"].values).all(axis=1).tolist() == [True, True, False, False]
    assert np.isnan(log.streams["gnss_velocity"].values).all(axis=1).tolist() == [True, True, True, False]
    assert "gnss: 2 of 4 rows without a 3-D fix" in log.skipped
    assert "gnss: 1 of 4 rows with a fix tell no velocity" in log.skipped
    np.testing.assert_array_equal(log.streams["gnss_position"].values[2], 0.0)  # the first fix is the origin
    none = read(ulog({"sensor_combined": ulog.imu(), "vehicle_gps_position": gps_topic(True, (0, 1, 2, 2))}))
    assert not any(name.startswith("gnss") for name in none.streams) and "origin_latitude_deg" not in none.info


def test_what_the_file_does_not_say_is_not_invented(ulog):
    fields, rows = gps_topic(True)
    height = [name for _, _, name in fields].index("altitude_ellipsoid_m")
    flat = [f for k, f in enumerate(fields) if k != height], [[*r[:height], *r[height + 1 :]] for r in rows]
    log = read(ulog({"sensor_combined": ulog.imu(), "vehicle_gps_position": flat}))
    assert "gnss_position" not in log.streams and "gnss_velocity" in log.streams
    unsaid = [f for f in fields if f[2] != "fix_type"], [[*r[:8], *r[9:]] for r in rows]
    log = read(ulog({"sensor_combined": ulog.imu(), "vehicle_gps_position": unsaid}))
    assert not any(name.startswith("gnss") for name in log.streams)
    assert "vehicle_gps_position: it does not say which rows are fixes" in log.skipped


NUMBERS = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-90, 90)


@given(st.lists(st.tuples(st.booleans(), *[NUMBERS] * 6), min_size=1, max_size=6))
def test_any_numbers_become_readings_or_are_missing(rows):
    values = np.array([row[1:] for row in rows])
    fixed, skipped = np.array([row[0] for row in rows]), []
    streams, info = gnss_streams(Fixes(np.arange(len(rows)) * 0.2, fixed, values[:, :3], values[:, 3:]), skipped)
    for stream in streams:
        whole = np.isfinite(stream.values).all(axis=1)
        assert whole.any() and not (whole & ~fixed).any() and (whole | np.isnan(stream.values).all(axis=1)).all()
    assert bool(info) == any(s.name == "gnss_position" for s in streams)
    assert skipped or len(streams) == 2


def test_a_replay_row_holds_height_longitude_latitude(tmp_path):
    lines = ["0,imu,0,0,-9.8,0,0,0"]
    for k, (place, v_n) in enumerate(zip(PLACES, V_N, strict=True)):
        mm, lon, lat = np.rint([place[2] * 1e3, place[1] * 1e7, place[0] * 1e7])
        lines.append(f"{200_000 * k},gps,{mm},{lon},{lat},{v_n[0]},{v_n[1]},{v_n[2]}")
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    log = read(tmp_path / "a.csv")
    np.testing.assert_allclose(log.streams["gnss_position"].values, P_N, atol=0.02)
    np.testing.assert_array_equal(log.streams["gnss_velocity"].values, V_N)


MAPPING = """
[time]
column = "t"
unit = "s"
[gnss_velocity]
columns = ["ve", "vn", "vu"]
unit = "km/h"
frame = "ENU"
"""
PLACE = '[gnss_place]\ncolumns = ["lat", "lon", "h"]\nunit = "1e-7deg"\nheight_unit = "mm"\nfix_column = "fix"\n'
POSITION = '[gnss_position]\ncolumns = ["e", "n", "u"]\nunit = "cm"\nframe = "ENU"\n'


def mapped(tmp_path, mapping):
    enu = lambda v: v[:, [1, 0, 2]] * [1, 1, -1]  # noqa: E731
    columns = np.hstack([0.2 * np.arange(4)[:, None], enu(V_N) * 3.6, PLACES * [1e7, 1e7, 1e3], enu(P_N) * 100])
    rows = [",".join(map(repr, [*row, fix])) for row, fix in zip(columns.tolist(), (3, 3, 0, 5), strict=True)]
    (tmp_path / "a.csv").write_text("t,ve,vn,vu,lat,lon,h,e,n,u,fix\n" + "\n".join(rows) + "\n")
    (tmp_path / "m.toml").write_text(mapping)
    return read(tmp_path / "a.csv", tmp_path / "m.toml")


def test_mapped_tables_in_other_units_and_axes(tmp_path):
    log = mapped(tmp_path, MAPPING + PLACE)
    np.testing.assert_allclose(log.streams["gnss_velocity"].values, V_N, atol=1e-12)
    there = [0, 1, 3]
    np.testing.assert_allclose(log.streams["gnss_position"].values[there], P_N[there], atol=1e-6)
    assert np.isnan(log.streams["gnss_position"].values[2]).all()
    assert "gnss: 1 of 4 rows without a 3-D fix" in log.skipped and log.info["latitude_deg"] == pytest.approx(47.4)
    local = mapped(tmp_path, MAPPING + POSITION)
    np.testing.assert_allclose(local.streams["gnss_position"].values, P_N, atol=1e-9)
    assert "column 'lat': not in the mapping" in local.skipped


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        (MAPPING + PLACE + POSITION, "not both"),
        (MAPPING.replace("km/h", "furlong/h"), "gnss_velocity.unit"),
        (MAPPING + PLACE.replace("1e-7deg", "grad"), "gnss_place.unit"),
        (MAPPING + PLACE.replace('"fix"', '"fixx"'), "fixx"),
        (MAPPING.replace("ENU", "FRD"), "gnss_velocity.frame"),
    ],
)
def test_a_wrong_mapping_is_named(tmp_path, mapping, words):
    with pytest.raises(InputError, match=words):
        mapped(tmp_path, mapping)


def test_our_own_table_keeps_them(tmp_path):
    streams, info = gnss_streams(Fixes(0.2 * np.arange(4), np.array([True, False, True, True]), PLACES, V_N), [])
    write_table(Log({s.name: s for s in streams}, "made", info=info), tmp_path / "a.csv")
    back = read(tmp_path / "a.csv")
    for one in streams:
        np.testing.assert_array_equal(back.streams[one.name].values, one.values)
        assert back.streams[one.name].frame == "n"
    assert back.info["origin_height_m"] == 488.0
    assert "gnss_velocity_north_m_s" in (tmp_path / "a.csv").read_text()


@pytest.mark.skipif(not DATA, reason="set ROBUSTNAV_DATA to the folder with px4/")
def test_recordings_have_the_fixes_their_readme_counts():
    folder = Path(DATA or ".") / "px4"
    small = read(folder / "sample_log_small.ulg")
    assert len(small.streams["gnss_position"]) == len(small.streams["gnss_velocity"]) == 32
    tagged = read(folder / "sample_logging_tagged_and_default_params.ulg")
    assert len(tagged.streams["gnss_velocity"]) == 190 and any("without a 3-D fix" in s for s in tagged.skipped)
    flown = read(folder / "ekf_gsf_reset.csv").streams["gnss_position"].values[-1]
    assert flown[:2] == pytest.approx([-17.4, -7.8], abs=0.1)
