"""Models to derive: the built-in ones and a small inertial one with a velocity, its attitude error in n or in b."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.model import Equations, Model, Noise, NumericModel, Rotation, Sensor, Vector
from robustnav.models import AttitudeNoise, attitude, attitude_euler
from robustnav.units import DEG

NOISE = AttitudeNoise(2e-3, 1e-4, 0.05, 4e-7, 3e-3)


def inertial(error):
    """Attitude, velocity and gyro bias from gyro and accelerometer; air speed, velocity and field as sensors."""

    def equations(s):
        w, x, y, z = s.q_nb
        C_nb = _matrix(w, x, y, z)
        return Equations(
            rates={
                "q_nb": s.gyro - s.bias - s.gyro_noise,
                # an accelerometer on a lever feels some of the gyro's noise, so that one noise drives two blocks
                "v_n": C_nb * (s.accel - s.accel_noise + 10 * s.gyro_noise) - s.drag * s.v_n,
                "bias": s.bias_noise - s.bias / s.tau,
            },
            sensors={"air": C_nb.T * s.v_n, "speed": (s.v_n[0] ** 2 + s.v_n[1] ** 2 + s.v_n[2] ** 2,)},
            directions={"mag": (s.north, 0, s.down)},
        )

    return Model(
        name=f"inertial_{error}",
        state=(Rotation("q_nb", error), Vector("v_n", "m/s"), Vector("bias", "rad/s", frame="b")),
        inputs=(Vector("gyro", "rad/s", frame="b"), Vector("accel", "m/s^2", frame="b")),
        noises=(
            Noise("gyro_noise", "rad/s/sqrt(Hz)", 0.02),
            Noise("accel_noise", "m/s^2/sqrt(Hz)", 0.3),
            Noise("bias_noise", "rad/s^2/sqrt(Hz)", 0.01),
        ),
        sensors=(Sensor("air", "m/s", 0.3), Sensor("speed", "m^2/s^2", 1.0, 1), Sensor("mag", "1", 0.05)),
        parameters={"drag": 0.2, "tau": 50.0, "north": 0.5, "down": 0.8},
        equations=equations,
        nominal={"accel": (0.5, -1.0, -9.8)},
        start_sd={"q_nb": 0.2, "v_n": 1.0, "bias": 0.05},
    )


def _matrix(w, x, y, z):
    import sympy as sp

    return sp.Matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


MODELS = {
    "attitude": lambda: attitude(NOISE, field=1.0, dip_deg=60.0),
    "attitude_body": lambda: replace(
        attitude(NOISE, field=1.0, dip_deg=60.0),
        name="attitude_body",
        shipped=None,
        state=(Rotation("q_nb", "b"), Vector("gyro_bias", "rad/s")),
    ),
    "attitude_euler": lambda: attitude_euler(NOISE, field=1.0, dip_deg=60.0),
    "inertial_n": lambda: inertial("n"),
    "inertial_b": lambda: inertial("b"),
}


@pytest.fixture(scope="session")
def models():
    return {name: make() for name, make in MODELS.items()}


@pytest.fixture(scope="session")
def numerics(models):
    return {name: NumericModel(model) for name, model in models.items()}


@pytest.fixture(scope="session", params=MODELS)
def model(request, models):
    return models[request.param]


@pytest.fixture(scope="session")
def numeric(model, numerics):
    return numerics[model.name]


@pytest.fixture(scope="session", autouse=True)
def private_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
        yield


def random_state(model, rng):
    """A state within reach of the model's start, its attitude anywhere."""
    x = model.nominal_state()
    for block in model.state:
        part = model.state_slices[block.name]
        if isinstance(block, Rotation):
            q = rng.normal(size=4)
            x[part] = q / np.linalg.norm(q)
        elif block.name == "euler":
            x[part] = rng.uniform([-3, -1.2, -3], [3, 1.2, 3])
        else:
            x[part] += rng.normal(size=block.size) * np.broadcast_to(model.start_sd[block.name], block.size)
    return x


@pytest.fixture(scope="session")
def states():
    """By model: identity, an attitude of 1e-8 rad, and random states, each with an input."""

    def make(model, count=4):
        rng = np.random.default_rng(3)
        beside = model.nominal_state()
        if model.rotation is not None:
            beside[:4] = [1.0, 5e-9, -5e-9, 5e-9]
        else:
            beside[:3] = 1e-8
        points = [model.nominal_state(), beside, *(random_state(model, rng) for _ in range(count))]
        return [(x, rng.normal(size=model.input_size) * 50 * DEG) for x in points]

    return make
