from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from robustnav.design import SensorRows, Startup, Turning, gain_table, posterior_bound
from robustnav.design.flow import LyapunovMap, PeriodicFlow, RiccatiMap
from robustnav.design.sampled import SampledSystem
from robustnav.errors import EstimatorError, InputError
from robustnav.frames import quat_from_rotvec, rotate
from robustnav.units import DEG, DPS, STANDARD_GRAVITY

ACQUISITION = np.diag([(5 * DEG) ** 2] * 2 + [(10 * DEG) ** 2] + [DPS**2] * 3)
NEAR = np.diag([DEG**2] * 3 + [(0.1 * DPS) ** 2] * 3)


@dataclass(frozen=True)
class Sampled:
    F: np.ndarray
    Q: np.ndarray
    sensors: list
    dt: float = 0.1


def design(s, **options):
    return gain_table(s.F, s.Q, s.sensors, s.dt, Startup(**options) if options else None)


def optimum(s, P0, ticks):
    """Optimal posterior at every tick, by the plain recursion of the bound."""
    F, Q = np.tile(s.F, (ticks, 1, 1)), np.tile(s.Q, (ticks, 1, 1))
    F[0], Q[0] = np.eye(len(s.F)), 0.0
    rows = [(np.tile(g.H, (ticks, 1, 1)), g.variance, np.arange(ticks) % g.every == 0) for g in s.sensors]
    return posterior_bound(F, Q, rows, P0)


def actual(s, table, P0, ticks):
    """True posterior error covariance with the table's gains, tick by tick."""
    H = np.vstack([g.H for g in s.sensors])
    R = np.diag(np.concatenate([np.full(len(g.H), g.variance) for g in s.sensors]))
    P, out = P0, []
    for k in range(ticks):
        mask = sum((k % g.every == 0) << j for j, g in enumerate(s.sensors))
        if mask:
            K = table.gains[np.searchsorted(table.times, k * s.dt, side="right") - 1, mask - 1]
            left = np.eye(len(P)) - K @ H
            P = left @ P @ left.T + K @ R @ K.T
        out.append(P)
        P = s.F @ P @ s.F.T + s.Q
    return np.array(out)


def sd(P):
    return np.sqrt(np.diagonal(P, axis1=-2, axis2=-1))


def test_steady_gain_equals_scipy_dare(make_sampled):
    s = make_sampled()
    table = design(s)
    H = np.vstack([g.H for g in s.sensors])
    R = np.diag(np.repeat([g.variance for g in s.sensors], 3))
    P = solve_discrete_are(s.F.T, H.T, s.Q, R)
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    assert np.allclose(table.gains[0, 2], K, rtol=1e-7, atol=1e-8 * np.abs(K).max(axis=0))
    accel = s.sensors[0].H
    alone = np.linalg.solve(accel @ P @ accel.T + R[:3, :3], accel @ P).T
    assert np.allclose(table.gains[0, 0][:, :3], alone, rtol=1e-7, atol=1e-8 * np.abs(alone).max())
    assert np.all(table.gains[0, 0][:, 3:] == 0)
    assert np.allclose(table.covariance[0], (np.eye(6) - K @ H) @ P, rtol=1e-6, atol=1e-9 * np.abs(P).max())
    assert table.certificate.ok
    assert table.certificate.ratio == pytest.approx(1, abs=1e-9)
    assert table.certificate.time_constant == pytest.approx(70.7, abs=0.1)


