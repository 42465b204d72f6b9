"""Rotations against matrix products and SciPy, whose code and quaternion order are not ours."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from robustnav import frames

NED_FROM_ENU = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]])
FRD_FROM_FLU = np.diag([1.0, -1.0, -1.0])

vectors = hnp.arrays(float, 3, elements=st.floats(-10, 10))
raw = hnp.arrays(float, 4, elements=st.floats(-1, 1)).filter(lambda q: np.linalg.norm(q) > 1e-3)
quaternions = raw.map(lambda q: q / np.linalg.norm(q))
angles = st.floats(-3.0, 3.0)
HALF_TURN = np.array([0.0, 0.6, 0.0, 0.8])


def scipy_of(q):
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def assert_same_rotation(a, b, atol=1e-12):
    np.testing.assert_allclose(frames.matrix_from_quat(a), frames.matrix_from_quat(b), atol=atol)


@given(vectors, vectors)
def test_skew_is_the_cross_product(a, b):
    np.testing.assert_allclose(frames.skew(a) @ b, np.cross(a, b), atol=1e-12)
    np.testing.assert_array_equal(frames.skew(a), -frames.skew(a).T)


@given(quaternions)
def test_matrix_is_scipys_and_a_rotation(q):
    C = frames.matrix_from_quat(q)
    np.testing.assert_allclose(C, scipy_of(q).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(C @ C.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(C) == pytest.approx(1)


@given(quaternions, quaternions)
def test_product_of_quaternions_is_product_of_matrices(a, b):
    product = frames.matrix_from_quat(frames.quat_multiply(a, b))
    np.testing.assert_allclose(product, frames.matrix_from_quat(a) @ frames.matrix_from_quat(b), atol=1e-12)


@given(quaternions)
def test_conjugate_is_the_inverse(q):
    np.testing.assert_allclose(frames.quat_multiply(q, frames.quat_conjugate(q)), [1, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(
        frames.matrix_from_quat(frames.quat_conjugate(q)), frames.matrix_from_quat(q).T, atol=1e-12
    )


@given(raw)
def test_normalize_keeps_direction(q):
    out = frames.quat_normalize(q)
    assert np.linalg.norm(out) == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(out * np.linalg.norm(q), q, atol=1e-15)


@given(quaternions)
@example(HALF_TURN)
@example(np.array([0.0, 1.0, 0.0, 0.0]))
@example(np.array([0.0, 0.0, 1.0, 0.0]))
@example(np.array([0.0, 0.0, 0.0, 1.0]))
def test_matrix_and_back(q):
    back = frames.quat_from_matrix(frames.matrix_from_quat(q))
    assert back[0] >= 0
    assert_same_rotation(back, q)


@given(vectors)
@example(np.zeros(3))
@example(np.array([1e-8, 0, 0]))
@example(np.array([1e-300, 0, 0]))
@example(np.array([0, np.pi, 0]))
def test_exp_is_scipys(v):
    assert_same_rotation(frames.quat_from_rotvec(v), np.roll(Rotation.from_rotvec(v).as_quat(), 1))


@given(vectors.map(lambda v: v / max(1.0, np.linalg.norm(v) / 3.1)))
@example(np.zeros(3))
@example(np.array([1e-8, 2e-8, 0]))
@example(np.array([1e-12, 0, 0]))
def test_log_undoes_exp(v):
    np.testing.assert_allclose(frames.rotvec_from_quat(frames.quat_from_rotvec(v)), v, rtol=1e-10, atol=1e-15)


@given(quaternions)
@example(HALF_TURN)
@example(-HALF_TURN)
def test_log_is_the_short_way_and_ignores_the_sign(q):
    v = frames.rotvec_from_quat(q)
    assert np.linalg.norm(v) <= np.pi + 1e-12
    assert_same_rotation(frames.quat_from_rotvec(v), q)
    assert_same_rotation(frames.quat_from_rotvec(frames.rotvec_from_quat(-q)), q)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_euler_angles_are_yaw_then_pitch_then_roll(roll, pitch, yaw):
    q = frames.quat_from_euler([roll, pitch, yaw])
    assert_same_rotation(q, np.roll(Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat(), 1))
    np.testing.assert_allclose(frames.euler_from_quat(q), [roll, pitch, yaw], atol=1e-9)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_euler_angles_straight_up_stay_finite(pitch):
    euler = frames.euler_from_quat(frames.quat_from_euler([0.3, pitch, 0.5]))
    assert euler[1] == pytest.approx(pitch, abs=1e-7)


@pytest.mark.parametrize(
    ("euler_deg", "body", "n"),
    [((0, 0, 90), (1, 0, 0), (0, 1, 0)), ((0, 90, 0), (1, 0, 0), (0, 0, -1)), ((90, 0, 0), (0, 1, 0), (0, 0, 1))],
)
def test_signs_by_hand(euler_deg, body, n):
    """Heading east points the nose east; pitching up raises it; rolling right drops the right wing."""
    np.testing.assert_allclose(frames.rotate(frames.quat_from_euler(np.radians(euler_deg)), body), n, atol=1e-15)


@given(quaternions, vectors)
def test_rotate_is_the_matrix(q, v):
    np.testing.assert_allclose(frames.rotate(q, v), scipy_of(q).apply(v), atol=1e-11)


@given(quaternions, vectors.map(lambda v: v / 10))
def test_rotation_error_is_in_navigation_axes(q, v):
    error = frames.rotation_error(frames.quat_multiply(frames.quat_from_rotvec(v), q), q)
    np.testing.assert_allclose(error, v, atol=1e-9)


@pytest.mark.parametrize("size", [0.0, 1e-3, 0.0999, 0.1001, 1.0, 3.0])
def test_left_jacobian_is_the_derivative_of_exp(size):
    """Of the turn that takes Exp(r) to Exp(r + d), by differences; the right one is that of -r."""
    r = size * np.array([[0.6, -0.64, 0.48], [0.0, 0.6, 0.8]])
    for sign in (1, -1):
        columns = []
        for d in 1e-5 * np.eye(3):
            turned = [scipy_of(frames.quat_from_rotvec(r + s * d)) for s in (1, -1)]
            off = turned[0] * turned[1].inv() if sign > 0 else turned[1].inv() * turned[0]
            columns.append(off.as_rotvec() / 2e-5)
        np.testing.assert_allclose(frames.left_jacobian(sign * r), np.stack(columns, axis=-1), atol=1e-8)


@given(st.floats(-100, 100))
@example(np.pi)
@example(-np.pi)
def test_wrapped_angles_lie_in_one_turn(angle):
    wrapped = float(frames.wrap_angle(angle))
    assert -np.pi <= wrapped < np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-12)


@given(quaternions)
def test_conversions_are_matrix_products(q):
    C = frames.matrix_from_quat(q)
    both = frames.matrix_from_quat(frames.quat_ned_frd_from_enu_flu(q))
    np.testing.assert_allclose(both, NED_FROM_ENU @ C @ FRD_FROM_FLU, atol=1e-12)
    world = frames.matrix_from_quat(frames.quat_ned_from_enu(q))
    np.testing.assert_allclose(world, NED_FROM_ENU @ C, atol=1e-12)
    assert_same_rotation(frames.quat_ned_frd_from_enu_flu(frames.quat_ned_frd_from_enu_flu(q)), q)


@given(vectors)
def test_vector_conversions_are_matrix_products(v):
    np.testing.assert_array_equal(frames.ned_from_enu(v), NED_FROM_ENU @ v)
    np.testing.assert_array_equal(frames.frd_from_flu(v), FRD_FROM_FLU @ v)


@given(quaternions, st.floats(-1.2, 1.2), st.floats(1e-6, 1e3))
def test_triad_finds_the_attitude_of_a_resting_unit(q, dip, strength):
    field_n = strength * np.array([np.cos(dip), 0, np.sin(dip)])
    f_b = frames.rotate(frames.quat_conjugate(q), [0, 0, -9.8])
    m_b = frames.rotate(frames.quat_conjugate(q), field_n)
    assert_same_rotation(frames.triad(f_b, m_b), q, atol=1e-9)


def test_triad_takes_gravity_as_exact():
    """The field settles the heading only: a wrong dip leaves roll and pitch alone."""
    q = frames.quat_from_euler([0.3, -0.2, 0.0])
    f_b = frames.rotate(frames.quat_conjugate(q), [0, 0, -9.8])
    for dip in (-1.0, 0.0, 1.2):
        m_b = frames.rotate(frames.quat_conjugate(q), [np.cos(dip), 0, np.sin(dip)])
        np.testing.assert_allclose(frames.euler_from_quat(frames.triad(f_b, m_b)), [0.3, -0.2, 0.0], atol=1e-12)


ONE = [frames.quat_conjugate, frames.quat_normalize, frames.rotvec_from_quat, frames.matrix_from_quat,
       frames.euler_from_quat, frames.quat_ned_frd_from_enu_flu, frames.quat_ned_from_enu]  # fmt: skip


@pytest.mark.parametrize("function", ONE, ids=lambda f: f.__name__)
def test_arrays_of_any_shape_are_each_row_on_its_own(function):
    q = frames.quat_normalize(np.random.default_rng(1).normal(size=(2, 3, 4)))
    whole = function(q)
    for i in np.ndindex(2, 3):
        np.testing.assert_allclose(whole[i], function(q[i]), atol=1e-15)
