"""The alignment model on SO(3): its step is the strapdown's, its derivatives are true, less heading is made up."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import SensorData
from robustnav.errors import InputError
from robustnav.filter.steps import unpack
from robustnav.frames import quat_from_rotvec
from robustnav.model import Rotation
from robustnav.models import AlignmentNoise, alignment_so3
from robustnav.run import EKF, Start, stream
from robustnav.strapdown import ImuSamples, Place, carry, preintegrate
from robustnav.units import DEG

PLACE = Place.at(32 * DEG)
NOISE = AlignmentNoise(1e-6, 3e-5, 1e-9, 1e-5, 0.05)
LINES = (0.5, 1.0, 2.0)


def model_of(lines=LINES, **options):
    north, _, down = PLACE.earth_rate_n
    gravity = PLACE.gravity_n[2]
    return alignment_so3(NOISE, gravity=gravity, earth_rate_north=north, earth_rate_down=down, lines=lines, **options)


def swaying(seconds=2.0, seed=0):
    rng, n = np.random.default_rng(seed), round(1000 * seconds)
    rate = 0.3 * np.sin(np.outer(np.arange(n) * 1e-3, rng.uniform(3, 9, 3)) + rng.uniform(0, 6, 3))
    force = np.array([0.5, -0.3, -9.8]) + 0.5 * rng.standard_normal(3) * np.sin(np.arange(n) * 4e-3)[:, None]
    return preintegrate(ImuSamples(rate * 1e-3, force * 1e-3, 1e-3), 100)


def test_step_is_the_strapdowns():
    model, inc = model_of(()), swaying()
    bias = np.array([1e-3, -2e-3, 5e-4]), np.array([0.02, 0.01, -0.03])
    q, v = quat_from_rotvec([0.3, -0.2, 1.0]), np.array([2.0, 2.7, 0.3])
    x, step = np.concatenate([q, v, *bias]), functions_of(model)
    for row in inc.rows:
        x = step.propagate(x, row, inc.dt)
    expected_q, expected_v = carry(q, v, inc, PLACE, bias)
    np.testing.assert_allclose(x[:4], expected_q[-1], atol=1e-9)
    np.testing.assert_allclose(x[4:7], expected_v[-1], atol=1e-8)


@pytest.mark.parametrize("lines", [(), LINES])
def test_transition_by_differences(lines):
    model, row = model_of(lines), swaying(0.1).rows[0]
    step, n = functions_of(model), model.error_size
    x = model.nominal_state()
    x[:10] = [*quat_from_rotvec([0.5, -0.7, 2.0]), 2.0, 2.7, 0.3, 1e-3, -2e-3, 3e-3]
    x[13:] = np.linspace(-0.5, 0.4, n - 12)
    F, Q = step.transition(x, row, 0.1)
    after = step.propagate(x, row, 0.1)
    columns = []
    for e in 1e-5 * np.eye(n):
        ends = [step.difference(step.propagate(step.inject(x, s * e), row, 0.1), after) for s in (1, -1)]
        columns.append((ends[0] - ends[1]) / 2e-5)
    np.testing.assert_allclose(F, np.array(columns).T, atol=1e-9)
    sizes = [NOISE.gyro_density, NOISE.accel_density, NOISE.gyro_bias_density, NOISE.accel_bias_density]
    np.testing.assert_allclose(np.diag(Q)[:12], 0.1 * np.repeat(sizes, 3) ** 2, rtol=1e-9)


def test_lines_turn_at_their_frequency():
    model, row = model_of((0.7,)), swaying(0.1).rows[0]
    step, x = functions_of(model), model.nominal_state()
    x[13:] = [0.3, 0.0, 0.0, 0.2]
    for k in range(1, 6):
        x = step.propagate(x, row, 0.1)
        seen = step.measure(0, x) - x[4:7]
        np.testing.assert_allclose(seen, [0.3 * np.cos(0.07 * k), 0.2 * np.sin(0.07 * k), 0.0], atol=1e-12)


def heading_sd_after(seconds, tilt_sd, *, transported):
    """A base at rest in a mean wind, the heading known to 15 degrees: what is said of heading later [deg]."""
    n = round(10 * seconds)
    rate, force = 1e-3 * PLACE.earth_rate_n, -1e-3 * PLACE.gravity_n
    inc = preintegrate(ImuSamples(np.tile(rate, (100 * n, 1)), np.tile(force, (100 * n, 1)), 1e-3), 100)
    model = model_of(())
    if not transported:
        model = replace(model, state=(Rotation("q_nb"), *model.state[1:]), shipped=None)
    sd = {"q_nb": (tilt_sd, tilt_sd, 15 * DEG), "gyro_bias": 1e-7, "accel_bias": 1e-3}
    filt = stream(EKF(model), Start.at(model, sd, q_nb=quat_from_rotvec([0.7 * tilt_sd, -0.7 * tilt_sd, 0.2])))
    z = np.array([2.7, 2.0, 0.0]) + 0.05 * np.random.default_rng(0).standard_normal((n, 3))
    t = 0.1 * np.arange(n + 1)
    out = filt.run(t, np.vstack([inc.rows[:1], inc.rows]), [SensorData(t[1:], z)])
    return np.sqrt(unpack(out.P)[-1, 2, 2]) / DEG


@pytest.mark.parametrize(("tilt_deg", "kept", "claimed"), [(1, 14.4, 13.6), (5, 13.7, 11.8), (15, 11.8, 8.5)])
def test_less_heading_is_made_up(tilt_deg, kept, claimed):
    """Five seconds say nothing of heading: 15 degrees should stay.  Transport keeps two thirds of what is else lost."""
    assert heading_sd_after(5.0, tilt_deg * DEG, transported=True) > kept
    assert heading_sd_after(5.0, tilt_deg * DEG, transported=False) < claimed


def test_bad_lines_are_refused():
    for lines in ((1.0,) * 7, (0.5, -1.0)):
        with pytest.raises(InputError, match="lines of a wind"):
            model_of(lines)
