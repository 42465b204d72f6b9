"""The step: F against differences of the state's step, F and Q against van Loan's matrix exponential."""

import numpy as np
import pytest
from scipy.linalg import expm

from robustnav.model import Equations, Model, Noise, NumericModel, Sensor, Vector

# local error of F in powers of dt: rotations are composed, other blocks of a model with a rotation are first order
ORDER = {"attitude": 3, "attitude_body": 3, "attitude_euler": np.inf, "inertial_n": 2, "inertial_b": 2}


def step_differences(numeric, x, u, dt):
    after = numeric.propagate(x, u, dt)
    columns = []
    for e in 1e-5 * np.eye(numeric.model.error_size):
        ahead, back = (numeric.difference(numeric.propagate(numeric.inject(x, s), u, dt), after) for s in (e, -e))
        columns.append((ahead - back) / 2e-5)
    return np.array(columns).T


def test_transition_is_the_derivative_of_the_step(model, numeric, states):
    order = ORDER[model.name]
    for x, u in states(model):
        off = [
            np.abs(numeric.transition(x, u, dt)[0] - step_differences(numeric, x, u, dt)).max() for dt in (0.04, 0.02)
        ]
        if order == np.inf:
            assert max(off) < 1e-8
        else:
            assert off[1] < max(off[0] / 2 ** (order - 0.3), 1e-9)
            assert off[0] < 60 * 0.04**order


def van_loan(A, G, Qc, dt):
    n = len(A)
    block = np.block([[-A, G @ Qc @ G.T], [np.zeros((n, n)), A.T]]) * dt
    E = expm(block)
    F = E[n:, n:].T
    return F, F @ E[:n, n:]


def linear(A, G):
    n, m = G.shape
    return Model(
        name="linear",
        state=(Vector("x", "1", n),),
        inputs=(),
        noises=(Noise("w", "1", 0.7, m),),
        sensors=(Sensor("y", "1", 1.0, 1),),
        equations=lambda s: Equations(
            {
                "x": [
                    sum(a * v for a, v in zip(row, s.x, strict=True))
                    + sum(g * v for g, v in zip(grow, s.w, strict=True))
                    for row, grow in zip(A, G, strict=True)
                ]
            },
            {"y": s.x[0]},
        ),
    )


def test_integrator_chains_are_exact():
    A, G = (
        np.array([[0.0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]]),
        np.array([[0, 0], [1, 0], [0, 0], [0, 2.0]]),
    )
    F, Q = NumericModel(linear(A, G)).transition(np.ones(4), np.zeros(0), 0.3)
    F_exact, Q_exact = van_loan(A, G, 0.49 * np.eye(2), 0.3)
    np.testing.assert_allclose(F, F_exact, atol=1e-15)
    np.testing.assert_allclose(Q, Q_exact, atol=1e-15)


@pytest.mark.parametrize("seed", range(3))
def test_linear_models_are_second_order(seed):
    rng = np.random.default_rng(seed)
    A, G = rng.normal(size=(3, 3)), rng.normal(size=(3, 2))
    numeric, off = NumericModel(linear(A, G)), []
    for dt in (0.02, 0.01):
        pairs = zip(numeric.transition(np.ones(3), np.zeros(0), dt), van_loan(A, G, 0.49 * np.eye(2), dt), strict=True)
        off.append([np.abs(a - b).max() for a, b in pairs])
    ratio = np.divide(off[0], off[1])
    assert (ratio > 7).all() and (ratio < 9).all()  # what is left falls with dt^3 in a step


@pytest.mark.parametrize("name", ["attitude", "inertial_n"])
def test_models_with_a_rotation_keep_the_noise_to_first_order(models, numerics, states, name):
    model, numeric = models[name], numerics[name]
    Qc = np.diag(np.repeat(model.intensities, [n.size for n in model.noises]))
    for x, u in states(model):
        off = []
        for dt in (0.02, 0.01):
            middle = numeric.propagate(x, u, dt / 2)
            A, G = numeric.error_rate(middle, u)
            F, Q = numeric.transition(x, u, dt)
            F_exact, Q_exact = van_loan(A, G, Qc, dt)
            off.append(np.abs(Q - Q_exact).max() / np.abs(Q_exact).max())
            if name == "attitude":  # A is nilpotent: I + A dt is its exponential
                np.testing.assert_allclose(F, F_exact, atol=1e-12)
        assert off[0] < 0.1 and off[1] < 0.6 * off[0]


@pytest.mark.parametrize("name", ["attitude", "inertial_n", "inertial_b"])
def test_turning_does_not_inflate_the_attitude_covariance(models, numerics, name):
    """I - [w]x dt would inflate it by (1 + |w dt|^2) a step, 1.43 in a second of 6 rad/s."""
    model, numeric = models[name], numerics[name]
    u = np.zeros(model.input_size)
    u[:3] = 6.0 * np.array([0.6, 0.0, 0.8])
    x, P = model.nominal_state(), np.diag([1.0, 2.0, 3.0])
    for _ in range(100):
        F = numeric.transition(x, u, 0.01)[0][:3, :3]
        P, x = F @ P @ F.T, numeric.propagate(x, u, 0.01)
    np.testing.assert_allclose(np.linalg.eigvalsh(P), [1, 2, 3], rtol=1e-6)


def test_a_steady_turn_is_integrated_to_fifth_order(models, numerics):
    numeric, x = numerics["attitude"], models["attitude"].nominal_state()
    for _ in range(100):
        x = numeric.propagate(x, np.array([0.0, 0.0, 6.0]), 0.01)
    angle = 2 * np.arctan2(x[3], x[0])
    assert abs((angle - 6.0 + np.pi) % (2 * np.pi) - np.pi) < 100 * 0.06**5 / 1900
    assert abs(np.linalg.norm(x[:4]) - 1) < 1e-12
