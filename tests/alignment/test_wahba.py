"""Attitude from integrated velocities: exact where nothing errs, refused where nothing can be said."""

import numpy as np
import pytest

from robustnav.alignment.wahba import wahba_attitude
from robustnav.errors import InputError
from robustnav.frames import quat_conjugate, quat_multiply
from robustnav.strapdown import Place, carry
from robustnav.units import DEG

from .conftest import attitude, increments_at_rest, make_case, setup_of, tilt_of


def angle(a, b):
    return 2 * np.linalg.norm(quat_multiply(a, quat_conjugate(b))[1:])


@pytest.mark.parametrize("latitude", [0.0, 32 * DEG, -75 * DEG])
@pytest.mark.parametrize("heading", [0.3, 3.0])
def test_exact_without_errors(latitude, heading):
    """The Earth's turn alone tells heading; half a minute of it, and a base that moves besides."""
    setup, n = setup_of(latitude=latitude), 300
    q = attitude(0.1 * np.arange(n + 1), heading)
    inc, place = increments_at_rest(setup, q, np.zeros((n, 3)), np.zeros((n, 3))), Place.at(latitude)
    assert angle(wahba_attitude(inc, np.zeros((n + 1, 3)), place), q[-1]) < 2e-6
    # the same increments, a start that moves: the reference then shows what the strapdown says
    q_nb, v_n = carry(q[0], np.array([3.0, -2.0, 0.5]), inc, place)
    assert angle(wahba_attitude(inc, v_n, place), q_nb[-1]) < 1e-5


def test_levels_in_the_wind():
    case = make_case(setup_of(), 5, 30.0, "lines")
    z = np.column_stack([case.reference, np.zeros(len(case.t))])
    found = wahba_attitude(case.increments, np.vstack([z[:1], z]), Place.at(case.setup.latitude))
    assert np.linalg.norm(tilt_of(found[None], case.q_nb[-1:])) < 0.5 * DEG


def test_bad_input_is_refused():
    case = make_case(setup_of(), 5, 1.0, "none")
    place = Place.at(case.setup.latitude)
    with pytest.raises(InputError, match="reference velocity of a window"):
        wahba_attitude(case.increments, np.zeros((10, 3)), place)
    with pytest.raises(InputError, match="finite"):
        wahba_attitude(case.increments, np.full((11, 3), np.nan), place)
    with pytest.raises(InputError, match="window"):
        wahba_attitude(case.increments.between(0, 1), np.zeros((2, 3)), place)
