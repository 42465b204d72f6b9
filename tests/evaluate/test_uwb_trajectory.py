"""Alignment: what was turned is turned back, the fit is the best there is, mirrors and scales are no alignment."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.evaluate.trajectory import align, aligned_errors
from robustnav.frames import matrix_from_quat, quat_from_euler, quat_from_rotvec, quat_normalize
from robustnav.records import Stream

RNG = np.random.default_rng(11)


def path(n=40):
    return RNG.standard_normal((n, 3)) * [3.0, 2.0, 0.5] + [1.0, -2.0, 0.3]


def cost(C, a, b):
    off = (b - b.mean(axis=0)) - (a - a.mean(axis=0)) @ C.T
    return np.sum(off**2)


@pytest.mark.parametrize("k", range(5))
def test_what_was_turned_is_turned_back(k):
    p_a, shift = path(), np.array([4.0, 5.0, -6.0])
    C = matrix_from_quat(quat_normalize(RNG.standard_normal(4)))
    found = align(p_a, p_a @ C.T + shift)
    np.testing.assert_allclose(found.C_ra, C, atol=1e-12)
    np.testing.assert_allclose(found.shift, shift, atol=1e-11)
    yaw = matrix_from_quat(quat_from_euler([0, 0, 2.5]))
    np.testing.assert_allclose(align(p_a, p_a @ yaw.T, "yaw").C_ra, yaw, atol=1e-12)
    assert align(p_a, p_a @ yaw.T, "yaw").angle == pytest.approx(2.5)


@pytest.mark.parametrize(("turn", "axes"), [("full", np.eye(3)), ("yaw", np.eye(3)[2:])])
def test_no_turn_nearby_fits_better(turn, axes):
    p_a = path()
    p_ref = p_a @ matrix_from_quat(quat_from_euler([0.3, -0.2, 1.0])).T + 0.5 * RNG.standard_normal(p_a.shape)
    C = align(p_a, p_ref, turn).C_ra
    np.testing.assert_allclose(C @ C.T, np.eye(3), atol=1e-12)
    best = cost(C, p_a, p_ref)
    for axis in axes:
        for angle in (-1e-3, 1e-3):
            assert cost(matrix_from_quat(quat_from_rotvec(angle * axis)) @ C, p_a, p_ref) > best
    if turn == "yaw":
        assert best > cost(align(p_a, p_ref).C_ra, p_a, p_ref)
        np.testing.assert_array_equal(C[2], [0, 0, 1])


def test_neither_mirror_nor_scale_is_taken_for_an_alignment():
    p_a = path()
    mirrored = align(p_a, p_a * [1, 1, -1])
    assert np.linalg.det(mirrored.C_ra) == pytest.approx(1.0)
    flat = p_a * [1, 1, 0]
    assert np.linalg.det(align(flat, flat * [1, -1, 1]).C_ra) == pytest.approx(1.0)  # half a turn about x does it
    doubled = align(p_a, 2 * p_a)
    np.testing.assert_allclose(doubled.apply(p_a) - p_a.mean(axis=0) * 2, p_a - p_a.mean(axis=0), atol=1e-12)


def stream(t, values, frame="a"):
    return Stream("position", t, values, "m", frame)


def test_the_first_seconds_and_what_has_no_reference_do_not_count():
    t = np.arange(0.0, 20.0, 0.5)
    p = np.column_stack([np.cos(t), np.sin(2 * t), 0.1 * t])
    reference = stream(t, p, "vive")
    moved = np.column_stack([np.cos(t + 1) + 5.0, np.sin(2 * t + 2), 0.1 * t + 0.1])
    estimate = stream(t + 1.0, moved)
    found = aligned_errors(estimate, reference)
    assert (found.t[0], found.t[-1]) == (3.0, 19.5)
    assert np.abs(found.errors).max() < 1e-12
    np.testing.assert_allclose(found.alignment.shift, [-5, 0, 0], atol=1e-12)
    assert aligned_errors(estimate, reference, skip=0.0).t[0] == 1.0
    with pytest.raises(InputError, match="nothing to align"):
        aligned_errors(estimate, reference, skip=100.0)


def test_two_d_is_in_the_reference_axes():
    t = np.arange(0.0, 20.0, 0.1)
    p_ref = np.column_stack([np.cos(t), np.sin(2 * t), np.cos(0.7 * t)])
    error = np.column_stack([0 * t, 0 * t, 0.3 * np.sin(9 * t)])
    C = matrix_from_quat(quat_from_euler([np.pi / 2, 0, 0]))
    errors = aligned_errors(stream(t, (p_ref + error) @ C), stream(t, p_ref, "vive"), skip=0.0).errors
    assert np.abs(errors[:, :2]).max() < 0.03 < 0.25 < np.abs(errors[:, 2]).max()


@pytest.mark.parametrize(
    ("a", "b", "turn", "words"),
    [
        (np.zeros((3, 3)), np.zeros((4, 3)), "full", "same shape"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "full", "same shape"),
        (np.full((3, 3), np.nan), np.zeros((3, 3)), "yaw", "finite"),
        (np.outer(np.arange(5.0), [1, 2, 3]), np.outer(np.arange(5.0), [3, 2, 1]), "full", "on a line"),
        (np.zeros((3, 3)), np.zeros((3, 3)), "full", "on a line"),
        (np.outer(np.arange(5.0), [0, 0, 1]), np.outer(np.arange(5.0), [0, 0, 1]), "yaw", "horizontal"),
        (path(), path(), "scale", "full or yaw"),
    ],
)
def test_paths_that_determine_no_rotation_are_refused(a, b, turn, words):
    with pytest.raises(InputError, match=words):
        align(a, b, turn)
