"""Presets: figures against the sheet in SI, and every kind of bad file refused with all its mistakes at once."""

import tomllib
from importlib.resources import files
from math import pi, sqrt

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robustnav.datasheet.presets import imu, magnetometer, names
from robustnav.datasheet.sensors import SensorSpec
from robustnav.errors import InputError

DEG = pi / 180
GOOD = """
[imu.mine]
document = "own measurement"
gyro_density_dps_rthz = 0.01
accel_density_ug_rthz = 100
"""


def write(tmp_path, text):
    path = tmp_path / "sensor.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def stated(spec):
    return {name: value for name, value in vars(spec).items() if value is not None}


def test_mpu9250_in_si():
    sensor = imu("mpu9250")
    assert stated(sensor.gyro) == pytest.approx(
        {
            "density": 0.01 * DEG,
            "noise_rms_sd": 0.1 * DEG,
            "bandwidth_hz": 92.0,
            "turn_on_bias_sd": 5 * DEG / sqrt(3),
            "scale_sd": 0.03 / sqrt(3),
            "misalignment_sd": 0.02 / sqrt(3),
            "resolution": DEG / 16.4,
            "range_max": 2000 * DEG,
        }
    )
    assert sensor.accel.density == pytest.approx(300e-6 * 9.80665)
    assert sensor.accel.noise_rms_sd == pytest.approx(8e-3 * 9.80665)
    assert sensor.accel.range_max == pytest.approx(16 * 9.80665)


def test_other_units_in_si():
    adis = imu("adis16470")
    assert adis.gyro.bias_instability == pytest.approx(8 * DEG / 3600)
    assert adis.gyro.turn_on_bias_sd == pytest.approx(0.2 * DEG)
    assert adis.accel.bias_instability == pytest.approx(13e-6 * 9.80665)
    tactical = imu("hg1700")
    assert tactical.gyro.turn_on_bias_sd == pytest.approx(1.0 * DEG / 3600)
    assert sqrt(3600 * tactical.gyro.intensity) == pytest.approx(0.125 * DEG)
    assert imu("stim300").gyro.turn_on_bias_sd == pytest.approx(5.0 * DEG / 3600)
    compass = magnetometer("ak8963")
    assert stated(compass.field) == pytest.approx(
        {"noise_rms_sd": 0.5e-6, "range_max": 4912e-6, "resolution": 0.15e-6}, rel=1e-9, abs=0
    )
    assert compass.assumed == ("mag_rms_ut",)


def test_density_convention():
    spec = SensorSpec(density=2.0, noise_rms_sd=7.0)
    assert spec.sample_sd(200.0) == pytest.approx(20.0)
    assert spec.intensity == 2.0
    assert SensorSpec(noise_rms_sd=7.0).sample_sd(200.0) == 7.0
    assert SensorSpec(noise_rms_sd=7.0).intensity is None
    with pytest.raises(InputError, match="noise figure"):
        SensorSpec(range_max=1.0).sample_sd(100.0)


def test_angle_random_walk_is_the_integral_of_the_density(tmp_path):
    text = GOOD.replace("gyro_density_dps_rthz = 0.01", "gyro_angle_random_walk_deg_rth = 0.34").replace(
        "accel_density_ug_rthz = 100", "accel_velocity_random_walk_mps_rth = 0.06"
    )
    sensor = imu(write(tmp_path, text))
    # After an hour white noise of two-sided intensity S has walked sqrt(3600 S).
    assert sqrt(3600 * sensor.gyro.intensity) == pytest.approx(0.34 * DEG)
    assert sqrt(3600 * sensor.accel.intensity) == pytest.approx(0.06)
    assert sensor.gyro.density == pytest.approx(imu("adis16470").gyro.density, rel=0.01)


def test_every_preset_loads_and_every_figure_has_a_source():
    assert names() == {
        "imu": ("mpu9250", "bmi088", "icm42688p", "adis16470", "stim300", "hg1700"),
        "magnetometer": ("ak8963", "bmm150"),
    }
    for name in names()["imu"]:
        assert imu(name).gyro.density and imu(name).accel.density and imu(name).document
    for name in names()["magnetometer"]:
        assert magnetometer(name).field.sample_sd(50.0) > 0
    text = files("robustnav.datasheet").joinpath("presets.toml").read_text()
    bare = [line for line in text.splitlines() if line.startswith(("gyro_", "accel_", "mag_")) and "#" not in line]
    assert not bare
    for table in (table for kind in tomllib.loads(text).values() for table in kind.values()):
        for name in table.get("assumed", []):
            assert any(line.startswith(name) and "assumption" in line for line in text.splitlines())


