"""One filter, however it runs: NumPy, C, float, whole, in parts, sample by sample, put back from a snapshot."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from robustnav.engine import CompiledModel, KernelFilter, SensorData, compile_model
from robustnav.engine.reference import ReferenceFilter
from robustnav.errors import InputError
from robustnav.filter.ukf import Spread
from robustnav.filter.weighting import Gate, Huber, StudentT
from robustnav.model import Equations, Model, Noise, NumericModel, Sensor, Vector
from robustnav.run import UKF, Start


def kernel(case, real="double"):
    functions = CompiledModel(case.model, real="float") if real == "float" else compile_model(case.model)
    return KernelFilter(functions, case.setup)


def test_c_is_numpy(case, same):
    expected = ReferenceFilter(NumericModel(case.model), case.setup).run(case.t, case.u, case.sensors)
    same(kernel(case).run(case.t, case.u, case.sensors), expected, 1e-11)
    used = [one.used.sum() for one in expected.seen]
    assert all(20 < n <= len(d.t) - 4 for n, d in zip(used, case.sensors, strict=True))  # early, late and NaN: not used
    if case.model.prebuilt:
        wide = {"inertial": 1e-3, "alignment": 1e-3, "alignment_so3_3": 3e-3}  # sizes far apart in one state
        tolerance = wide.get(case.model.name, 6e-5)
        same(kernel(case, "float").run(case.t, case.u, case.sensors), expected, tolerance)


@pytest.mark.parametrize("kind", ["ekf", "ukf"])
def test_c_is_numpy_with_gates(plain, same, kind):
    case = plain(kind)
    readings = [SensorData(d.t, d.z.copy()) for d in case.sensors]
    readings[1].z[5::3] += 0.2  # half of the field: refused
    case.setup = replace(case.setup, rules=(Gate(9.0), Gate(6.0)))
    expected = ReferenceFilter(NumericModel(case.model), case.setup).run(case.t, case.u, readings)
    refused = np.isfinite(expected.seen[1].nis) & ~expected.seen[1].used
    assert 3 < refused.sum() < len(refused) - 10 and (expected.seen[1].nis[refused] > 6).all()
    same(kernel(case).run(case.t, case.u, readings), expected, 1e-12)


@pytest.mark.parametrize("name", ["attitude", "uwb_3d"])
@pytest.mark.parametrize("kind", ["ekf", "ukf"])
@pytest.mark.parametrize("rule", [Huber(1.0), StudentT(3.0)])
def test_c_is_numpy_with_soft_rules(plain, same, kind, name, rule):
    case = plain(kind, name)
    readings = [SensorData(d.t, d.z.copy()) for d in case.sensors]
    readings[0].z[5::3, 0] += 4.0  # far off
    case.setup = replace(case.setup, rules=(rule,) * len(readings))
    expected = ReferenceFilter(NumericModel(case.model), case.setup).run(case.t, case.u, readings)
    soft = expected.seen[0].weight[expected.seen[0].weight < 0.9]
    assert 3 < len(soft) < len(expected.seen[0].weight) - 5 and (soft > 0).all()
    same(kernel(case).run(case.t, case.u, readings), expected, 1e-11)


@pytest.mark.parametrize("name", ["pendulum", "range_bearing", "attitude", "alignment"])
def test_c_is_numpy_with_another_spread_of_points(plain, same, name):
    """A centre of negative weight, in sensors that see all of the state and in those that see a part."""
    case = plain("ukf", name)
    case.setup = replace(case.setup, spread=Spread(0.5, 2.0, 1.0))
    expected = ReferenceFilter(NumericModel(case.model), case.setup).run(case.t, case.u, case.sensors)
    same(kernel(case).run(case.t, case.u, case.sensors), expected, 1e-11)


def test_c_is_numpy_where_nothing_moves_and_where_nothing_is_seen(same):
    model = Model(
        name="standing",
        state=(Vector("x", "m", 2),),
        inputs=(),
        noises=(Noise("walk", "m/sqrt(s)", 0.2, 2),),
        sensors=(Sensor("square", "m^2", 0.3, 1), Sensor("nothing", "m", 0.5, 1)),
        equations=lambda s: Equations({"x": s.walk}, {"square": s.x[0] ** 2, "nothing": (3,)}),
        start_sd={"x": 0.5},
        nominal={"x": (1.0, 2.0)},
    )
    t, setup = np.arange(1.0, 6.0), UKF(model, Spread(0.7, 2.0, 1.0)).setup((s := Start.at(model)).x, s.P)
    readings = [SensorData(t, np.array([[1.0], [1.5], [0.9], [1.2], [1.1]])), SensorData(t, 3.2 * np.ones((5, 1)))]
    one = SimpleNamespace(model=model, setup=setup)
    expected = ReferenceFilter(NumericModel(model), setup).run(t, np.zeros((5, 0)), readings)
    same(kernel(one).run(t, np.zeros((5, 0)), readings), expected, 1e-12)
    np.testing.assert_array_equal(expected.x[:, 1], 2.0)


def test_gain_sets_change_at_their_time_to_the_bit(plain):
    """Steps of 1/64 s add up without rounding, so that the set's time is met exactly."""
    case = plain("fixed")
    gains = np.cumsum(np.tile(case.setup.gains[-1], (3, 1, 1, 1)), axis=0)
    case.setup = replace(case.setup, times=np.array([0.0, 0.25, 0.5]), gains=gains)
    t, u = np.arange(40) / 64, np.nan_to_num(case.u[:40])
    sensors = [SensorData(t, np.tile(d.z[10], (40, 1))) for d in case.sensors]
    expected = ReferenceFilter(NumericModel(case.model), case.setup).run(t, u, sensors)
    np.testing.assert_allclose(kernel(case).run(t, u, sensors).x, expected.x, atol=1e-12)


