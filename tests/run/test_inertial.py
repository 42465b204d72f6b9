"""The inertial filter without a prior: from rest and in motion, honest, near its bound, causal, found again."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from robustnav.design.bounds import PathRows, posterior_bound
from robustnav.engine.backends import functions_of
from robustnav.errors import EstimatorError, InputError
from robustnav.evaluate.consistency import consistency
from robustnav.frames import euler_from_quat, quat_conjugate, quat_from_euler, rotate, rotation_error
from robustnav.models import AidingNoise, InertialNoise, RangeBias, inertial, uwb
from robustnav.records import Log, RangeDifferences, Stream
from robustnav.run import EKF
from robustnav.run.acquisition import Acquisition
from robustnav.run.inertial import run_inertial
from robustnav.run.inertial_start import InertialStart, Level, _start
from robustnav.sim.quadcopter import differences_setup, ranges_setup
from robustnav.sim.ranging import simulate_ranging
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.ranging_path import FigureEight, Path, Rest, SampledPath
from robustnav.sim.ranging_setup import Schedule
from robustnav.snapshot.window import Minimum
from robustnav.units import DEG, STANDARD_GRAVITY

HZ, SD, GYRO_BIAS, ACCEL_BIAS = 50.0, 0.1, 0.5 * DEG, 0.1
NOISE = InertialNoise(2e-3, 0.02, 1e-5, 1e-4)
LEVER_B = np.array([[0.1, 0.05, -0.03]])
HEADING = 2.2
PATH = Path(
    (0.0, 0.0, -1.0), HEADING, (Rest(1.2), FigureEight(2.5, 1.6, 0.4, 2, 14.0, 1.0)), STANDARD_GRAVITY, tilts=True
)
STATES = SampledPath(PATH, HZ).states()
RUNS = 100
MODEL = replace(
    inertial(NOISE, AidingNoise(range_sd=SD)),
    start_sd={"q_nb": 0.0, "v_n": 1.0, "p_n": 1.0, "gyro_bias": GYRO_BIAS, "accel_bias": ACCEL_BIAS},
)
SETTINGS = InertialStart(acquisition=Acquisition(speed=1.5))


def setup(make=ranges_setup):
    schedule = Schedule(10.0, PATH.duration, simultaneous=False)
    return replace(make(RangingErrors(white_sd=SD)), lever_b=LEVER_B, schedule=schedule)


def true_inputs():
    """Return gyro and accelerometer that lead the model's half-way step along the path: mean rate and mean force."""
    motion = SampledPath(PATH, HZ).sample()
    v_n = STATES.v_n
    step = np.vstack([[0.0, 0, 0], np.diff(v_n, axis=0) * HZ]) - [0.0, 0.0, STANDARD_GRAVITY]
    middle = SampledPath(PATH, 2 * HZ).states().q_nb[1::2]
    return motion.omega_b, rotate(quat_conjugate(np.vstack([STATES.q_nb[:1], middle])[: len(step)]), step)


GYRO, ACCEL = true_inputs()


def log_of(run, begin=0.0):
    rng, root = np.random.default_rng([3, run]), np.sqrt(HZ)
    shape = GYRO.shape
    gyro = GYRO + rng.normal(0, GYRO_BIAS, 3) + rng.normal(0, NOISE.gyro_density * root, shape)
    accel = ACCEL + rng.normal(0, ACCEL_BIAS, 3) + rng.normal(0, NOISE.accel_density * root, shape)
    keep = STATES.t >= begin
    streams = {
        "gyro": Stream("gyro", STATES.t[keep], gyro[keep], "rad/s"),
        "accel": Stream("accel", STATES.t[keep], accel[keep], "m/s^2"),
    }
    return Log(streams, "made")


@pytest.fixture(scope="module")
def ranging():
    one = setup()
    return simulate_ranging(PATH.at(one.events.t), one, runs=RUNS, seed=5)