def test_velocity_position_chain_figures():
    """Known gains and time constants of a tilt, bias, velocity, position chain at 285.7 Hz."""
    dt, g = 1 / 285.7142857, STANDARD_GRAVITY
    F = np.eye(4)
    F[0, 1], F[2, 0], F[2, 1], F[3, 0], F[3, 2] = -dt, g * dt, -g * dt**2 / 2, g * dt**2 / 2, dt
    Q = np.diag([(0.1 * DEG) ** 2 * dt, (1e-3 * DEG) ** 2 * dt, 1e-4 * dt, 1e-12])
    Q[2, 2] = (0.01) ** 2 * dt
    rows = np.eye(4)
    sensors = [
        SensorRows("velocity", rows[2:3], 0.5**2 * 0.5 / dt),
        SensorRows("position", rows[3:], 0.2**2 * 0.5 / dt),
    ]
    table = gain_table(F, Q, sensors, dt)
    expected = [[6.779e-6, 4.151e-5], [-6.577e-8, -3.986e-7], [2.011e-4, 1.647e-3], [2.636e-4, 3.328e-3]]
    assert np.allclose(table.gains[0, 2], expected, rtol=2e-3)
    assert table.certificate.time_constant == pytest.approx(100, rel=0.03)
    heading = gain_table(
        [[1, -dt], [0, 1]],
        np.diag([(0.1 * DEG) ** 2 * dt, (3e-4 * DEG) ** 2 * dt]),
        [SensorRows("heading", np.array([[1.0, 0.0]]), (6 * DEG) ** 2 * 0.1 / dt)],
        dt,
    )
    assert np.allclose(heading.gains[0, 0][:, 0], [1.947e-4, -5.533e-7], rtol=2e-3)


@pytest.mark.parametrize(("P0", "mag_every"), [(NEAR, 1), (ACQUISITION, 1), (ACQUISITION, 4)])
def test_32_sets_cost_two_percent(make_sampled, P0, mag_every):
    s = make_sampled(mag_every=mag_every)
    table = design(s, P0=P0)
    best, held = optimum(s, P0, 5000), actual(s, table, P0, 5000)
    cost = np.sqrt(np.diagonal(held.mean(0)) / np.diagonal(best.mean(0)))
    assert np.all(cost >= 1 - 1e-9)
    assert cost.max() < 1.02
    assert (sd(held) / sd(best)).max() < 1.06


def test_more_sets_cost_less(make_sampled):
    s = make_sampled(mag_every=4)
    best = optimum(s, ACQUISITION, 3000)

    def cost(sets):
        held = actual(s, design(s, P0=ACQUISITION, sets=sets), ACQUISITION, 3000)
        return np.sqrt(np.trace(held.mean(0)) / np.trace(best.mean(0))) - 1

    assert cost(12) > cost(24) > cost(48) > 0
    assert cost(12) < 0.2


def test_covariance_is_what_the_held_gains_leave(make_sampled):
    s = make_sampled(mag_every=3)
    table = design(s, P0=NEAR, sets=24)
    assert len(table.times) == 24
    edges = np.ceil(table.times / s.dt - 1e-9).astype(int)
    held = actual(s, table, NEAR, edges[-1])
    for i in range(23):
        mean = held[edges[i] : edges[i + 1]].mean(0)
        assert np.allclose(sd(table.covariance[i]), sd(mean), rtol=0.02), i


def test_first_set_is_the_first_kalman_update(make_sampled):
    s = make_sampled(mag_every=5)
    table = design(s, P0=ACQUISITION)
    H, R = np.vstack([g.H for g in s.sensors]), np.diag(np.repeat([g.variance for g in s.sensors], 3))
    K = np.linalg.solve(H @ ACQUISITION @ H.T + R, H @ ACQUISITION).T
    assert table.times[0] == 0
    assert np.allclose(table.gains[0, 2], K, rtol=1e-9, atol=1e-12 * np.abs(K).max())
    assert np.array_equal(table.gains[-1], design(s).gains[0])


def two_rates():
    """A decaying rate and its integral, seen by two sensors every 3 and 4 ticks."""
    sensors = [SensorRows("a", [[1.0, 0.0]], 0.5, 3), SensorRows("b", [[1.0, 0.3]], 0.2, 4)]
    return Sampled(np.array([[1.0, 0.1], [0.0, 0.98]]), np.diag([0.001, 0.0005]), sensors)


def test_last_set_takes_over_when_settled():
    s, P0 = two_rates(), np.diag([25.0, 4.0])
    last = round(design(s, P0=P0, sets=8).times[-1] / s.dt + 0.5)
    assert last % 12 == 0
    best = optimum(s, P0, 3600)
    priors = s.F @ best @ s.F.T + s.Q  # of the tick after
    steady = priors[-1]

    def distance(tick):
        return np.max(np.abs(priors[tick - 1] - steady) / np.outer(sd(steady), sd(steady)))

    assert distance(last) < 0.02 < distance(last - 12)


