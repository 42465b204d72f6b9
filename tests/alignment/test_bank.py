"""The bank over a wind that changes: what the lines taught is kept, and C does what NumPy does."""

from dataclasses import replace

import numpy as np

from robustnav.alignment import align

from .conftest import FINE, Case, make_case, setup_of, tilt_of

CHANGE = 100.0  # s
BACKENDS = ("compiled", "numpy")


def changed(case: Case, seed: int) -> Case:
    """Return the case with a Gauss-Markov wind of 0.5 m/s and 4 s instead of its lines after the change."""
    other = make_case(case.setup, seed, float(case.t[-1]), "markov").reference
    return replace(case, reference=np.where(case.t[:, None] > CHANGE, other, case.reference))


def test_lines_that_end_leave_what_they_taught():
    """Good gyros hold the level that lines gave; a filter that never knew them has only what the new wind allows."""
    before, after, radius = [], [], []
    for seed in range(6):
        case = changed(make_case(setup_of(FINE), 80 + seed, 140.0, "lines"), seed)
        said = align(case.increments, case.reference, case.t, case.setup)
        size = np.linalg.norm(tilt_of(said.q_nb, case.q_nb), axis=1)
        stretch = case.t > CHANGE + 20
        before.append(size[(case.t > 50) & (case.t < CHANGE)].mean())
        after.append(size[stretch].mean())
        radius.append((size < said.tilt_radius)[stretch].mean())
    assert np.median(after) < 1.5 * np.median(before)
    assert np.mean(radius) > 0.8


def test_compiled_equals_numpy_where_lines_end():
    case = changed(make_case(setup_of(FINE, 0.5), 7, 122.0, "lines"), 3)
    compiled, numpy = (align(case.increments, case.reference, case.t, case.setup, backend=b) for b in BACKENDS)
    for field in ("q_nb", "tilt_cov", "heading", "wind"):
        np.testing.assert_allclose(getattr(compiled, field), getattr(numpy, field), rtol=1e-4, atol=1e-6, err_msg=field)