@pytest.mark.parametrize("name", ["mpu9251", "MPU9250", "mpu-9250"])
def test_unknown_name_lists_the_known_and_suggests(name):
    with pytest.raises(InputError, match=r"adis16470[\s\S]*did you mean 'mpu9250'"):
        imu(name)


def test_unknown_name_without_a_near_one():
    with pytest.raises(InputError, match="ak8963, bmm150") as caught:
        magnetometer("zzz")
    assert not caught.value.do


def test_own_file(tmp_path):
    sensor = imu(write(tmp_path, GOOD))
    assert (sensor.name, sensor.document, sensor.assumed) == ("mine", "own measurement", ())
    assert sensor.accel.density == pytest.approx(1e-4 * 9.80665)
    assert sensor.gyro.range_max is None


def test_all_mistakes_at_once(tmp_path):
    text = """
    extra = 1
    [imu.a]
    document = ""
    gyro_density_dps_rtz = 0.01
    gyro_range_dps = "wide"
    accel_density_ug_rthz = -1.0
    accel_range_g = inf
    gyro_rms_dps = true
    [magnetometer.b]
    mag_rms_ut = nan
    """
    with pytest.raises(InputError) as caught:
        imu(write(tmp_path, text))
    for path in (
        "extra",
        "imu.a.document",
        "imu.a.gyro_density_dps_rtz",
        "imu.a.gyro_range_dps",
        "imu.a.accel_density_ug_rthz",
        "imu.a.accel_range_g",
        "imu.a.gyro_rms_dps",
        "magnetometer.b.document",
        "magnetometer.b.mag_rms_ut",
    ):
        assert f"{path}:" in caught.value.got
    assert "9 mistakes" in str(caught.value)
    assert caught.value.place.endswith("sensor.toml")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("gyro_angle_random_walk_deg_rth = 0.3", "same figure as gyro_density_dps_rthz"),
        ("gyro_turn_on_bias_sd_dps = 1\ngyro_turn_on_bias_max_dps = 3", "same figure as gyro_turn_on_bias_"),
        ('assumed = ["gyro_range_dps"]', "no figure 'gyro_range_dps'"),
        ('assumed = ["nonsense"]', "no figure 'nonsense'"),
    ],
)
def test_contradictions(tmp_path, line, message):
    with pytest.raises(InputError, match=message):
        imu(write(tmp_path, GOOD + line))


def test_sensor_without_noise(tmp_path):
    with pytest.raises(InputError, match="no noise figure for 'accel'"):
        imu(write(tmp_path, GOOD.replace("accel_density_ug_rthz", "accel_bandwidth_hz")))


@pytest.mark.parametrize("text", ["", "[magnetometer.m]\ndocument='x'\nmag_rms_ut=1", GOOD + GOOD.replace("mine", "b")])
def test_exactly_one_table(tmp_path, text):
    with pytest.raises(InputError, match=r"one table \[imu.<name>\]"):
        imu(write(tmp_path, text))


@pytest.mark.parametrize("path", ["missing.toml", ".toml", "a\0b.toml"])
def test_unreadable_file(tmp_path, path):
    with pytest.raises(InputError, match="cannot be read"):
        imu(str(tmp_path / path))


@pytest.mark.parametrize(
    "text",
    [b"\xff\xfe", "a = " + "[" * 20000, "a = " + "9" * 6000, "[imu.a]\ngyro_range_dps = " + "9" * 400],
)
def test_hostile_files(tmp_path, text):
    with pytest.raises(InputError):
        imu(write(tmp_path, text))


def test_spec_refuses_bad_figures():
    for bad in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="'resolution'"):
            SensorSpec(resolution=bad)


FUZZ = settings(
    max_examples=150, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
VALUES = st.one_of(
    st.floats(),
    st.integers(),
    st.booleans(),
    st.just('"x"'),
    st.just("[1, 2]"),
    st.just("{a = 1}"),
    st.just("1979-05-27"),
)
KEYS = st.sampled_from(["document", "assumed", "gyro_density_dps_rthz", "accel_rms_mg", "gyro_range_dps", "other"])


@FUZZ
@given(st.binary(max_size=80))
def test_any_bytes_are_refused_in_our_words(tmp_path, content):
    with pytest.raises(InputError):
        imu(write(tmp_path, content))


@FUZZ
@given(st.dictionaries(KEYS, VALUES, max_size=6))
def test_any_table_loads_or_is_refused_in_our_words(tmp_path, table):
    rows = [f"{key} = {str(value).lower()}" for key, value in table.items()]
    try:
        sensor = imu(write(tmp_path, "[imu.fuzz]\n" + "\n".join(rows)))
    except InputError:
        return
    assert sensor.gyro.sample_sd(100.0) > 0 and sensor.accel.sample_sd(100.0) > 0
