"""Smoothing over whole logs: consistent, at the right times, and the filter's own where nothing was to come."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav import EKF, H2, UKF, Log, Start, Stream, batch, frames, run, smooth
from robustnav.engine.backends import functions_of
from robustnav.errors import EstimatorError, InputError
from robustnav.filter.batch import Effort
from robustnav.filter.weighting import StudentT
from robustnav.models import AidingNoise, AttitudeNoise, InertialNoise, attitude, inertial, uwb

ANCHORS = np.array([[0, 0, -3], [10, 0, -1], [10, 8, -3], [0, 8, -0.5], [5, 4, -4]], float)
TAG = uwb(range_sd=0.1, acceleration_density=0.8, vertical_density=0.4)


def walk(model, x, dt, rng, u=None):
    """A path (n, nx) of a model from a start, with its own noise."""
    functions, path = functions_of(model), [x]
    for k, one in enumerate(dt):
        held = np.zeros(0) if u is None else u[k]
        _, Q = functions.transition(path[-1], held, one)
        values, vectors = np.linalg.eigh(Q)
        noise = vectors @ (np.sqrt(np.maximum(values, 0)) * rng.normal(size=len(Q)))
        path.append(functions.inject(functions.propagate(path[-1], held, one), noise))
    return np.array(path)


def flight(seed, count=120, position_only=False):
    """A tag with the model's own noise, its true path, and a start with an error of its covariance."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.02, 0.08, count))
    path = walk(TAG, np.array([5, 4, -1.5, 0.2, 0, 0.0]), np.diff(t), rng)
    p_n, streams = path[:, :3], {}
    if not position_only:
        anchor = ANCHORS[rng.integers(0, 5, count)]
        d = np.linalg.norm(p_n - anchor, axis=1) + 0.1 * rng.normal(size=count)
        streams["range"] = Stream("range", t, np.c_[d, anchor], "m", "n")
    every = slice(0, None, 10)
    streams["position"] = Stream("position", t[every], p_n[every] + 0.1 * rng.normal(size=(12, 3)), "m", "n")
    sd = np.repeat([0.3, 0.5], 3)
    return Log(streams, "sim"), path, Start(path[0] + sd * rng.normal(size=6), np.diag(sd**2))


def errors(estimate, path):
    return np.hstack([estimate.state["p_n"], estimate.state["v_n"]]) - path


@pytest.mark.parametrize("kind", [EKF, UKF])
def test_errors_are_as_large_as_it_says_on_ranges(kind):
    """Each of six numbers over 150 flights at three instants: mean square over sd inside its chi-square band."""
    runs, at = 150, [0, 60, 117]
    scaled = np.zeros((runs, 3, 6))
    for seed in range(runs):
        log, path, start = flight(seed)
        out = smooth(kind(TAG), log, start)
        scaled[seed] = (errors(out, path) / np.hstack([out.sd["p_n"], out.sd["v_n"]]))[at]
    low, high = chi2.ppf([0.0005, 0.9995], runs) / runs
    mean = (scaled**2).mean(axis=0)
    assert (low < mean).all() and (mean < high).all(), mean


def resting(seed):
    """A unit at rest, read with its own noise: the inputs carry what drives the error."""
    rng = np.random.default_rng(seed)
    model = inertial(InertialNoise(0.01, 0.05, 1e-3, 5e-3), AidingNoise(position_sd=0.1, heading_sd=0.1))
    t, dt = 0.02 * np.arange(150), 0.02
    density = np.array([n.density for n in model.noises])
    start_sd = np.repeat([0.05, 0.2, 0.2, 0.01, 0.05], 3)
    e = start_sd * rng.normal(size=15)
    walked = np.cumsum(np.repeat(density[2:], 3) * np.sqrt(dt) * rng.normal(size=(150, 6)), axis=0)
    biases = e[9:] + walked - walked[0]  # the true ones
    ideal = np.r_[0, 0, 0, 0, 0, -9.80665]
    u = ideal + biases + np.repeat(density[:2], 3) / np.sqrt(dt) * rng.normal(size=(150, 6))
    slow = slice(0, None, 5)
    streams = {
        "gyro": Stream("gyro", t, u[:, :3], "rad/s", "b"),
        "accel": Stream("accel", t, u[:, 3:], "m/s^2", "b"),
        "position": Stream("position", t[slow], np.c_[0.1 * rng.normal(size=(30, 3)), np.zeros((30, 3))], "m", "n"),
        "heading": Stream("heading", t[slow], 0.1 * rng.normal(size=(30, 1)), "rad", "n"),
    }
    x = functions_of(model).inject(np.r_[1.0, np.zeros(9), biases[0]], -e * np.r_[np.ones(9), np.zeros(6)])
    x[10:] = 0.0
    return EKF(model), Log(streams, "sim"), Start(x, np.diag(start_sd**2)), biases


