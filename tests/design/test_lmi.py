import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from robustnav.design import (
    Plant,
    h2_lmi,
    h2_lmi_polytope,
    h2_lmi_structured,
    h2_riccati,
    hinf_lmi,
    hinf_observer,
    verify_h2,
)
from robustnav.design.lmi import _bound
from robustnav.errors import EstimatorError, InputError, MissingExtra
from robustnav.units import DEG, DPS


@pytest.fixture(autouse=True)
def _needs_cvxpy(request):
    if "without_cvxpy" not in request.node.name:
        pytest.importorskip("cvxpy", reason="the LMI designs need the extra 'lmi'")


def relative(L, reference):
    return np.abs(L - reference).max() / np.abs(reference).max()


def test_without_cvxpy_the_extra_is_named(plant, monkeypatch):
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    with pytest.raises(MissingExtra, match="lmi"):
        h2_lmi(plant)


def test_equals_the_riccati_gain(plant):
    nominal = h2_riccati(plant)
    design = h2_lmi(plant)
    assert relative(design.L, nominal.L) < 1e-6
    assert design.gamma == pytest.approx(nominal.gamma, rel=1e-8)
    assert np.allclose(design.P, nominal.P, rtol=1e-5, atol=1e-5 * np.abs(nominal.P).max())


def test_scaling_from_expected_deviations_is_enough(plant):
    rough = np.array([0.01 * DEG] * 3 + [1e-3 * DPS] * 3)
    assert relative(h2_lmi(plant, rough).L, h2_riccati(plant).L) < 1e-5


def test_bad_scaling_is_caught_not_returned(plant):
    with pytest.raises(EstimatorError):
        h2_lmi(plant, np.ones(6))


@pytest.mark.parametrize("seed", range(2))
def test_equals_riccati_with_cross_noise(random_plant, seed):
    """The norm is flat at its optimum, so the gain itself is found to the root of the solver's gap."""
    plant = random_plant(seed)
    nominal, design = h2_riccati(plant), h2_lmi(plant)
    assert design.certificate.verified == pytest.approx(nominal.gamma, rel=1e-8)
    assert relative(design.L, nominal.L) < 1e-3


def test_sparse_pattern_of_the_optimum_costs_nothing(plant):
    """Roll and yaw, and pitch, read different rows: the optimum itself has this pattern of 14 entries in 36."""
    nominal = h2_riccati(plant)
    pattern = np.zeros((6, 6), bool)
    pattern[np.ix_([0, 2, 3, 5], [1, 4])] = True
    pattern[np.ix_([1, 4], [0, 3, 5])] = True
    design = h2_lmi_structured(plant, pattern)
    assert np.all(design.L[~pattern] == 0)
    assert np.count_nonzero(design.L) == 14
    assert design.gamma == pytest.approx(nominal.gamma, rel=1e-5)
    assert relative(design.L, nominal.L) < 1e-4


def test_magnetometer_on_heading_only(plant):
    pattern = np.zeros((6, 6), bool)
    pattern[np.ix_([0, 3], [1])] = pattern[np.ix_([1, 4], [0])] = pattern[np.ix_([2, 5], [4])] = True
    design = h2_lmi_structured(plant, pattern)
    assert np.all(design.L[~pattern] == 0)
    best = h2_riccati(plant).gamma
    assert best <= design.certificate.verified <= design.gamma < 1.05 * best


def test_impossible_pattern_is_refused(plant):
    pattern = np.ones((6, 6), bool)
    pattern[2] = pattern[5] = False
    with pytest.raises(EstimatorError):
        h2_lmi_structured(plant, pattern)


def test_structured_bad_input(plant, random_plant):
    with pytest.raises(InputError, match="pattern"):
        h2_lmi_structured(plant, np.ones((2, 2)))
    with pytest.raises(InputError, match="correlated"):
        h2_lmi_structured(random_plant(0), np.ones((4, 2)))