def test_a_reading_at_the_very_time_of_the_state_is_fused(plain, same):
    case = plain()
    late = [SensorData(case.t[19:20], d.z[10:11]) for d in case.sensors]
    outputs = []
    for running in (kernel(case), ReferenceFilter(NumericModel(case.model), case.setup)):
        running.run(case.t[:20], case.u[:20], [None, None])
        outputs.append(running.run(case.t[20:25], case.u[20:25], late))
        assert outputs[-1].seen[0].used.all()
    same(*outputs, 1e-12)


def test_a_sensor_that_is_absent(plain, same):
    case = plain("fixed")
    sensors = [case.sensors[0], None]
    expected = ReferenceFilter(NumericModel(case.model), case.setup).run(case.t, case.u, sensors)
    same(kernel(case).run(case.t, case.u, sensors), expected, 1e-12)
    assert expected.seen[1] is None


def parts(case, at):
    """The streams up to and after an input row."""
    cut = case.t[at - 1]
    rows = [int(np.searchsorted(d.t, cut, side="right")) for d in case.sensors]
    first = [SensorData(d.t[:k], d.z[:k]) for d, k in zip(case.sensors, rows, strict=True)]
    second = [SensorData(d.t[k:], d.z[k:]) for d, k in zip(case.sensors, rows, strict=True)]
    return (case.t[:at], case.u[:at], first), (case.t[at:], case.u[at:], second)