def test_errors_are_as_large_as_it_says_with_an_inertial_unit():
    runs, at = 100, [0, 70, 145]
    scaled = np.zeros((runs, 3, 15))
    for seed in range(runs):
        estimator, log, start, biases = resting(seed)
        out = smooth(estimator, log, start)
        turn = 2 * out.state["q_nb"][:, 1:] / out.state["q_nb"][:, :1]
        bias = np.hstack([out.state["gyro_bias"], out.state["accel_bias"]]) - biases
        error = np.hstack([turn, out.state["v_n"], out.state["p_n"], bias])
        scaled[seed] = (error / np.hstack(list(out.sd.values())))[at]
    low, high = chi2.ppf([0.0002, 0.9998], runs) / runs
    mean = (scaled**2).mean(axis=0)
    assert (low < mean).all() and (mean < high).all(), mean


def test_it_is_nearer_than_the_filter_and_ends_with_it():
    log, path, start = flight(3)
    forward, back = run(EKF(TAG), log, start), smooth(EKF(TAG), log, start)
    assert back.estimator == "ekf-rts" and back.model == forward.model
    np.testing.assert_array_equal(back.t, forward.t)
    assert np.square(errors(back, path)).mean() < 0.6 * np.square(errors(forward, path)).mean()
    for name in ("p_n", "v_n"):
        np.testing.assert_array_equal(back.state[name][-1], forward.state[name][-1])
        assert (back.sd[name] <= forward.sd[name] * (1 + 1e-12)).all()
        assert back.sd[name][0].max() < 0.7 * forward.sd[name][0].max()
    for name, one in forward.innovations.items():
        np.testing.assert_array_equal(back.innovations[name].z, one.z)
        np.testing.assert_array_equal(back.innovations[name].weight, one.weight)
    assert back.events == forward.events and back.settings == forward.settings


def turning(seed=0, count=200):
    """A gyro at 50 Hz with missing samples, first and last too; readings between its samples."""
    rng = np.random.default_rng(seed)
    model = attitude(AttitudeNoise(2e-3, 1e-4, 0.05, 0.02, 0.0), field=1.0, dip_deg=60.0)
    t = np.linspace(0, 4, count + 1)
    u = np.tile([0.3, -0.2, 0.5], (count + 1, 1))
    still = model.with_numbers(density={n.name: 0.0 for n in model.noises})
    x = walk(still, np.r_[1.0, np.zeros(6)], np.diff(t), rng, u)
    gyro = u + 2e-3 / np.sqrt(0.02) * rng.normal(size=u.shape)
    gyro[[0, 50, 51, 52, -1], 1] = np.nan
    own = t[:-1:3] + 0.007
    q = frames.quat_multiply(x[:-1:3, :4], frames.quat_from_rotvec(0.007 * u[:-1:3]))
    f_b = frames.rotate(frames.quat_conjugate(q), [0.0, 0.0, -9.80665]) + 0.05 * rng.normal(size=(len(own), 3))
    m_b = frames.rotate(frames.quat_conjugate(q), [0.5, 0.0, np.sqrt(0.75)]) + 0.02 * rng.normal(size=(len(own), 3))
    streams = {
        "gyro": Stream("gyro", t, gyro, "rad/s", "b"),
        "accel": Stream("accel", own, f_b, "m/s^2", "b"),
        "mag": Stream("mag", own, m_b, "1", "b"),
    }
    return model, Log(streams, "sim"), x


@pytest.mark.parametrize("backend", ["c", "numpy"])
def test_where_an_input_is_missing_the_state_is_of_that_time(backend):
    model, log, x = turning()
    start = Start.at(model)
    forward, back = (f(EKF(model), log, start, backend=backend) for f in (run, smooth))
    off = [frames.rotation_error(one.state["q_nb"], x[:, :4]) for one in (forward, back)]
    size = [np.linalg.norm(one, axis=-1) for one in off]
    assert size[0][52] > 0.02  # three steps of 0.012 rad late
    assert size[1][1:-1].max() < 0.008
    np.testing.assert_array_equal(back.state["q_nb"][0], back.state["q_nb"][1])
    np.testing.assert_array_equal(back.state["q_nb"][-1], back.state["q_nb"][-2])
    assert any("5 of 201 input samples missing" in e for e in back.events)
    assert back.settings["backend"] == backend


def test_c_is_numpy_over_a_log():
    for model, log, start in ((TAG, *flight(1)[::2]), (turning()[0], turning()[1], Start.at(turning()[0]))):
        one, other = (smooth(EKF(model), log, start, backend=b) for b in ("c", "numpy"))
        for name in one.state:
            np.testing.assert_allclose(one.state[name], other.state[name], atol=1e-10)
            np.testing.assert_allclose(one.sd[name], other.sd[name], atol=1e-10)