def field_at(make_plant, dip_deg, strength=48e-6):
    return make_plant(field_n=strength * np.array([np.cos(dip_deg * DEG), 0.0, np.sin(dip_deg * DEG)]))


def test_polytope_bound_holds_in_the_hull(make_plant):
    low, high = field_at(make_plant, 50), field_at(make_plant, 70)
    design = h2_lmi_polytope([low, high])
    assert all(certificate.ok for certificate in design.certificates)
    for share in np.linspace(0, 1, 11):
        inside = replace(low, C_y=(1 - share) * low.C_y + share * high.C_y)
        certificate = verify_h2(inside, design.L, design.gamma)
        assert certificate.ok
        assert certificate.verified >= h2_riccati(inside).gamma * (1 - 1e-9)
    worst = max(h2_riccati(p).gamma for p in (low, high))
    assert worst <= design.gamma < 1.2 * worst


def test_polytope_beats_the_gain_of_the_wrong_vertex(make_plant):
    """The point of it: the dip-30 gain fails its promise at dip 80; the common gain does not."""
    low, high = field_at(make_plant, 30), field_at(make_plant, 80)
    design = h2_lmi_polytope([low, high])
    wrong = verify_h2(high, h2_riccati(low).L, design.gamma)
    assert wrong.verified > design.gamma >= max(c.verified for c in design.certificates)


def test_polytope_of_one_is_the_nominal_design(plant):
    assert h2_lmi_polytope([plant]).gamma == pytest.approx(h2_riccati(plant).gamma, rel=1e-5)


def test_polytope_without_common_gain(plant):
    mirrored = replace(plant, C_y=-plant.C_y)
    with pytest.raises(EstimatorError):
        h2_lmi_polytope([plant, mirrored])


def test_polytope_bad_input(plant, random_plant):
    with pytest.raises(InputError, match="polytope"):
        h2_lmi_polytope([])
    with pytest.raises(InputError, match="polytope"):
        h2_lmi_polytope([plant, random_plant(0)])


def test_hinf_lmi_equals_the_central_riccati_design(plant):
    design = hinf_lmi(plant)
    assert design.gamma == pytest.approx(hinf_observer(plant).gamma, rel=1e-5)
    assert relative(design.L, hinf_observer(plant, gamma=design.gamma).L) < 1e-4


def test_bound_is_proved_by_the_matrix_not_by_its_size(random_plant):
    """P^-1 of the closed loop proves its exact norm, in any multiple; any other matrix proves less."""
    plant = random_plant(2)
    design = h2_riccati(plant)
    X = np.linalg.inv(design.P)
    for size in (0.1, 1.0, 30.0):
        assert _bound([plant], size * X, design.L) == pytest.approx(design.gamma, rel=1e-8)
    F, B = plant.closed_loop(design.L)
    more_noise = solve_continuous_lyapunov(F, -B @ B.T - np.eye(4))
    assert _bound([plant], np.linalg.inv(more_noise), design.L) > 1.001 * design.gamma
    with pytest.raises(EstimatorError, match="proves nothing"):
        _bound([plant], X, -design.L)


def test_conservatism_of_a_structure_is_bounded_and_visible():
    """Each state on its own output, coupled dynamics and noise: the proof stays within 1.4 of the free optimum."""
    A = np.array([[-0.5, 1.0, 0.3], [-0.8, -0.4, 0.6], [0.2, -0.9, -0.3]])
    B = np.array([[1.0, 0.9, 0.0], [0.9, 1.0, 0.5], [0.0, 0.5, 1.0]])
    plant = Plant(A, np.hstack([B, np.zeros((3, 3))]), np.eye(3), 0.3 * np.eye(3, 6, 3), np.eye(3))
    nominal = h2_riccati(plant)
    design = h2_lmi_structured(plant, np.eye(3))
    assert np.array_equal(design.L, np.diag(np.diag(design.L)))
    assert nominal.gamma < design.certificate.verified < design.gamma < 1.4 * nominal.gamma
    assert design.certificate.ratio < 0.9
