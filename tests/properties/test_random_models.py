"""Models nobody wrote: random equations give the same filter in C and in NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.engine import SensorData, compile_model
from robustnav.engine.backends import FilterSetup, KernelFilter, ReferenceFilter
from robustnav.filter.ukf import Spread
from robustnav.filter.weighting import Gate, Huber, StudentT
from robustnav.model import Equations, Model, Noise, NumericModel, Rotation, Sensor, Vector

COEFFICIENTS = st.sampled_from([-1.5, -0.4, 0.0, 0.0, 0.3, 1.0])


def terms(sp, a, b):
    """Shapes that a rate or a sensor may have, all smooth and tame."""
    return [
        sp.sin(a) * b,
        a * b / (1 + a**2),
        sp.exp(-(a**2)) * b,
        sp.sqrt(1 + a**2 + b**2),
        sp.atan2(a, 2 + sp.cos(b)),
        (a - b) ** 3 / (1 + b**2) ** 2,
        sp.log(2 + a**2) / sp.sqrt(1 + b**2),
        sp.tan(sp.cos(a) / 2),
    ]


@st.composite
def models(draw):
    n, k = draw(st.integers(1, 3)), draw(st.integers(0, 2))
    attitude = draw(st.sampled_from([None, "n", "b"]))
    linear = draw(st.lists(COEFFICIENTS, min_size=2 * n * n, max_size=2 * n * n))
    index = st.integers(0, n - 1)
    bent = draw(st.lists(st.tuples(st.integers(0, 7), index, index, COEFFICIENTS), max_size=3))

    def equations(s):
        import sympy as sp

        extra = [c * terms(sp, s.x[i], s.x[j] + s.shift)[which] for which, i, j, c in bent]
        inputs = sum(s.u, 0) if k else 0
        x = [sum(linear[i * n + j] * s.x[j] for j in range(n)) - s.x[i] + inputs + s.w[0] * (1 + i) for i in range(n)]
        y = [sum(linear[(n + i) * n + j] * s.x[j] for j in range(n)) + s.x[i] for i in range(n)]
        x[0] += sum(extra, 0)
        y[-1] += sum(extra[:1], 0)
        rates, directions = {"x": x}, {}
        if attitude:
            rates["q"] = [s.x[0] + s.v[0], 0.3 + s.v[1], s.v[2] - s.x[-1]]
            directions["seen"] = (1, 0, s.shift)
        return Equations(rates, {"y": y}, directions)

    return Model(
        name="random",
        state=(*([Rotation("q", attitude)] if attitude else []), Vector("x", "1", n)),
        inputs=(Vector("u", "1", k),) if k else (),
        noises=(Noise("w", "1", 0.3, 1), *([Noise("v", "1", 0.1)] if attitude else [])),
        sensors=(Sensor("y", "1", 0.2, n), *([Sensor("seen", "1", 0.1)] if attitude else [])),
        parameters={"shift": 0.7},
        equations=equations,
        start_sd={"x": 0.5, "q": 0.2} if attitude else {"x": 0.5},
    )


@settings(max_examples=8)
@given(models(), st.integers(0, 99), st.sampled_from([Gate(), Gate(4.0), Huber(), StudentT()]))
def test_a_random_model_is_the_same_filter_in_c(model, seed, rule):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0, 0.05, 12))
    u = rng.normal(size=(12, model.input_size))
    sensors = [SensorData(t[1::2], 0.3 * rng.normal(size=(6, s.size))) for s in model.sensors]
    compiled, numeric = compile_model(model), NumericModel(model)
    for kind in ("ekf", "ukf"):
        rules = (rule,) * len(sensors)
        setup = FilterSetup(kind, model.nominal_state(), model.start_covariance(), rules, Spread())
        one, other = (f(m, setup).run(t, u, sensors) for f, m in ((KernelFilter, compiled), (ReferenceFilter, numeric)))
        np.testing.assert_allclose(one.x, other.x, rtol=1e-9, atol=1e-10)
        np.testing.assert_allclose(one.P, other.P, rtol=1e-8, atol=1e-10)
        for a, b in zip(one.seen, other.seen, strict=True):
            np.testing.assert_array_equal(a.used, b.used)
            np.testing.assert_allclose(a.nis, b.nis, rtol=1e-7)


@pytest.fixture(scope="module", autouse=True)
def private_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
        patch.setenv("CC", "cc -w")
        yield
