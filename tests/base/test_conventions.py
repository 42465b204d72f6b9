"""The closed forms of docs/conventions.md against products of matrices, and its noise rules against simulated noise."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from robustnav import frames
from robustnav.datasheet.sensors import SensorSpec

PAGE = (Path(__file__).parents[2] / "docs" / "conventions.md").read_text()
NED_FROM_ENU = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]])
FLIP = np.diag([1.0, -1.0, -1.0])  # FRD from FLU, and NED from north-west-up
MATRICES = {"a": (NED_FROM_ENU, FLIP), "b": (NED_FROM_ENU, np.eye(3)), "c": (FLIP, np.eye(3)), "d": (FLIP, FLIP)}

quaternions = (
    hnp.arrays(float, 4, elements=st.floats(-1, 1))
    .filter(lambda q: np.linalg.norm(q) > 1e-3)
    .map(lambda q: q / np.linalg.norm(q))
)


def closed_form(row: str):
    """The formula as the page prints it."""
    formula = re.search(rf"^\| \({row}\) \|[^|]*\| `([^`]*)` \|", PAGE, re.MULTILINE).group(1)
    scale, numbers = re.fullmatch(r"(s )?\((.*)\)", formula).groups()
    code = compile(f"[{numbers}]", row, "eval")
    factor = np.sqrt(0.5) if scale else 1.0
    return lambda q: factor * np.array(eval(code, {}, dict(zip("wxyz", q, strict=True))))


@pytest.mark.parametrize("row", "abcd")
@given(q=quaternions)
def test_closed_forms_are_matrix_products(row, q):
    world, body = MATRICES[row]
    expected = world @ frames.matrix_from_quat(q) @ body
    form = closed_form(row)
    np.testing.assert_allclose(frames.matrix_from_quat(form(q)), expected, atol=1e-12)
    np.testing.assert_allclose(frames.matrix_from_quat(form(form(q))), frames.matrix_from_quat(q), atol=1e-12)


@given(q=quaternions)
def test_the_functions_are_the_page(q):
    for function, row in ((frames.quat_ned_frd_from_enu_flu, "a"), (frames.quat_ned_from_enu, "b")):
        np.testing.assert_allclose(
            frames.matrix_from_quat(function(q)), frames.matrix_from_quat(closed_form(row)(q)), atol=1e-12
        )


@given(q=quaternions)
def test_scipy_is_reordered_and_matlab_conjugated(q):
    scipy = Rotation.from_quat(q, scalar_first=True)
    np.testing.assert_allclose(scipy.as_matrix(), frames.matrix_from_quat(q), atol=1e-12)
    np.testing.assert_array_equal(np.roll(scipy.as_quat(), 1), scipy.as_quat(scalar_first=True))
    frame_rotation = frames.matrix_from_quat(q).T  # takes navigation vectors to body
    np.testing.assert_allclose(frames.matrix_from_quat(frames.quat_conjugate(q)), frame_rotation, atol=1e-12)


@given(yaw=st.floats(-3, 3))
def test_heading_of_an_east_north_up_attitude(yaw):
    flu_to_enu = np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])
    ours = frames.euler_from_quat(frames.quat_ned_frd_from_enu_flu(flu_to_enu))
    assert frames.wrap_angle(ours[2] - (np.pi / 2 - yaw)) == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(ours[:2], 0, atol=1e-9)


def resting_unit():
    """A unit at rest, neither level nor heading north: q_nb, specific force [g] and field, FRD."""
    q_nb = frames.quat_from_euler(np.radians([20.0, -15.0, 130.0]))
    f_b, m_b = (frames.rotate(frames.quat_conjugate(q_nb), v) for v in ([0, 0, -1.0], [20.0, 0.0, 43.0]))
    return q_nb, f_b, m_b


def assert_within(q, q_nb, deg):
    assert np.degrees(np.linalg.norm(frames.rotation_error(q, q_nb))) < deg


def test_vqf_itself_says_b():
    vqf = pytest.importorskip("vqf")
    q_nb, f_b, m_b = resting_unit()
    samples = (np.tile(v, (2000, 1)) for v in (np.zeros(3), 9.81 * f_b, m_b))
    theirs = vqf.VQF(0.01).updateBatch(*samples)["quat9D"][-1]
    assert_within(closed_form("b")(theirs), q_nb, deg=0.01)


@pytest.mark.parametrize(("world", "row"), [("NED", None), ("ENU", "b"), ("NWU", "c")])
def test_imufusion_itself_says(world, row):
    imufusion = pytest.importorskip("imufusion")
    settings, ahrs = imufusion.AhrsSettings(), imufusion.Ahrs()
    settings.convention, settings.gain, settings.sample_rate = getattr(imufusion, f"CONVENTION_{world}"), 5.0, 100.0
    ahrs.set_settings(settings)
    q_nb, f_b, m_b = resting_unit()
    for _ in range(3000):
        ahrs.update(np.zeros(3), f_b, m_b)
    theirs = np.array(ahrs.get_quaternion(), float)
    assert_within(closed_form(row)(theirs) if row else theirs, q_nb, deg=0.01)


def test_specific_force_of_a_level_unit_points_up():
    q_nb = frames.quat_from_euler([0.0, 0.0, 1.0])
    gravity_n = np.array([0.0, 0.0, 9.81])
    np.testing.assert_allclose(-frames.rotate(frames.quat_conjugate(q_nb), gravity_n), [0, 0, -9.81], atol=1e-12)


def test_one_sided_data_sheet_density_gives_sample_noise_and_random_walk():
    """White samples of sd N sqrt(f/2): their one-sided spectrum is N, their integral has variance (N^2/2) t."""
    density, rate_hz, n, runs = 0.02, 200.0, 400, 4000
    sd = SensorSpec(density=density).sample_sd(rate_hz)
    assert sd == pytest.approx(density * np.sqrt(rate_hz / 2))
    noise = np.random.default_rng(4).normal(0, sd, (runs, n))
    spectrum = 2 * np.mean(np.abs(np.fft.rfft(noise)[:, 1:-1]) ** 2) / (n * rate_hz)  # one-sided, per hertz
    angle = noise.sum(axis=1) / rate_hz
    five_sd = 5 * np.sqrt(2 / runs)
    assert np.sqrt(spectrum) == pytest.approx(density, rel=0.01)
    assert np.var(angle) == pytest.approx(density**2 / 2 * n / rate_hz, rel=five_sd)
    two_sided = sd / np.sqrt(rate_hz)
    assert two_sided == pytest.approx(density / np.sqrt(2))


@pytest.mark.parametrize("source", ["PX4", "ArduPilot", "ROS", "vqf", "imufusion", "ahrs", "MATLAB", "SciPy"])
def test_the_page_names_each_source(source):
    assert re.search(rf"^\| {source}\b", PAGE, re.MULTILINE)
