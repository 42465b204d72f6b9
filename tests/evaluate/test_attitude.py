import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.evaluate import attitude_errors, evaluate
from robustnav.evaluate.attitude import NOT_AN_ERROR
from robustnav.frames import matrix_from_quat, quat_from_euler, quat_from_rotvec, quat_multiply, quat_normalize
from robustnav.records import Run, Truth
from robustnav.units import DEG


def run_of(t, q_nb):
    return Run("ekf", "ahrs", t, {"q_nb": q_nb}, {}, {})


def random_quats(n, seed=1):
    return quat_normalize(np.random.default_rng(seed).normal(size=(n, 4)))


def test_metric_equals_the_published_formulas():
    q_est, q_ref = random_quats(500, 1), random_quats(500, 2)
    errors = attitude_errors(run_of(np.arange(500.0), q_est), Truth(np.arange(500.0), q_ref))
    w, _, _, z = quat_multiply(q_est, q_ref * [1, -1, -1, -1]).T
    np.testing.assert_allclose(errors.total, 2 * np.arccos(np.abs(w)), atol=1e-7)
    np.testing.assert_allclose(np.abs(errors.heading), np.abs(2 * np.arctan(z / w)), atol=1e-12)
    np.testing.assert_allclose(errors.inclination, 2 * np.arccos(np.sqrt(w * w + z * z)), atol=1e-7)


def test_inclination_is_the_angle_between_the_two_verticals_and_total_the_trace_angle():
    q_est, q_ref = random_quats(200, 3), random_quats(200, 4)
    errors = attitude_errors(run_of(np.arange(200.0), q_est), Truth(np.arange(200.0), q_ref))
    C = matrix_from_quat(q_est) @ np.swapaxes(matrix_from_quat(q_ref), 1, 2)
    np.testing.assert_allclose(np.cos(errors.inclination), C[:, 2, 2], atol=1e-12)
    np.testing.assert_allclose(1 + 2 * np.cos(errors.total), np.trace(C, axis1=1, axis2=2), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(errors.rotvec_n, axis=1), errors.total, atol=1e-12)


@settings(deadline=None, max_examples=50)
@given(
    st.floats(-3.14, 3.14),
    st.floats(0, 3.14),
    st.floats(-3.14, 3.14),
    st.integers(0, 1000),
    st.sampled_from([1.0, -1.0]),
)
def test_a_turn_about_down_after_a_tilt_is_split_into_its_parts(heading, tilt, direction, seed, sign):
    axis = [tilt * np.cos(direction), tilt * np.sin(direction), 0.0]
    q_ref = random_quats(1, seed)
    q_error = quat_multiply(quat_from_rotvec([0.0, 0.0, heading]), quat_from_rotvec(axis))
    errors = attitude_errors(run_of(np.zeros(1), sign * quat_multiply(q_error, q_ref)), Truth(np.zeros(1), q_ref))
    np.testing.assert_allclose(errors.inclination, tilt, atol=1e-7)
    np.testing.assert_allclose(errors.heading, heading, atol=1e-7)


def test_a_half_turn_of_heading_is_180_degrees_not_nan():
    q_ref = np.array([[1.0, 0.0, 0.0, 0.0]])
    errors = attitude_errors(run_of(np.zeros(1), np.array([[0.0, 0.0, 0.0, 1.0]])), Truth(np.zeros(1), q_ref))
    np.testing.assert_allclose([errors.heading[0], errors.total[0], errors.inclination[0]], [np.pi, np.pi, 0.0])


def test_the_error_vector_is_in_navigation_axes():
    q_ref = random_quats(50)
    vector = np.array([1e-3, -2e-3, 3e-3])
    errors = attitude_errors(
        run_of(np.arange(50.0), quat_multiply(quat_from_rotvec(vector), q_ref)), Truth(np.arange(50.0), q_ref)
    )
    np.testing.assert_allclose(errors.rotvec_n, np.broadcast_to(vector, (50, 3)), atol=1e-14)


