"""The bank that is told the wind's lines: finds north from nothing, says nothing before its choice, and is refused."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.alignment.heading_bank import HeadingBank, heading_bank
from robustnav.errors import InputError
from robustnav.frames import euler_from_quat, wrap_angle
from robustnav.units import ARCMIN, DEG

from .conftest import FINE, make_case, setup_of, tilt_of

BANK = HeadingBank((0.5, 1.0, 2.0), judged=45.0)


def test_finds_north_from_nothing_and_is_honest():
    errors = []
    for seed in range(12):
        case = make_case(setup_of(FINE), 60 + seed, 100.0, "lines")
        z = np.column_stack([case.reference, np.zeros(len(case.t))])
        found = heading_bank(case.increments, z, case.setup, BANK)
        assert np.isnan(found.q_nb[:450]).all() and np.isfinite(found.q_nb[450:]).all()
        assert found.costs.shape == (12,)
        tilt = tilt_of(found.q_nb[-1:], case.q_nb[-1:])[0]
        heading = wrap_angle(euler_from_quat(case.q_nb[-1])[2] - euler_from_quat(found.q_nb[-1])[2])
        e = np.array([*tilt, heading])
        errors.append([np.linalg.norm(tilt), abs(heading), e @ np.linalg.solve(found.P[-1], e)])
    size, heading, nees = np.array(errors).T
    assert np.median(size) < 1.2 * ARCMIN
    assert heading.max() < 2 * DEG
    assert nees.mean() < 6.0  # 3 expected, twelve runs


def test_bad_input_is_refused():
    case = make_case(setup_of(FINE), 60, 10.0, "none")
    z = np.zeros((len(case.t), 3))
    with pytest.raises(InputError, match="450 at least"):
        heading_bank(case.increments, z, case.setup, BANK)
    with pytest.raises(InputError, match="heading bank"):
        heading_bank(case.increments, z[:-1], case.setup, replace(BANK, judged=5.0))
