import numpy as np
import pytest

from robustnav.model import Equations, Model, Noise, NumericModel, Sensor, Vector
from robustnav.models import AttitudeNoise, attitude

A = np.array([[0.0, 1.0, 0.0], [-2.0, -0.3, 0.5], [0.0, 0.0, -0.1]])
B = np.array([0.0, 1.0, 0.0])
G = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
H = np.array([[1.0, 0.0, 0.0], [0.5, 0.0, 1.0]])


def _sum(row, values):
    return sum(float(a) * v for a, v in zip(row, values, strict=True))


def linear():
    """A damped spring with a drifting force; two numbers a reading."""

    def equations(s):
        rate = [_sum(a, s.x) + b * s.u[0] + _sum(g, s.w) for a, b, g in zip(A, B, G, strict=True)]
        return Equations({"x": rate}, {"y": [_sum(h, s.x) for h in H]})

    return Model(
        name="spring",
        state=(Vector("x", "m", 3),),
        inputs=(Vector("u", "m", 1),),
        noises=(Noise("w", "m", 0.4, 2),),
        sensors=(Sensor("y", "m", 0.3, 2),),
        equations=equations,
        start_sd={"x": 1.0},
    )


@pytest.fixture(scope="session")
def spring():
    return NumericModel(linear())


@pytest.fixture(scope="session")
def turning():
    return NumericModel(attitude(AttitudeNoise(2e-3, 1e-4, 0.5, 0.02, 3e-3), field=1.0, dip_deg=60.0))


@pytest.fixture
def belief():
    rng = np.random.default_rng(2)
    root = 0.1 * rng.normal(size=(6, 6))
    q = rng.normal(size=4)
    return np.r_[q / np.linalg.norm(q), 0.01 * rng.normal(size=3)], root @ root.T + 1e-4 * np.eye(6)