@pytest.mark.parametrize("at", [1, 31, 45, 60])
@pytest.mark.parametrize("kind", ["ekf", "ukf", "fixed"])
def test_a_run_in_parts_is_the_whole_run(plain, kind, at):
    case = plain(kind)
    whole = kernel(case).run(case.t, case.u, case.sensors)
    one, (first, second) = kernel(case), parts(case, at)
    x = np.vstack([one.run(*first).x, (late := one.run(*second)).x])
    np.testing.assert_array_equal(x, whole.x)
    kept = one.snapshot()
    other = kernel(case)  # from a snapshot between the parts
    other.run(*first)
    fresh = kernel(case)
    fresh.restore(other.snapshot())
    again = fresh.run(*second)
    np.testing.assert_array_equal(again.x, late.x)
    for a, b in zip(fresh.snapshot(), kept, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("kind", ["ekf", "ukf", "fixed"])
def test_the_reference_continues_from_a_snapshot_too(plain, kind):
    case = plain(kind)
    first, second = parts(case, 45)
    numeric = NumericModel(case.model)
    one, other = (ReferenceFilter(numeric, case.setup) for _ in range(2))
    one.run(*first)
    other.restore(one.snapshot())
    np.testing.assert_array_equal(one.run(*second).x, other.run(*second).x)


def feed(running, t, u, sensors):
    """Sample by sample, with the readings of the input times."""
    states = []
    for k, now in enumerate(t):
        readings = [d.z[np.flatnonzero(d.t == now)[0]] if now in d.t else None for d in sensors]
        running.update(u[k], *readings, float(now - t[k - 1]) if k else 0.0)
        states.append(running.state)
    return np.array(states)


@pytest.mark.parametrize("kind", ["ekf", "ukf", "fixed"])
def test_updates_are_the_batch(plain, kind):
    case = plain(kind)
    t, u = 0.01 * np.arange(80), np.nan_to_num(case.u[:80])
    sensors = [
        SensorData(t[::k], case.sensors[k - 1].z[10:11] + 0.01 * np.arange(len(t[::k]))[:, None]) for k in (1, 2)
    ]
    sensors[1].z[3] = np.nan
    batch, live = kernel(case), kernel(case)
    whole = batch.run(t, u, sensors)
    np.testing.assert_array_equal(feed(live, t, u, sensors), whole.x)
    np.testing.assert_array_equal(live.covariance, batch.covariance)
    reference = ReferenceFilter(NumericModel(case.model), case.setup)
    np.testing.assert_allclose(feed(reference, t, u, sensors), whole.x, atol=1e-11)
    assert reference.snapshot()[3] == pytest.approx(live.snapshot()[3])


def test_a_run_goes_on_after_updates(plain):
    case = plain()
    numeric = NumericModel(case.model)
    for running in (kernel(case), ReferenceFilter(numeric, case.setup)):
        running.run(case.t[:20], case.u[:20], [None, None])
        running.update(case.u[1], None, None, 0.5)
        assert running.snapshot()[2] == pytest.approx(case.t[19] + 0.5)


def test_readings_alone_may_be_fused(plain):
    case = plain()
    for running in (kernel(case), ReferenceFilter(NumericModel(case.model), case.setup)):
        before = running.covariance
        running.update(None, case.sensors[0].z[0], None, 0.0)
        assert np.trace(running.covariance) < np.trace(before)


@pytest.mark.parametrize(
    "arguments",
    [
        (np.zeros(3), None, None, -0.01),
        (np.zeros(3), None, None, np.nan),
        (np.array([np.nan, 0, 0]), None, None, 0.01),
        (np.zeros(2), None, None, 0.01),
        (None, None, None, 0.01),
        (np.zeros(3), np.zeros(1), None, 0.01),
        (np.zeros(3), np.zeros((3, 1)), None, 0.01),
        (np.zeros(3), None, 0.01),
    ],
)
def test_bad_updates_are_refused_and_change_nothing(plain, arguments):
    case = plain()
    for running in (kernel(case), ReferenceFilter(NumericModel(case.model), case.setup)):
        before = running.snapshot()
        with pytest.raises((ValueError, TypeError)):
            running.update(*arguments)
        for a, b in zip(running.snapshot(), before, strict=True):
            np.testing.assert_array_equal(a, b)


def test_bad_arrays_are_refused(plain):
    case = plain()
    with pytest.raises(InputError, match="filter input"):
        kernel(case).run(case.t, case.u[:, :2], case.sensors)
    with pytest.raises(ValueError, match="readings"):
        kernel(case).run(case.t, case.u, [SensorData(case.sensors[0].t, case.sensors[0].z[:, :2]), None])
    with pytest.raises(ValueError):
        kernel(case).run(case.t, case.u, [None])


def test_arrays_of_any_layout_are_taken(plain, same):
    case = plain()
    expected = kernel(case).run(case.t, case.u, case.sensors)
    odd = np.asfortranarray(case.u)
    sensors = [SensorData(np.repeat(d.t, 2)[::2], np.asfortranarray(d.z)) for d in case.sensors]
    same(kernel(case).run(case.t, odd, sensors), expected, 0)
    lean = kernel(case).run(case.t, case.u, case.sensors, covariance=False, innovations=False)
    np.testing.assert_array_equal(lean.x, expected.x)
    assert lean.P is None and lean.seen == (None, None)


@pytest.mark.parametrize("kind", ["ekf", "ukf"])
@pytest.mark.parametrize("value", [np.nan, -1e3])
def test_a_broken_covariance_is_refused_and_seen(plain, kind, value):
    """Every reading is refused and flagged, the state moves with the gyro alone, and stays finite."""
    case = plain(kind)
    P = case.setup.P.copy()
    P[1, 1] = value
    case.setup = replace(case.setup, P=P)
    for running in (kernel(case), ReferenceFilter(NumericModel(case.model), case.setup)):
        out = running.run(case.t, case.u, case.sensors)
        assert not out.seen[1].used.any()
        assert np.isfinite(out.x).all()
        assert not np.isfinite(out.P).all() or (out.P[:, 6] < 0).all()


def test_a_covariance_broken_where_no_sensor_sees_it_shows_at_the_next_prediction(plain):
    case = plain("ukf")
    P = case.setup.P.copy()
    P[5, 5] = -1.0  # of the gyro's bias
    case.setup = replace(case.setup, P=P)
    running = kernel(case)
    running.update(None, case.sensors[0].z[0], None, 0.0)
    assert np.isfinite(running.state).all() and running.covariance[5, 5] < 0
    running.update(np.zeros(3), None, None, 0.01)
    assert np.isfinite(running.state).all() and not np.isfinite(running.covariance).all()


@pytest.mark.parametrize("kind", ["ekf", "ukf"])
@pytest.mark.parametrize(("real", "value"), [("double", 1e200), ("float", 1e30), ("float", 1e60)])
def test_a_wild_reading_is_refused_even_without_a_gate(plain, kind, real, value):
    case = plain(kind)
    running = kernel(case, real)
    before = running.snapshot()
    running.update(np.zeros(3), None, np.array([value, 0.1, -value]), 0.0)
    for a, b in zip(running.snapshot(), before, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_covariance_that_just_lost_definiteness_is_refused(plain):
    """An innovation variance a fifth below the sensor's own can only come from a broken covariance."""
    case = plain()
    P = case.setup.P.copy()
    P[1, 1] = -0.2 * case.model.variances[1] / 0.75
    case.setup = replace(case.setup, P=P)
    for running in (kernel(case), ReferenceFilter(NumericModel(case.model), case.setup)):
        running.update(np.zeros(3), None, np.array([0.5, 0.0, 0.9]), 0.0)
        np.testing.assert_array_equal(running.covariance, P)


def test_a_state_that_is_not_finite_does_not_spread_into_the_covariance(plain):
    case = plain()
    x = case.setup.x.copy()
    x[1] = np.nan
    case.setup = replace(case.setup, x=x)
    for running in (kernel(case), ReferenceFilter(NumericModel(case.model), case.setup)):
        running.update(np.zeros(3), None, np.array([0.1, 0.2, 0.3]), 0.0)
        np.testing.assert_array_equal(running.covariance, case.setup.P)
