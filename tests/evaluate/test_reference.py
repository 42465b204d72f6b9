import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.evaluate import reference_at
from robustnav.evaluate.reference import gaps
from robustnav.frames import quat_from_rotvec, quat_multiply, rotation_error
from robustnav.records import Truth

RATE_B = np.array([0.4, -0.3, 0.9])  # rad/s


def turning(t):
    """A constant body rate from a tilted start: slerp between its samples is exact."""
    return quat_multiply(quat_from_rotvec([0.3, -0.2, 2.9]), quat_from_rotvec(t[:, None] * RATE_B))


def test_slerp_is_exact_for_a_constant_rate_and_ignores_the_sign_of_q():
    t_ref = np.arange(0.0, 5.0, 0.1)
    q_ref = turning(t_ref) * np.where(np.arange(len(t_ref)) % 3 == 0, -1.0, 1.0)[:, None]
    t = np.linspace(0.0, 4.9, 333)
    got = reference_at(Truth(t_ref, q_ref), t)
    assert got.valid.all()
    np.testing.assert_allclose(rotation_error(got.q_nb, turning(t)), 0.0, atol=1e-13)


def test_reference_times_take_their_samples_bit_for_bit():
    t_ref = np.arange(0.0, 5.0, 0.1)
    q_ref = turning(t_ref)
    q_ref[7] = np.nan
    truth = Truth(t_ref, q_ref)
    np.testing.assert_array_equal(reference_at(truth, t_ref).q_nb, q_ref)
    some = t_ref[[0, 6, 7, 8, 49]]  # neighbours of the missing sample keep their own value
    np.testing.assert_array_equal(reference_at(truth, some).q_nb, q_ref[[0, 6, 7, 8, 49]])


def test_nothing_is_invented_outside_beside_nan_or_in_gaps():
    t_ref = np.array([0.0, 1.0, 2.0, 3.0, 6.0, 7.0, 10.1, 11.0])
    q_ref = turning(t_ref)
    q_ref[1] = np.nan
    t = np.array([-0.1, 0.5, 1.5, 2.5, 4.0, 6.5, 7.0, 8.0, 10.5, 11.1])
    valid = [False, False, False, True, True, True, True, False, True, False]  # 3 to 6 s is three median intervals
    assert reference_at(Truth(t_ref, q_ref), t).valid.tolist() == valid


def test_moving_is_that_of_the_nearest_sample():
    t_ref = np.arange(4.0)
    truth = Truth(t_ref, turning(t_ref), moving=np.array([False, True, True, False]))
    assert reference_at(truth, np.array([0.4, 0.6, 2.4, 2.6, 3.0])).moving.tolist() == [0, 1, 1, 0, 0]


@settings(deadline=None, max_examples=60)
@given(st.lists(st.sampled_from([0.0, 0.5, 1.0, 9.0]), min_size=1, max_size=12), st.integers(0, 2**32 - 1))
def test_any_time_grid_gives_unit_quaternions_or_nan(steps, seed):
    t_ref = np.cumsum(steps)
    t = np.sort(np.random.default_rng(seed).uniform(t_ref[0] - 1, t_ref[-1] + 1, 20))
    got = reference_at(Truth(t_ref, turning(t_ref)), t)
    np.testing.assert_allclose(np.linalg.norm(got.q_nb[got.valid], axis=1), 1.0, atol=1e-12)
    inside = (t >= t_ref[0]) & (t <= t_ref[-1])
    assert not got.valid[~inside].any()


@pytest.mark.parametrize("q", [None, np.zeros((0, 4))])
def test_a_truth_without_attitude_is_refused(q):
    with pytest.raises(InputError, match="no attitude"):
        reference_at(Truth(np.arange(0.0 if q is not None else 3.0), q), np.arange(3.0))


def test_a_reference_off_unit_norm_is_refused_with_its_row():
    t = np.arange(5.0)
    q = turning(t)
    q[3] *= 1.01
    with pytest.raises(InputError, match="row 3"):
        reference_at(Truth(t, q), t)


def test_a_gap_is_longer_than_three_median_intervals():
    t = np.cumsum([0.0, 1, 1, 1, 3, 1, 3.1, 1, 1])
    assert gaps(t).tolist() == [[7.0, pytest.approx(10.1)]]
    assert gaps(t[:1]).shape == (0, 2) and gaps(np.zeros(4)).shape == (0, 2)