def test_known_angle_errors_come_back_in_degrees_and_wrap():
    t = np.arange(4.0)
    q_ref = quat_from_euler(np.array([[0.1, 0.2, 3.1]] * 4))
    offsets = np.array([[1.0, -2.0, 10.0], [1.0, 2.0, 10.0], [-1.0, 2.0, 10.0], [-1.0, 2.0, 10.0]]) * DEG
    score = evaluate(run_of(t, quat_from_euler(np.array([0.1, 0.2, 3.1]) + offsets)), Truth(t, q_ref))
    assert score.samples == 4
    expected = {"roll_rms_deg": 1, "roll_min_deg": -1, "pitch_min_deg": -2, "pitch_max_deg": 2, "yaw_rms_deg": 10}
    for name, value in expected.items():
        assert score.values[name] == pytest.approx(value, abs=1e-9)
    assert score.values["yaw_max_deg"] == pytest.approx(10, abs=1e-9)


def test_rms_over_the_samples_that_have_a_reference_only():
    t = np.arange(10.0)
    q_ref = np.tile([1.0, 0.0, 0.0, 0.0], (10, 1))
    q_est = quat_from_rotvec(np.outer(np.where(t < 5, 3.0, 4.0) * DEG, [0, 0, 1]))
    q_ref[8:] = np.nan
    score = evaluate(run_of(t, q_est), Truth(t, q_ref), skip=2.0)
    assert score.samples == 6
    assert score.values["total_deg"] == pytest.approx(np.sqrt((3 * 9 + 3 * 16) / 6))
    assert "2 s are left out" in score.notes[0]


def test_a_nan_estimate_fails_the_score_and_is_counted():
    t = np.arange(10.0)
    q = random_quats(10)
    q_est = q.copy()
    q_est[6] = np.nan
    score = evaluate(run_of(t, q_est), Truth(t, q))
    assert np.isnan([score.values[name] for name in ("total_deg", "heading_deg", "roll_rms_deg", "yaw_max_deg")]).all()
    assert score.values["nan_estimates"] == 1 and score.samples == 10
    assert "1 of 10 scored estimates are NaN, the first at 6.000 s" in score.notes[0]
    reference_missing_too = Truth(t, np.where(t[:, None] == 6, np.nan, q))
    assert evaluate(run_of(t, q_est), reference_missing_too).values["total_deg"] == pytest.approx(0, abs=1e-6)


def test_motion_is_scored_apart():
    t = np.arange(4.0)
    q_ref = np.tile([1.0, 0.0, 0.0, 0.0], (4, 1))
    q_est = quat_from_rotvec(np.outer([0.0, 0.0, 0.0, 8.0], [DEG, 0, 0]))
    score = evaluate(run_of(t, q_est), Truth(t, q_ref, moving=t >= 3))
    assert score.values["moving_share"] == 0.25
    assert score.values["moving_total_deg"] == pytest.approx(8.0)
    assert score.values["total_deg"] == pytest.approx(4.0)


def test_another_estimate_is_never_called_an_error():
    t = np.arange(4.0)
    assert NOT_AN_ERROR in evaluate(run_of(t, random_quats(4)), Truth(t, random_quats(4), kind="estimate")).notes
    assert evaluate(run_of(t, random_quats(4)), Truth(t, random_quats(4), kind="optical")).notes == ()


def test_a_run_in_euler_angles_scores_as_its_quaternions_do():
    t, angles = np.arange(5.0), np.random.default_rng(1).uniform(-1.4, 1.4, (5, 3))
    truth = Truth(t, random_quats(5))
    by_angles = evaluate(Run("ekf", "attitude_euler", t, {"euler": angles}, {}, {}), truth)
    assert by_angles == evaluate(run_of(t, quat_from_euler(angles)), truth)


def test_steep_pitch_warns_of_roll_and_yaw():
    t = np.arange(3.0)
    for pitch_deg, warned in ((70, False), (-80, True)):
        q = quat_from_euler(np.array([[0, pitch_deg * DEG, 0]] * 3))
        notes = evaluate(run_of(t, q), Truth(t, q)).notes
        assert any("pitch reaches 80 deg" in note for note in notes) is warned


def test_nothing_to_score_and_no_attitude_are_refused():
    t, q = np.arange(4.0), random_quats(4)
    with pytest.raises(InputError, match="nothing to score"):
        evaluate(run_of(t + 100, q), Truth(t, q))
    with pytest.raises(InputError, match="nothing to score"):
        evaluate(run_of(t[:0], q[:0]), Truth(t, q))
    with pytest.raises(InputError, match="state blocks p_n"):
        evaluate(Run("kf", "uwb", t, {"p_n": np.zeros((4, 3))}, {}, {}), Truth(t, q))
    with pytest.raises(InputError, match="norm 2"):
        evaluate(run_of(t, 2 * q), Truth(t, q))