def test_multirate_steady_state():
    """Periodic optimum and held gains by plain recursion over many periods of 12 ticks."""
    s = two_rates()
    table = design(s)
    best = optimum(s, np.eye(2), 3600)[-12:].mean(0)
    held = actual(s, table, np.eye(2), 3600)[-12:].mean(0)
    assert table.certificate.promised == pytest.approx(np.sqrt(np.trace(best)), rel=1e-12)
    assert table.certificate.verified == pytest.approx(np.sqrt(np.trace(held)), rel=1e-12)
    assert 1 + 1e-6 < table.certificate.ratio < 1.01
    assert np.allclose(table.covariance[0], held, rtol=1e-10)


def test_ticks_without_any_sensor():
    """A scalar walk seen every third tick: prior p solves p = p r / (p + r) + 3 q."""
    q, r = 0.2, 1.0
    table = gain_table([[1.0]], [[q]], [SensorRows("x", [[1.0]], r, every=3)], 0.1, Startup([[50.0]], sets=8))
    p = (3 * q + np.sqrt(9 * q**2 + 12 * q * r)) / 2
    assert table.gains[-1, 0, 0, 0] == pytest.approx(p / (p + r), rel=1e-12)
    posterior = p * r / (p + r)
    assert table.covariance[-1, 0, 0] == pytest.approx(posterior + q, rel=1e-12)


def test_units_of_the_state_do_not_matter(make_sampled):
    s = make_sampled(mag_every=2)
    T = np.array([1e6, 1.0, 1e-3, 1e6, 1.0, 1e-6])
    scaled = gain_table(
        T[:, None] * s.F / T,
        T[:, None] * s.Q * T,
        [SensorRows(g.name, g.H / T, g.variance, g.every) for g in s.sensors],
        s.dt,
        Startup(T[:, None] * NEAR * T),
    )
    table = design(s, P0=NEAR)
    assert np.array_equal(scaled.times, table.times)
    assert np.allclose(
        scaled.gains / T[:, None], table.gains, rtol=1e-6, atol=1e-8 * np.abs(table.gains).max(axis=(0, 1))
    )


def test_half_tick_edges_survive_rounding(make_sampled):
    s = make_sampled()
    times = design(s, P0=NEAR).times
    edge = (times[1:] / s.dt) % 1
    assert np.allclose(edge, 0.5)
    assert np.all(np.diff(times) > 0)


@pytest.mark.parametrize("steps", [1, 2, 5, 13])
def test_composed_maps_equal_single_steps(make_sampled, steps):
    s = make_sampled()
    rng = np.random.default_rng(steps)
    flow = PeriodicFlow(
        [
            RiccatiMap(s.F, g.H.T @ g.H / g.variance, s.Q)
            for g in (s.sensors[0], s.sensors[1], s.sensors[0])
        ]
    )  # fmt: skip
    P = walked = ACQUISITION
    for _ in range(steps):
        for tick in flow.ticks:
            walked = tick(walked)
    assert np.allclose(flow.jump(P, steps), walked, rtol=1e-9, atol=1e-12 * np.abs(walked).max())
    held = PeriodicFlow([LyapunovMap(0.9 * rng.normal(size=(6, 6)), np.eye(6)) for _ in range(3)])
    walked = P
    for _ in range(steps):
        for tick in held.ticks:
            walked = tick(walked)
    assert np.allclose(held.jump(P, steps), walked, rtol=1e-9)


@pytest.mark.parametrize(("start", "stop"), [(0, 3), (3, 7), (0, 4), (2, 40), (4, 4000), (5, 12)])
def test_visit_covers_the_interval(start, stop):
    flow = PeriodicFlow([LyapunovMap(np.eye(1), np.eye(1))] * 4)
    seen, P = flow.visit(np.array([[float(start)]]), start, stop)
    assert P[0, 0] == stop
    assert seen.weights.sum() == pytest.approx(stop - start)
    assert np.array_equal(seen.phases, seen.priors[:, 0, 0] % 4)
    assert seen.mean()[0, 0] == pytest.approx((start + stop - 1) / 2)


