"""What is exported is what ran in Python: every form, in every number type, and nothing a compiler warns of."""

import subprocess

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.export import export
from robustnav.export.build import build
from robustnav.export.scaling import Counts
from robustnav.export.vectors import Plan, down_of, record
from robustnav.filter.weighting import Gate
from robustnav.frames import quat_from_euler
from robustnav.models import uwb
from robustnav.run import EKF, H2, UKF
from robustnav.run.inclination import LevelH2
from robustnav.studies.attitude_setting import euler_model, noise, quaternion_model

from .conftest import MAKE, REALS


@pytest.mark.parametrize(("name", "real"), REALS)
def test_the_c_does_what_python_did(name, real, replayed):
    said = replayed(name, real)
    assert said.code == 0
    assert said.worst < 1.0
    assert said.refused == (1 if name == "robust" else 0)  # the one reading its gate refuses


@pytest.mark.parametrize("name", ["mekf", "ranges", "robust"])
def test_in_double_a_kalman_filter_is_python_s(name, replayed):
    assert replayed(name, "double").worst * 2e-4 < 1e-7  # the attitude half-way is a mean, refused by nothing finer


def test_vectors_use_every_set_of_sensors():
    estimator = MAKE["nine"]()
    setup = estimator.setup(estimator.model.nominal_state(), np.eye(6))
    seen = record(estimator.model, setup, Plan(100.0))
    assert set(seen.present) == {0, 1, 2, 3}
    assert np.abs(seen.u).max() > 0.5
    assert np.array_equal(seen.x.astype(np.float32).shape, (320, 7))


def test_down_is_the_third_row():
    q = quat_from_euler(np.array([0.3, -0.2, 1.0]))
    down = down_of(np.r_[q, np.zeros(3)][None])[0, :3]
    np.testing.assert_allclose(down, [np.sin(0.2), np.sin(0.3) * np.cos(0.2), np.cos(0.3) * np.cos(0.2)])


def test_the_example_and_cmake_are_whole(exported, compiler):
    one = exported("nine", "float")
    program = one.folder / "example"
    command = [
        *compiler,
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-O2",
        "example.c",
        "rn_nine.c",
        "-o",
        str(program),
    ]
    subprocess.run(command, cwd=one.folder, check=True)
    said = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    assert len(said.splitlines()) == 4
    assert "add_library(rn_nine STATIC rn_nine.c)" in (one.folder / "CMakeLists.txt").read_text()


def test_nothing_needs_the_maths_library(exported, compiler):
    for name in ("nine", "level", "mekf"):
        one = exported(name, "float")
        target = one.folder / "alone.o"
        subprocess.run(
            [*compiler, "-std=c99", "-O2", "-c", f"rn_{name}.c", "-o", str(target)], cwd=one.folder, check=True
        )
        wanted = subprocess.run(["nm", "-u", str(target)], capture_output=True, text=True, check=True).stdout
        assert not [w for w in wanted.split() if w not in ("U", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail")], name


def test_export_writes_a_tree(tmp_path):
    done = export(MAKE["nine"](), tmp_path / "ahrs", name="ahrs", measure=False)
    assert set(done.files) == {p.name for p in done.folder.iterdir()}
    text = (done.folder / "ahrs.h").read_text()
    for said in ("q_nb[4]", "m/s^2", "rad/s", "int ahrs_reset(", "int ahrs_restore(", "AHRS_REFUSED"):
        assert said in text
    assert "benchmark mcu" in (done.folder / "README.md").read_text()


@pytest.mark.parametrize(
    ("make", "options", "says"),
    [
        (MAKE["nine"], {"real": "half"}, "float, double, int32"),
        (MAKE["nine"], {"name": "No Good"}, "lower-case"),
        (MAKE["nine"], {"rate_hz": float("nan")}, "rate above zero"),
        (MAKE["mekf"], {"real": "int32"}, "constant gain"),
        (MAKE["nine_staged"], {"real": "int32"}, "start_sd"),
        (lambda: UKF(quaternion_model(noise(100))), {}, "EKF on any model"),
        (lambda: H2(euler_model(noise(100)), 100.0), {}, "EKF on any model"),
        (MAKE["nine"], {"real": "int32", "rate_hz": 5.0}, "integer export"),
    ],
)
def test_what_has_no_c_form_is_refused(make, options, says, tmp_path):
    with pytest.raises(InputError, match=says):
        export(make(), tmp_path / "x", measure=False, **options)
    assert not (tmp_path / "x").exists()


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="a file"):
        export(MAKE["level"](), tmp_path / "taken", measure=False)


def test_counts_are_sizes():
    with pytest.raises(InputError, match="counts: mag"):
        Counts(mag=0.0)


def test_level_is_for_inclination_alone():
    with pytest.raises(InputError, match=r"models\.inclination"):
        LevelH2(quaternion_model(noise(100)), 100.0)


def test_a_covariance_filter_of_a_plain_rule_has_fewer_rows():
    """Two rows that see the same direction are one, unless a rule has to weigh the reading."""
    plain, _ = build(MAKE["mekf"](), "a", "float", 100.0)
    gated, _ = build(EKF(quaternion_model(noise(100)), {"mag": Gate(20.0)}), "a", "float", 100.0)
    assert "inverse_2" not in plain.source
    assert "inverse_2" in gated.source
    assert "time_offset" not in build(EKF(uwb(range_sd=0.1, acceleration_density=1.0)), "a", "float", 100.0)[0].source
