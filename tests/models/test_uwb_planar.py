"""The planar model: geometry against an independent derivation, consistency, readings, bad input."""

import numpy as np
import pytest

from robustnav.engine.backends import functions_of
from robustnav.errors import InputError
from robustnav.evaluate.consistency import consistency
from robustnav.frames import wrap_angle
from robustnav.model.functions import NumericModel
from robustnav.models.uwb_planar import planar_stream, uwb_planar
from robustnav.records import Anchors, Log, Ranges
from robustnav.run import EKF, Start, run

ANCHORS = Anchors(("a", "b", "c", "d"), np.array([[4.0, 3, -1], [-4, 3, -1.1], [-4, -3, -0.9], [4, -3, -1]]))
LEVER_B = np.array([[0.3, 0.1, 0.02], [-0.2, -0.25, -0.03]])
PATTERN = np.array([[0.01, -0.03, 0.02, 0.04], [0.0, 0.02, -0.01, -0.03]])
DOWN, OFFSET = -0.4, 0.03


def model(**numbers):
    return uwb_planar(range_sd=0.05, acceleration_density=0.2, yaw_acceleration_density=0.3, body_down=DOWN, **numbers)


def expected(p, yaw, anchor, tag):
    """Return the range of a tag, by complex numbers: no rotation matrix, no double angles."""
    turn = np.exp(1j * yaw)
    at = p[0] + 1j * p[1] + turn * (LEVER_B[tag, 0] + 1j * LEVER_B[tag, 1])
    away = ANCHORS.p_a[anchor, 0] + 1j * ANCHORS.p_a[anchor, 1] - at
    bearing = np.angle(away / turn)
    waves = [np.cos(bearing), np.sin(bearing), np.cos(2 * bearing), np.sin(2 * bearing)]
    return np.hypot(abs(away), DOWN + LEVER_B[tag, 2] - ANCHORS.p_a[anchor, 2]) + PATTERN[tag] @ waves


def known(anchor, tag):
    return np.concatenate([ANCHORS.p_a[anchor], LEVER_B[tag], PATTERN[tag]])


@pytest.mark.parametrize("functions", [functions_of, NumericModel], ids=["c", "numpy"])
def test_a_range_is_that_of_the_turned_tag_a_little_earlier(functions):
    rng = np.random.default_rng(4)
    late = functions(model(time_offset=OFFSET))
    for _ in range(20):
        x = np.concatenate([rng.uniform(-2, 2, 2), rng.normal(size=2), rng.uniform(-9, 9, 1), rng.normal(size=1)])
        anchor, tag = rng.integers(4), rng.integers(2)
        z = np.concatenate([[0.0], known(anchor, tag)])
        then = expected(x[:2] - OFFSET * x[2:4], x[4] - OFFSET * x[5], anchor, tag)
        assert -late.residual(0, x, z)[0] == pytest.approx(then, abs=1e-12)
        steps = 1e-6 * np.eye(6)
        slopes = [(late.residual(0, x - e, z) - late.residual(0, x + e, z))[0] / 2e-6 for e in steps]
        np.testing.assert_allclose(late.jacobian(0, x, z[1:])[0], slopes, atol=1e-8)


def drives(runs, pattern):
    """Return times, true states and ranges of drives as the model says that they are."""
    rng = np.random.default_rng(7)
    dt, n = 0.05, 160
    t = dt * np.arange(1, n + 1)
    q, yaw_q = 0.2**2 * dt, 0.3**2 * dt
    step = np.linalg.cholesky(np.array([[dt**2 / 3, dt / 2], [dt / 2, 1.0]]))
    x = np.zeros((runs, n + 1, 3, 2))  # x, y, yaw; value and rate
    x[:, 0] = rng.normal(size=(runs, 3, 2)) * np.array([[0.1, 0.3], [0.1, 0.3], [0.2, 0.3]])
    for k in range(n):
        noise = rng.normal(size=(runs, 3, 2)) @ step.T * np.sqrt([[q], [q], [yaw_q]])
        x[:, k + 1, :, 0] = x[:, k, :, 0] + dt * x[:, k, :, 1] + noise[..., 0]
        x[:, k + 1, :, 1] = x[:, k, :, 1] + noise[..., 1]
    rows = np.array([(k % 4, k // 2 % 2) for k in range(2 * n)])  # two anchors a step, from one tag
    times, steps = np.repeat(t, 2), np.repeat(np.arange(1, n + 1), 2)
    for i in range(runs):
        d = [expected(x[i, k, :2, 0], x[i, k, 2, 0], a, g) for k, (a, g) in zip(steps, rows, strict=True)]
        d = np.array(d) + 0.05 * rng.normal(size=len(d))
        ranges = Ranges(times, rows[:, 0], rows[:, 1], d, ANCHORS, ("f", "r"), LEVER_B)
        yield t, x[i, 1:], Log({"range": planar_stream(ranges, pattern)}, "made")


def squares(runs, pattern):
    out = []
    for t, x, log in drives(runs, pattern):
        one = model()
        sd = {"p_n": 0.1, "v_n": 0.3, "yaw": 0.2, "yaw_rate": 0.3}
        found = run(EKF(one), _from_zero(log), Start.at(one, sd))
        np.testing.assert_allclose(found.t[1:], t)
        yaw = wrap_angle(found.state["yaw"][1:, 0] - x[:, 2, 0]) / found.sd["yaw"][1:, 0]
        p = (found.state["p_n"][1:] - x[:, :2, 0]) / found.sd["p_n"][1:]
        out.append(np.column_stack([p, yaw])[40:] ** 2)
    return np.array(out)


def _from_zero(log):
    one = log.streams["range"]
    first = one.values[:1].copy()
    first[0, 0] = np.nan
    values = np.vstack([first, one.values])
    return Log({"range": type(one)("range", np.append(0.0, one.t), values, "m", "a")}, "made")


def test_errors_are_as_large_as_the_filter_says():
    good = squares(60, PATTERN)
    for axis in range(3):
        test = consistency(good[..., axis], 1)
        assert 0.8 < test.mean < 1.25 and test.inside > 0.8
    assert squares(10, None)[..., 2].mean() > 2  # antennas that are not modelled show in the heading


def test_readings_carry_anchor_lever_and_antenna():
    ranges = Ranges(np.arange(3.0), np.array([2, 0, 1]), np.array([1, 0, 1]), np.ones(3), ANCHORS, ("f", "r"), LEVER_B)
    values = planar_stream(ranges, PATTERN).values
    for row, (anchor, tag) in zip(values, ((2, 1), (0, 0), (1, 1)), strict=True):
        np.testing.assert_array_equal(row, [1.0, *known(anchor, tag)])
    np.testing.assert_array_equal(planar_stream(ranges).values[:, 7:], 0.0)
    bare = Ranges(ranges.t, ranges.anchor, ranges.tag, ranges.distance, ANCHORS, ("f", "r"))
    with pytest.raises(InputError, match="lever arms"):
        planar_stream(bare)
    for bad in (PATTERN[:1], PATTERN[:, :3], np.full((2, 4), np.nan)):
        with pytest.raises(InputError, match="antenna pattern"):
            planar_stream(ranges, bad)