def cut(readings, begin, end=np.inf):
    return readings.where((readings.t >= begin) & (readings.t <= end))


def errors(run):
    """Return attitude, velocity and position errors (n, 9) and their standard deviations."""
    k = np.searchsorted(STATES.t, run.t - 1e-6)
    turned = rotation_error(STATES.q_nb[k], run.state["q_nb"])
    e = np.hstack([turned, STATES.v_n[k] - run.state["v_n"], STATES.p_n[k] - run.state["p_n"]])
    return e, np.hstack([run.sd["q_nb"], run.sd["v_n"], run.sd["p_n"]])


def bound(begin):
    """Return standard deviations (n, 9) of the posterior bound from ``begin`` on, at the times of the inputs."""
    functions = functions_of(MODEL)
    first = int(np.searchsorted(STATES.t, begin))
    zero = np.zeros(6)
    x = [np.concatenate([STATES.q_nb[k], STATES.v_n[k], STATES.p_n[k], zero]) for k in range(first, len(STATES.t))]
    u = np.hstack([GYRO, ACCEL])[first:]
    moves = [functions.transition(a, b, 1 / HZ) for a, b in zip(x[:-1], u[1:], strict=True)]
    t = STATES.t[first:]
    events, p_a = setup().events, setup().anchors.p_a
    step = np.searchsorted(t, events.t) - 1
    updates = []
    for kth in range(2):  # at 80 ranges a second there are up to two in a step
        H, used = np.zeros((len(moves), 1, 15)), np.zeros(len(moves), bool)
        for s in range(len(moves)):
            rows = np.flatnonzero(step == s)
            if len(rows) > kth:
                known = np.concatenate([p_a[events.second[rows[kth]]], LEVER_B[0]])
                H[s], used[s] = functions.jacobian(0, x[s + 1], known), True
        updates.append(PathRows(H, SD**2, used))
    P0 = MODEL.start_covariance({"q_nb": (2 * DEG, 2 * DEG, 1.0)})
    P = posterior_bound(np.array([F for F, _ in moves]), np.array([Q for _, Q in moves]), updates, P0)
    return t[1:], np.sqrt(np.diagonal(P, axis1=-2, axis2=-1))[:, :9]


@pytest.mark.parametrize("begin", [0.0, 4.0], ids=["from rest", "in motion"])
def test_errors_are_as_large_as_stated_and_near_the_bound(ranging, begin):
    runs = [run_inertial(EKF(MODEL), cut(ranging.ranges(i), begin), log_of(i, begin), SETTINGS) for i in range(RUNS)]
    found = [float(e.split()[3]) for run in runs for e in run.events if e.startswith("heading found")]
    assert len(found) == RUNS and max(found) < begin + 9
    settled = max(found) + 3.0
    both = [errors(run) for run in runs]
    early = [(e[:100:10, 2] / sd[:100:10, 2]) ** 2 for e, sd in both]  # before any heading is found
    assert np.mean(early, axis=0).max() < 2
    t = runs[0].t[-len(both[0][0]) :]
    late = min(len(e) for e, _ in both) - int(np.searchsorted(runs[0].t, settled))
    e, sd = (np.array([pair[which][-late:] for pair in both]) for which in (0, 1))
    tests = [consistency((e[:, ::10, k] / sd[:, ::10, k]) ** 2, 1) for k in range(9)]
    assert all(0.65 < test.mean < 1.35 for test in tests)  # errors last: 2.5 standard deviations of a mean over runs
    assert np.mean([test.inside for test in tests]) > 0.85
    times, least = bound(begin)
    least = least[np.searchsorted(times, t[-late:] - 1e-6)]
    rms, limit = (np.sqrt(np.mean(np.sum(a[..., 6:] ** 2, axis=-1))) for a in (e, least))
    assert 0.95 < rms / limit < 1.1
    assert np.sqrt(np.mean(e[..., 2] ** 2)) < 1.15 * np.sqrt(np.mean(least[:, 2] ** 2))