def test_a_long_step_is_gone_back_in_the_parts_it_was_gone_in():
    """A pause of the gyro in equal parts is a gyro that repeats what it says after the pause."""
    model, log, _ = turning()
    quiet = {n: s.t[(s.t < 1.98) | (s.t > 2.41)] for n, s in log.streams.items()}  # nothing read in the pause either
    aiding = {n: replace(s, t=quiet[n], values=s.values[np.isin(s.t, quiet[n])]) for n, s in log.streams.items()}
    gyro = log.streams["gyro"]
    pause = np.isin(np.arange(201), np.arange(100, 120))
    repeated = np.where(pause[:, None], gyro.values[120], gyro.values)
    full = Log({**aiding, "gyro": replace(gyro, values=repeated)}, "sim")
    paused = Log({**aiding, "gyro": replace(gyro, t=gyro.t[~pause], values=gyro.values[~pause])}, "sim")
    start = Start.at(model)
    expected = smooth(EKF(model), full, start)
    parts, whole = (smooth(EKF(model, longest_step=s), paused, start) for s in (0.0201, float("inf")))
    far, near = (np.abs(one.state["q_nb"] - expected.state["q_nb"][~pause]).max() for one in (whole, parts))
    assert near < 1e-10 < 1e-6 < far
    np.testing.assert_allclose(parts.sd["q_nb"], expected.sd["q_nb"][~pause], rtol=1e-6)


def test_a_constant_gain_has_nothing_to_go_back_over():
    model, log, _ = turning()
    with pytest.raises(InputError, match=r"h2(.|\n)*EKF or UKF"):
        smooth(H2(model, 50.0), log, Start.at(model))


def test_a_log_without_a_whole_input_and_a_broken_filter_are_named():
    model, log, _ = turning()
    gyro = replace(log.streams["gyro"], values=np.full((201, 3), np.nan))
    for fit in (lambda *a: smooth(EKF(model), *a), lambda *a: batch(model, *a)):
        with pytest.raises(InputError, match="no whole input sample, sim"):
            fit(Log({**log.streams, "gyro": gyro}, "sim"), Start.at(model))
    broken = Start(model.nominal_state(), np.diag([1.0, 1, 1, 1, 1, -1]))
    with pytest.raises(EstimatorError, match="covariance is not finite"):
        smooth(UKF(model), log, broken)


def test_batch_is_the_smoother_where_all_is_linear():
    log, _, start = flight(4, position_only=True)
    one, other = batch(TAG, log, start, {}), smooth(EKF(TAG), log, start)
    assert one.estimator == "batch" and one.settings["passes"] == 1
    np.testing.assert_array_equal(one.t, other.t)
    for name in ("p_n", "v_n"):
        np.testing.assert_allclose(one.state[name], other.state[name], atol=1e-9)
        np.testing.assert_allclose(one.sd[name], other.sd[name], atol=1e-9)


def test_batch_reports_residuals_and_when_it_has_not_settled():
    log, path, start = flight(5)
    ranges = log.streams["range"]
    values = ranges.values.copy()
    values[10::20, 0] += 2.0
    values[5, 0] = np.nan
    late = np.r_[ranges.t, ranges.t[-1] + 1]
    damaged = Log({**log.streams, "range": replace(ranges, t=late, values=np.r_[values, np.full((1, 4), np.nan)])}, "s")
    out, told = batch(TAG, damaged, start), []
    seen = out.innovations["range"]
    np.testing.assert_array_equal(np.isnan(seen.weight), np.isin(np.arange(121), [5, 120]))
    assert (seen.weight[10::20] < 0.02).all() and np.nanmedian(seen.weight) == 1.0
    apart = values[:, 0] - np.linalg.norm(out.state["p_n"][:120] - values[:, 1:], axis=1)
    np.testing.assert_allclose(seen.z[:120, 0], apart, atol=1e-9)
    np.testing.assert_allclose(seen.nis, seen.z[:, 0] ** 2 / 0.01)
    assert not any("settled" in e for e in out.events)
    plain = batch(TAG, damaged, start, {})
    assert np.square(errors(cut(out), path)).mean() < 0.3 * np.square(errors(cut(plain), path)).mean()
    short = batch(TAG, damaged, start, {"range": StudentT(3.0)}, Effort(2, 1e-9, lambda *one: told.append(one)))
    assert [number for number, _ in told] == [1, 2] and "not settled after 2 passes" in short.events[-1]


def cut(out):
    return replace(out, state={name: values[:120] for name, values in out.state.items()})
