"""Filters to run in C and in NumPy, and streams with everything that happens to streams."""

import importlib.util
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import SensorData
from robustnav.model import Rotation
from robustnav.models import (
    AidingNoise,
    AlignmentNoise,
    AttitudeNoise,
    InertialNoise,
    alignment,
    alignment_so3,
    attitude,
    attitude_euler,
    inertial,
    uwb,
)
from robustnav.run import EKF, H2, UKF, HInfinity, Start

NOISE = AttitudeNoise(2e-2, 1e-3, 0.5, 0.02, 3e-3)


def example(name):
    path = Path(__file__).parents[2] / "examples" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.model


def _attitude():
    return attitude(NOISE, field=1.0, dip_deg=60.0)


def _alignment():
    noise = AlignmentNoise(2e-4, 1e-3, 1e-5, 1e-4, 0.05)
    return alignment(noise, gravity=9.8, earth_rate_north=6e-5, earth_rate_down=-4e-5)


def _alignment_so3():
    noise = AlignmentNoise(2e-4, 1e-3, 1e-5, 1e-4, 0.05)
    return alignment_so3(noise, gravity=9.8, earth_rate_north=6e-5, earth_rate_down=-4e-5, lines=(0.5, 1.0, 2.0))


MODELS = {
    "attitude": _attitude,
    "attitude_euler": lambda: attitude_euler(NOISE, field=1.0, dip_deg=60.0),
    "attitude_body": lambda: replace(
        _attitude(), name="attitude_body", shipped=None, state=(Rotation("q_nb", "b"), _attitude().state[1])
    ),
    "pendulum": lambda: example("pendulum"),
    "range_bearing": lambda: example("range_bearing"),
    "uwb_2d": lambda: uwb(range_sd=0.1, acceleration_density=0.5, dimensions=2, tag_down=-1.0, time_offset=0.1),
    "uwb_3d": lambda: uwb(range_sd=0.1, acceleration_density=0.5, vertical_density=0.1),
    "uwb_3d_driven": lambda: uwb(range_sd=0.1, acceleration_density=0.5, driven=True),
    "alignment": _alignment,
    "alignment_so3": _alignment_so3,
    "inertial": lambda: inertial(InertialNoise(5e-3, 5e-2, 1e-4, 1e-3), AidingNoise(), earth_rate_n=(5e-5, 0, -3e-5)),
}
KINDS = {
    "ekf": EKF,
    "ukf": UKF,
    "hinf": lambda model: HInfinity(model, 3 * np.sqrt(model.start_covariance().max())),
    "fixed": lambda model: H2(model, 100.0, start_sd="steady", sets=4),
}


@pytest.fixture(scope="session", autouse=True)
def private_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
        yield


# no constant gain for the pendulum, whose damping cannot be seen at rest, nor where the geometry varies
VARYING = {"pendulum", "uwb_2d", "uwb_3d", "uwb_3d_driven", "inertial", "alignment", "alignment_so3"}
CASES = [(m, k) for m in MODELS for k in KINDS if k != "fixed" or m not in VARYING]


@pytest.fixture(scope="session", params=CASES, ids="-".join)
def case(request):
    """An estimator, its start and streams."""
    name, kind = request.param
    model = MODELS[name]()
    return make_case(model, KINDS[kind](model))


def make_case(model, estimator):
    start = Start.at(model)
    t, u, sensors = streams(model, start.x)
    return SimpleNamespace(model=model, setup=estimator.setup(start.x, start.P), t=t, u=u, sensors=sensors)


@pytest.fixture(scope="session")
def plain():
    return lambda kind="ekf", name="attitude": make_case(model := MODELS[name](), KINDS[kind](model))


def streams(model, x):
    """About a second at 100 Hz: jitter, a gap, equal times, missing samples; sensors at rates of their own."""
    rng, functions = np.random.default_rng(7), functions_of(model)
    t = 10 + np.sort(np.r_[np.arange(90) * 0.01 + rng.uniform(0, 0.004, 90), 10.31 - 10])
    t[40:] += 0.25
    t[60] = t[59]
    u = model.nominal_input() + 0.2 * rng.normal(size=(len(t), model.input_size))
    if model.input_size:
        u[[0, 30, 31], 0] = np.nan
    sensors = []
    for j, sensor in enumerate(model.sensors):
        own = np.sort(np.r_[9.9, 9.95, t[1], t[2], t[2], t[20::7], rng.uniform(10, t[-1] + 0.1, 15), t[-1]])
        most = [1.0 if block.unit == "rad/s" else 8.0 for block in sensor.known for _ in range(block.size)]
        known = rng.uniform(-1, 1, (len(own), sensor.width - sensor.size)) * most
        exact = np.array([functions.measure(j, x, k) for k in known])
        z = np.hstack([exact + sensor.sd * rng.normal(size=exact.shape), known])
        z[[4, 9], 0] = np.nan
        sensors.append(SensorData(own, z))
    if len(sensors) > 1:
        both = sensors[0].t[10:14]  # two sensors at one instant
        sensors[1] = SensorData(np.sort(np.r_[sensors[1].t, both]), np.r_[sensors[1].z, sensors[1].z[-4:]])
    return t, u, sensors


@pytest.fixture(scope="session")
def same():
    """Hold two outputs equal: states, covariances and what the readings said."""

    def check(one, other, tolerance):
        def close(a, b, what):
            assert a.shape == b.shape, what
            # covariances span decades: each number against the largest of its column over the run
            scale = np.nanmax(np.abs(b), axis=0, initial=0) if b.ndim > 1 else np.nanmax(np.abs(b), initial=0)
            off = np.abs(a - b) / np.maximum(scale, 1e-3 * np.nanmax(scale, initial=1e-300))
            assert (np.isnan(a) == np.isnan(b)).all(), what
            assert np.nanmax(off, initial=0) <= tolerance, (what, np.nanmax(off))

        close(one.x, other.x, "x")
        assert (one.P is None) == (other.P is None)
        if one.P is not None:
            close(one.P, other.P, "P")
        for j, (a, b) in enumerate(zip(one.seen, other.seen, strict=True)):
            assert (a is None) == (b is None)
            if a is None:
                continue
            np.testing.assert_array_equal(a.used, b.used)
            for what in ("nu", "s", "nis", "weight", "margin"):
                close(getattr(a, what), getattr(b, what), f"{what} of sensor {j}")

    return check
