"""The smallest bound: it holds, a little less does not, and it is what the start's doubt alone demands."""

import numpy as np
import pytest

from robustnav.errors import EstimatorError, InputError
from robustnav.models import AlignmentNoise, alignment
from robustnav.records import Log, Stream
from robustnav.run import HInfinity, Start, run
from robustnav.run.gamma import smallest_gamma


@pytest.fixture(scope="module")
def moored():
    """A unit at rest, level, in increments of a tenth of a second, with a velocity reference."""
    rng, n, T = np.random.default_rng(3), 40, 0.1
    noise = AlignmentNoise(1e-4, 1e-3, 1e-6, 1e-5, 1.0)
    model = alignment(noise, gravity=9.8, earth_rate_north=6e-5, earth_rate_down=-4e-5)
    t, eye = T * np.arange(1, n + 1), np.tile((T * np.eye(3)).ravel(), (n, 1))
    u = {
        "turn": np.column_stack([np.ones(n), np.zeros((n, 3))]),
        "velocity_increment": np.tile([0.0, 0.0, -9.8 * T], (n, 1)),
        "turn_by_bias": eye,
        "velocity_by_bias": np.zeros((n, 9)),
    }
    streams = {name: Stream(name, t, values, "1", "b") for name, values in u.items()}
    streams["velocity"] = Stream("velocity", t, rng.normal(size=(n, 3)), "m/s", "n")
    sd = {"v_n": 3.0, "quaternion": 1e-3}
    return model, Log(streams, "made"), Start.at(model, sd)


def exists(model, gamma, log, start):
    margin = run(HInfinity(model, gamma, {"v_n": 1.0}), log, start).innovations["velocity"].margin
    return bool((margin[~np.isnan(margin)] > 0).all())


def test_it_holds_and_a_little_less_does_not(moored):
    model, log, start = moored
    gamma = smallest_gamma(lambda g: HInfinity(model, g, {"v_n": 1.0}), log, start, margin=1.0)
    assert exists(model, gamma, log, start)
    assert not exists(model, 0.99 * gamma, log, start)
    wider = smallest_gamma(lambda g: HInfinity(model, g, {"v_n": 1.0}), log, start)
    assert wider == pytest.approx(1.1 * gamma)


def test_one_velocity_reading_bounds_it_from_the_covariance_after_it(moored):
    """With one reading fused the bound is the largest sd left: 1 / sqrt(1 / 3^2 + 1 / 1^2) m/s."""
    model, log, start = moored
    short = {name: Stream(name, s.t[:1], s.values[:1], s.unit, s.frame) for name, s in log.streams.items()}
    gamma = smallest_gamma(lambda g: HInfinity(model, g, {"v_n": 1.0}), Log(short, "one"), start, margin=1.0)
    assert gamma == pytest.approx(1 / np.sqrt(1 / 9 + 1), rel=2e-3)


def test_tolerances_scale_it(moored):
    model, log, start = moored
    gammas = [
        smallest_gamma(lambda g, s=s: HInfinity(model, g, {"v_n": s}), log, start, margin=1.0) for s in (1.0, 0.01)
    ]
    assert gammas[1] == pytest.approx(100 * gammas[0], rel=2e-3)


def test_bad_margin_and_a_filter_that_never_exists_are_named(moored):
    model, log, start = moored
    with pytest.raises(InputError, match="margin"):
        smallest_gamma(lambda g: HInfinity(model, g), log, start, margin=0.9)
    broken = Start(start.x, np.diag(np.full(13, np.nan)))
    with pytest.raises(EstimatorError, match="no H-infinity filter exists"):
        smallest_gamma(lambda g: HInfinity(model, g), log, broken)