def test_a_start_errs_as_it_says_with_what_its_errors_have_in_common():
    rng, squares = np.random.default_rng(6), []
    task = SimpleNamespace(estimator=EKF(MODEL), settings=SETTINGS.acquisition, tau=0.01)
    lever_b, tag_sd, unsteady, yaw_sd = np.array([5.0, -3.0, 2.0]), 0.02, 0.15, 2 * DEG
    moved = np.hypot(tag_sd, SETTINGS.acquisition.speed * task.tau / 2)
    for _ in range(400):
        yaw = rng.uniform(-np.pi, np.pi)
        q = quat_from_euler([*rng.normal(0, 0.15, 2), yaw + rng.normal(0, yaw_sd)])
        bias, p = rng.normal(0, ACCEL_BIAS, 3), rng.normal(0, 3, 3)
        f_b = rotate(quat_conjugate(q), rng.normal(0, unsteady, 3) - [0, 0, STANDARD_GRAVITY]) + bias
        found = Minimum(p + rotate(q, lever_b) + rng.normal(0, moved, 3), tag_sd**2 * np.eye(3), 0.0)
        start = _start(task, found, Level(f_b, unsteady), lever_b, yaw, yaw_sd)
        e = np.concatenate([rotation_error(q, start.x[:4]), p - start.x[7:10], bias])
        keep = np.r_[0:3, 6:9, 12:15]
        squares.append(e @ np.linalg.solve(start.P[np.ix_(keep, keep)], e))
    assert 8.2 < np.mean(squares) < 9.8  # 9, within four standard deviations of the mean


def test_while_the_heading_is_unknown_it_says_so(ranging):
    run = run_inertial(EKF(MODEL), ranging.ranges(0), log_of(0), SETTINGS)
    rest = run.t < 1.1
    assert run.sd["q_nb"][rest, 2].min() > 80 * DEG and run.sd["q_nb"][rest, :2].max() < 4 * DEG
    assert run.sd["p_n"][rest, :2].max() < 0.5  # the tag is known, its carrier up to the lever arm
    short = run_inertial(EKF(MODEL), cut(ranging.ranges(0), 0, 1.1), _until(log_of(0), 1.1), SETTINGS)
    words = next(e for e in short.events if "heading not found" in e)
    assert len(words.split("left: ")[1].split(", ")) == SETTINGS.headings


def _until(log, end):
    return replace(log, streams={name: one.between(-1.0, end) for name, one in log.streams.items()})


def test_nothing_looks_ahead(ranging):
    whole = run_inertial(EKF(MODEL), ranging.ranges(1), log_of(1), SETTINGS)
    part = run_inertial(EKF(MODEL), cut(ranging.ranges(1), 0, 5.03), _until(log_of(1), 5.03), SETTINGS)
    n = len(part.t)
    for name, values in part.state.items():
        np.testing.assert_array_equal(values, whole.state[name][:n])
        np.testing.assert_array_equal(part.sd[name], whole.sd[name][:n])


def test_the_smoother_is_better_and_knows_the_heading_from_the_start(ranging):
    args = EKF(MODEL), ranging.ranges(2), log_of(2), SETTINGS
    (forward, sd), (back, back_sd) = (errors(run_inertial(*args, smooth=smooth)) for smooth in (False, True))
    assert np.abs(back[:, 2]).max() < 6 * DEG and back_sd[0, 2] < 5 * DEG < sd[0, 2]
    assert np.sqrt(np.mean(back[:, 6:] ** 2)) < 0.8 * np.sqrt(np.mean(forward[:, 6:] ** 2))