def test_unseen_state_is_named():
    with pytest.raises(EstimatorError, match="state 1 keeps growing"):
        gain_table(np.eye(2), np.eye(2), [SensorRows("x", [[1.0, 0.0]], 1.0)], 0.1)
    with pytest.raises(EstimatorError, match="state 1 keeps growing"):
        gain_table(np.diag([1.0, 1.5]), np.eye(2), [SensorRows("x", [[1.0, 0.0]], 1.0)], 0.1)


def test_state_without_noise_is_refused():
    with pytest.raises(EstimatorError, match="spectral radius"):
        gain_table(np.eye(1), np.zeros((1, 1)), [SensorRows("x", [[1.0]], 1.0)], 0.1)


def test_bad_input():
    one = SensorRows("x", [[1.0]], 1.0)
    good = {"F": [[1.0]], "Q": [[1.0]], "sensors": [one], "dt": 0.1}
    for change, words in (
        ({"F": [[1.0, 0.0]]}, "F"),
        ({"Q": [[-1.0]]}, "Q"),
        ({"sensors": []}, "sensors"),
        ({"sensors": [one] * 9}, "sensors"),
        ({"sensors": [SensorRows("x", [[1.0, 2.0]], 1.0)]}, "sensor 'x'"),
        ({"dt": 0.0}, "dt"),
        ({"startup": Startup([[np.nan]])}, "P0"),
        ({"startup": Startup([[1.0]], sets=1)}, "sets"),
        ({"sensors": [SensorRows("x", [[1.0]], 1.0, 199), SensorRows("y", [[1.0]], 1.0, 211)]}, "rates"),
    ):
        with pytest.raises(InputError, match=words):
            gain_table(**(good | change))
    for arguments in (([[1.0]], 0.0), ([[1.0]], np.inf), ([[1.0]], 1.0, 0), ([[1.0]], 1.0, 1.5), ([1.0], 1.0)):
        with pytest.raises(InputError, match="'x'"):
            SensorRows("x", *arguments)


def test_turning_carrier_keeps_the_size_of_a_vector_and_forgets_its_direction():
    """Against its definition: many small random rotations of vectors drawn from P."""
    rng = np.random.default_rng(5)
    intensity, dt, steps = 0.4, 0.01, 100
    P = np.diag([4.0, 1.0, 0.25])
    vectors = rng.multivariate_normal(np.zeros(3), P, size=40_000)
    system = SampledSystem(np.eye(3), np.zeros((3, 3)), [SensorRows("v", np.eye(3), 1.0)], dt)
    for _ in range(steps):
        angle = np.sqrt(intensity * dt) * rng.normal(size=vectors.shape)
        vectors = rotate(quat_from_rotvec(angle), vectors)
        P = LyapunovMap(*(getattr(system.turned(P, Turning((slice(0, 3),), intensity)), m) for m in "FQ"))(P)
    assert np.trace(P) == pytest.approx(5.25, rel=2e-3)
    assert np.allclose(P, np.cov(vectors.T), atol=4 * 4 * np.sqrt(2 / 40_000))
    decayed = 5.25 / 3 + (np.array([4.0, 1.0, 0.25]) - 5.25 / 3) * np.exp(-3 * intensity * dt * steps)
    assert np.allclose(np.diag(P), decayed, rtol=0.01)


def test_schedule_for_a_turning_carrier(make_sampled):
    s = make_sampled()
    still, turning = (design(s, P0=ACQUISITION, turning=Turning((slice(3, 6),), x)) for x in (0.0, 0.05))
    plain = design(s, P0=ACQUISITION)
    assert np.array_equal(still.gains, plain.gains)
    assert np.array_equal(turning.gains[-1], plain.gains[-1])
    middle = slice(12, -4)
    # Turning carries the poorly seen vertical bias into the well seen horizontal ones.
    assert np.all(sd(turning.covariance)[middle, 3:5] > sd(plain.covariance)[middle, 3:5])
    assert turning.certificate.ok


def test_turning_bad_input():
    for intensity in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="turning"):
            Turning((slice(0, 3),), intensity)
