"""Foreign tables through a mapping: one motion written in many conventions must come back as one."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import frd_from_flu, quat_conjugate, quat_from_rotvec, quat_multiply, quat_ned_from_enu
from robustnav.logs import read

RNG = np.random.default_rng(2)
Q_NB = quat_from_rotvec(RNG.standard_normal((20, 3)))
F_B = RNG.standard_normal((20, 3)) + np.array([0, 0, -9.8])
T = np.arange(20) * 0.01
FLU_TO_FRD = np.array([0.0, 1.0, 0.0, 0.0])


def write(tmp_path, columns, mapping, delimiter=",", before=""):
    names = list(columns)
    rows = zip(*columns.values(), strict=True)
    lines = [delimiter.join(names)] + [
        delimiter.join(x if isinstance(x, str) else repr(float(x)) for x in r) for r in rows
    ]
    (tmp_path / "foreign.csv").write_text(before + "\n".join(lines) + "\n", encoding="utf-8")
    (tmp_path / "map.toml").write_text(mapping, encoding="utf-8")
    return read(tmp_path / "foreign.csv", tmp_path / "map.toml")


TIME = '[time]\ncolumn = "t"\nunit = "s"\n'
ACCEL = '[accel]\ncolumns = ["a0", "a1", "a2"]\nunit = "{unit}"\nframe = "{frame}"\n'


def accel_columns(values):
    return {"t": T} | {f"a{k}": values[:, k] for k in range(3)}


@pytest.mark.parametrize(
    ("unit", "frame", "sign", "values"),
    [
        ("m/s^2", "FRD", 1, F_B),
        ("g", "FRD", 1, F_B / 9.80665),
        ("mg", "FLU", 1, frd_from_flu(F_B) / 9.80665e-3),
        ("m/s^2", "FLU", -1, -frd_from_flu(F_B)),
    ],
)
def test_sensor_conventions(tmp_path, unit, frame, sign, values):
    mapping = TIME + ACCEL.format(unit=unit, frame=frame) + f"sign = {sign}\n"
    log = write(tmp_path, accel_columns(values), mapping)
    np.testing.assert_allclose(log.streams["accel"].values, F_B, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(log.streams["accel"].t, T, atol=1e-12)
    assert log.streams["accel"].unit == "m/s^2"


@pytest.mark.parametrize("order", ["wxyz", "xyzw"])
@pytest.mark.parametrize("direction", ["body_to_world", "world_to_body"])
@pytest.mark.parametrize("body", ["FRD", "FLU"])
@pytest.mark.parametrize("world", ["NED", "ENU"])
def test_attitude_conventions(tmp_path, order, direction, body, world):
    q = quat_multiply(Q_NB, FLU_TO_FRD) if body == "FLU" else Q_NB  # the same turn, said of other axes
    q = quat_ned_from_enu(q) if world == "ENU" else q  # its own inverse up to sign
    q = quat_conjugate(q) if direction == "world_to_body" else q
    q = np.roll(q, -1, axis=1) if order == "xyzw" else q
    mapping = (
        TIME
        + ACCEL.format(unit="m/s^2", frame="FRD")
        + '[attitude]\ncolumns = ["q0", "q1", "q2", "q3"]\nnorth = "true"\nrole = "estimate"\nkind = "driver"\n'
        + f'order = "{order}"\ndirection = "{direction}"\nbody = "{body}"\nworld = "{world}"\n'
    )
    log = write(tmp_path, accel_columns(F_B) | {f"q{k}": q[:, k] for k in range(4)}, mapping)
    assert (log.truth, log.estimate.kind, log.estimate.north) == (None, "driver", "true")
    np.testing.assert_allclose(np.abs(np.sum(log.estimate.q_nb * Q_NB, axis=1)), 1, atol=1e-12)


def test_nanosecond_stamps_are_subtracted_exactly(tmp_path):
    stamps = [str(1_700_000_000_123_456_789 + 5_000_001 * k) for k in range(20)]
    mapping = TIME.replace('"s"', '"ns"') + ACCEL.format(unit="m/s^2", frame="FRD")
    log = write(tmp_path, accel_columns(F_B) | {"t": stamps}, mapping)
    assert log.origin_ns == 1_700_000_000_123_456_789
    np.testing.assert_allclose(log.streams["accel"].t, 5.000001e-3 * np.arange(20), rtol=1e-14)


def test_rate_instead_of_time_other_delimiter_and_lines_before(tmp_path):
    mapping = 'delimiter = ";"\nskip_lines = 2\n[time]\nrate_hz = 50.0\n' + ACCEL.format(unit="m/s^2", frame="FRD")
    columns = accel_columns(F_B)
    log = write(tmp_path, {"#note": T} | columns, mapping, ";", "made by\na device\n")
    np.testing.assert_allclose(log.streams["accel"].t, 0.02 * np.arange(20))
    assert log.skipped == ("column 'note': not in the mapping", "column 't': not in the mapping")


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        ("[time", "TOML"),
        ("# nothing", "time: Field required"),
        (TIME + '[accel]\ncolumns = ["a0"]\nunit = "m/s^2"\nframe = "up"\n', "accel.columns(.|\n)*accel.frame"),
        (TIME + ACCEL.format(unit="deg/s", frame="FRD"), "accel.unit 'deg/s'"),
        (TIME + ACCEL.format(unit="g", frame="FRD") + "colour = 1\n", "accel.colour"),
        (TIME, "no sensor"),
        (TIME + "rate_hz = 5.0\n" + ACCEL.format(unit="g", frame="FRD"), "column and unit, or rate_hz alone"),
        (TIME.replace('"t"', '"tt"') + ACCEL.format(unit="g", frame="FRD"), "'tt'"),
        ("[time]\nrate_hz = nan\n" + ACCEL.format(unit="g", frame="FRD"), "rate_hz"),
        ("[time]\nrate_hz = 1e-320\n" + ACCEL.format(unit="g", frame="FRD"), "rate_hz"),
    ],
)
def test_a_wrong_mapping_names_its_mistakes(tmp_path, mapping, words):
    with pytest.raises(InputError, match=words):
        write(tmp_path, accel_columns(F_B), mapping)


def test_decimal_commas_and_time_backwards_are_named(tmp_path):
    mapping = TIME + ACCEL.format(unit="m/s^2", frame="FRD")
    with pytest.raises(InputError, match=r"'a1' line 2(.|\n)*decimal point"):
        write(tmp_path, accel_columns(F_B) | {"a1": ['"1,5"'] * 20}, mapping)
    with pytest.raises(InputError, match="'t' line 3"):
        write(tmp_path, accel_columns(F_B) | {"t": T[::-1]}, mapping)
    with pytest.raises(InputError, match=r"'t' line 21(.|\n)*centuries"):
        write(tmp_path, accel_columns(F_B) | {"t": [*T[:-1], 1e300]}, mapping)


def test_a_mapping_for_another_format_is_refused(tmp_path):
    (tmp_path / "map.toml").write_text(TIME, encoding="utf-8")
    (tmp_path / "a.ulg").write_bytes(b"ULog\x01\x12\x35")
    with pytest.raises(InputError, match="needs none"):
        read(tmp_path / "a.ulg", tmp_path / "map.toml")
