"""A covariance carried along with a correction of attitude: what errors really become, in both axes."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.engine.backends import functions_of
from robustnav.filter.ekf import transported
from robustnav.model import Rotation
from robustnav.models import AttitudeNoise, attitude
from robustnav.run import EKF, Start, stream


def model_of(error):
    one = attitude(AttitudeNoise(2e-2, 1e-3, 0.5, 0.02, 3e-3), field=1.0, dip_deg=60.0)
    turned = Rotation("q_nb", error, transported=True)
    return replace(one, name=f"attitude_{error}_transported", shipped=None, state=(turned, one.state[1]))


@pytest.mark.parametrize("error", ["n", "b"])
def test_errors_about_the_corrected_state(error):
    """An error d + e about the old state is G e about the state moved by d."""
    model, rng = model_of(error), np.random.default_rng(1)
    step, x = functions_of(model), Start.at(model, q_nb=[0.5, 0.5, -0.5, 0.5]).x
    for size in (1e-3, 0.01, 0.05):
        d = size * rng.standard_normal(6)
        columns = []
        for e in 1e-5 * np.eye(6):
            ends = [step.difference(step.inject(x, d + s * e), step.inject(x, d)) for s in (1, -1)]
            columns.append((ends[0] - ends[1]) / 2e-5)
        G, A = np.array(columns).T, rng.standard_normal((6, 6))
        P = A @ A.T
        exact, square = G @ P @ G.T, float(d[:3] @ d[:3])
        assert np.abs(transported(model, d, P) - exact).max() < square * P.max()  # the retraction is no exponential
        assert np.abs(P - exact).max() > 2 * square * P.max()


def test_only_where_it_is_asked_for():
    model = replace(model_of("n"), state=(Rotation("q_nb"), model_of("n").state[1]))
    P = np.eye(6)
    assert transported(model, np.ones(6), P) is P


@pytest.mark.parametrize("error", ["n", "b"])
def test_compiled_equals_numpy(error, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    model = model_of(error)
    start = Start.at(model, {"q_nb": 1.0}, q_nb=[0.6, 0.5, -0.5, 0.38])
    C, numpy = (stream(EKF(model), start, backend=b) for b in ("c", "numpy"))
    for filt in (C, numpy):
        for k in range(20):
            filt.update([0.3, -0.2, 0.5], [1.0, -2.0, -9.0], [0.5, 0.1 * k, 0.8], 0.05)
    np.testing.assert_allclose(C.state, numpy.state, atol=1e-12)
    np.testing.assert_allclose(C.covariance, numpy.covariance, atol=1e-13)