def test_differences_and_a_heading_sensor_do_as_well():
    one = setup(differences_setup)
    readings = simulate_ranging(PATH.at(one.events.t), one, runs=1, seed=5).differences(0)
    assert isinstance(readings, RangeDifferences)
    run = run_inertial(EKF(MODEL), readings, log_of(0), SETTINGS)
    e, _ = errors(run)
    assert np.abs(e[-100:, 2]).max() < 3 * DEG and np.abs(e[-100:, 6:]).max() < 0.4
    heading = Stream("heading", STATES.t[::10], euler_from_quat(STATES.q_nb[::10])[:, 2:], "rad", "n")
    log = log_of(0)
    aided = run_inertial(EKF(MODEL), readings, replace(log, streams={**log.streams, "heading": heading}), SETTINGS)
    assert next(float(w.split()[3]) for w in aided.events if w.startswith("heading found")) < 3


@pytest.mark.parametrize("number", [3, 4, 5])
def test_a_filter_lost_by_a_knock_starts_again(ranging, number):
    log, ranges = log_of(number), ranging.ranges(number)
    accel = log.streams["accel"]
    knocked = accel.values.copy()
    knocked[(accel.t > 6) & (accel.t < 6.1)] += [0.0, 300.0, 0.0]
    log = replace(log, streams={**log.streams, "accel": replace(accel, values=knocked)})
    run = run_inertial(EKF(MODEL), ranges, log, SETTINGS)
    assert any(e.startswith("lost and started again at 6.") for e in run.events)
    e, sd = (a[-50:] for a in errors(run))
    assert np.abs(e / sd).max() < 5 and np.abs(e[:, 6:]).max() < 0.3
    never = replace(SETTINGS, acquisition=Acquisition(speed=1.5, restart=False))
    assert not any("lost" in e for e in run_inertial(EKF(MODEL), ranges, log, never).events)


def test_biases_add_to_ranges_and_scale_to_both():
    biased = functions_of(inertial(NOISE, AidingNoise(range_sd=SD), bias=RangeBias(0.1, 0.5, 1e-3)))
    plain = functions_of(MODEL)
    rng = np.random.default_rng(2)
    x = np.concatenate([STATES.q_nb[300], rng.normal(size=12), rng.normal(0, 0.1, 8), [0.02]])
    ends, lever, slot = rng.normal(0, 5, 6), LEVER_B[0], np.eye(8)[3]
    one = plain.residual(0, x[:16], np.r_[0.0, ends[:3], lever])[0]
    both = plain.residual(1, x[:16], np.r_[0.0, ends, lever])[0]
    assert biased.residual(0, x, np.r_[0.0, ends[:3], slot, lever])[0] == pytest.approx(1.02 * one - x[19])
    assert biased.residual(1, x, np.r_[0.0, ends, lever])[0] == pytest.approx(1.02 * both)
    F, Q = biased.transition(x, np.zeros(6), 0.1)
    assert F[15, 15] == pytest.approx(1 - 0.1 / 0.5) and F[23, 23] == 1 and Q[23, 23] == 0
    assert Q[15, 15] == pytest.approx(0.1**2 * 2 / 0.5 * 0.1, rel=0.02)


def test_what_cannot_be_is_refused(ranging):
    log, ranges = log_of(0), ranging.ranges(0)
    with pytest.raises(InputError, match="uwb_3d"):
        run_inertial(EKF(uwb(range_sd=0.1, acceleration_density=1.0)), ranges, log)
    with pytest.raises(InputError, match="one table of a kind"):
        run_inertial(EKF(MODEL), [ranges, ranges], log)
    with pytest.raises(InputError, match="ranges or range differences"):
        run_inertial(EKF(MODEL), [], log)
    with pytest.raises(EstimatorError, match="no position to start from"):
        run_inertial(EKF(MODEL), ranges.where(ranges.anchor < 2), log)
    for bad in ({"headings": 3}, {"average": 0.0}, {"found_sd": float("nan")}):
        with pytest.raises(InputError, match=next(iter(bad))):
            InertialStart(**bad)
