"""Where streams meet a filter: what is fused, what is said of it, what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.engine import SensorData
from robustnav.errors import EstimatorError, InputError
from robustnav.filter.steps import unpack
from robustnav.filter.weighting import Gate
from robustnav.frames import matrix_from_quat, quat_from_euler
from robustnav.model import Equations, Model, Noise, Sensor, Vector
from robustnav.models import AttitudeNoise, attitude, attitude_euler
from robustnav.records import Log, Stream
from robustnav.run import EKF, H2, UKF, Start, covariance_of, run, stream
from robustnav.units import DEG, DPS, STANDARD_GRAVITY

NOISE = AttitudeNoise(1e-3, 1e-5, 0.05, 0.01)
MODEL = attitude(NOISE, field=1.0, dip_deg=60.0)
EULER = attitude_euler(NOISE, field=1.0, dip_deg=60.0)
FIELD_N = np.array([0.5, 0.0, np.sqrt(0.75)])
Q_NB = quat_from_euler(np.array([0.2, -0.3, 2.0]))


def standing(seconds=4.0, rate_hz=50.0):
    """Readings of a unit that stands still, turned from north and level."""
    rng, t = np.random.default_rng(0), np.arange(0, seconds, 1 / rate_hz)
    C_bn = matrix_from_quat(Q_NB).T
    noise = rng.normal(size=(3, len(t), 3))
    values = {
        "gyro": 0.01 + 1e-3 * np.sqrt(rate_hz) * noise[0],
        "accel": C_bn @ [0, 0, -STANDARD_GRAVITY] + 0.05 * noise[1],
        "mag": C_bn @ FIELD_N + 0.01 * noise[2],
    }
    return Log({k: Stream(k, t, v, "SI") for k, v in values.items()}, "a table")


LOG = standing()
START = Start.at(MODEL, q_nb=Q_NB)


def with_stream(name, t=None, values=None):
    one = LOG.streams[name]
    new = Stream(name, one.t if t is None else t, one.values if values is None else values, "SI")
    return replace(LOG, streams={**LOG.streams, name: new})


def without(*names):
    return replace(LOG, streams={k: v for k, v in LOG.streams.items() if k not in names})


@pytest.mark.parametrize("estimator", [EKF(MODEL), UKF(MODEL), H2(MODEL, 50.0)], ids=lambda e: e.name)
def test_a_run_says_everything(estimator):
    out = run(estimator, LOG, START)
    assert (out.estimator, out.model) == (estimator.name, "attitude")
    assert out.state["q_nb"].shape == (200, 4) and out.state["gyro_bias"].shape == (200, 3)
    assert out.sd["q_nb"].shape == out.sd["gyro_bias"].shape == (200, 3)
    rows = 3 if estimator.name == "ukf" else 2  # the unscented filter keeps a reading in body axes, whole
    assert {k: v.z.shape for k, v in out.innovations.items()} == {"accel": (200, rows), "mag": (200, 3)}
    assert out.events == () and out.settings["backend"] == "c"
    assert out.settings["accel sd [m/s^2]"] == 0.05 and out.settings["gravity"] == STANDARD_GRAVITY
    assert out.settings["attitude error in"] == "navigation axes"
    np.testing.assert_allclose(out.state["gyro_bias"][-1], 0.01, atol=3 * out.sd["gyro_bias"][-1].max())


def test_the_designed_covariance_of_a_constant_gain_is_what_the_ekf_finds():
    """Standing still the two see the same: steady deviations agree, body vectors in body axes."""
    fast = MODEL.with_numbers({"gyro_bias_noise": 1e-2})
    log = standing(20.0)
    h2, ekf = (run(e, log, START) for e in (H2(fast, 50.0), EKF(fast)))
    for block in ("q_nb", "gyro_bias"):
        np.testing.assert_allclose(h2.sd[block][-1], ekf.sd[block][-1], rtol=0.02)
    gyro = log.streams["gyro"]
    sensors = [SensorData(gyro.t, log.streams[name].values) for name in ("accel", "mag")]
    P = covariance_of(
        H2(fast, 50.0), gyro.t, gyro.values, stream(H2(fast, 50.0), START).run(gyro.t, gyro.values, sensors)
    )
    np.testing.assert_allclose(np.sqrt(P[-1, 3:, 3:].diagonal()), h2.sd["gyro_bias"][-1], rtol=1e-9)
    north_b = matrix_from_quat(h2.state["q_nb"][-1]).T @ [1, 0, 0]
    designed = H2(fast, 50.0).table.covariance[-1][3, 3]  # in navigation axes
    assert north_b @ P[-1, 3:, 3:] @ north_b == pytest.approx(designed, rel=1e-9)


def test_sd_are_roots_of_the_covariance():
    estimator = EKF(MODEL)
    out = run(estimator, LOG, START)
    t, u = LOG.streams["gyro"].t, LOG.streams["gyro"].values
    sensors = [None, None]
    whole = stream(estimator, START).run(t, u, sensors)
    np.testing.assert_array_equal(covariance_of(estimator, t, u, whole), unpack(whole.P))
    with pytest.raises(InputError, match="covariance=True"):
        covariance_of(estimator, t, u, stream(estimator, START).run(t, u, sensors, covariance=False))
    np.testing.assert_allclose(out.sd["q_nb"][0] ** 2, START.P.diagonal()[:3], rtol=1.0)


def test_events_name_what_was_missing():
    gyro, accel = (Stream(n, LOG.streams[n].t.copy(), LOG.streams[n].values.copy(), "SI") for n in ("gyro", "accel"))
    gyro.t[100:], gyro.values[[3, 4], 1], accel.values[7] = gyro.t[100:] + 2.5, np.nan, np.nan
    assert run(EKF(MODEL), Log({"gyro": gyro, "accel": accel}, "a table"), START).events == (
        "2 of 200 input samples missing; each next one covered the time",
        "input pause of 2.520 s at 1.980 s",
        "1 of 200 accel readings missing: not fused",
        "no mag stream: not fused",
    )


def test_a_broken_covariance_is_an_event():
    P = START.P.copy()
    P[0, 0] = -1.0
    out = run(EKF(MODEL), LOG, Start(START.x, P))
    assert any("accel readings refused, the first at 0.000 s: broken covariance" in e for e in out.events)
    gated = run(EKF(MODEL, outliers={"mag": Gate(1e-6)}), LOG, START)
    assert not gated.innovations["mag"].used.any() and gated.events == ()  # a gate's refusal is data


@pytest.mark.parametrize(
    ("log", "words"),
    [
        (without("gyro"), ["no stream 'gyro'", "a table"]),
        (without("accel", "mag"), ["no sensor to fuse", "accel, mag"]),
        (with_stream("gyro", np.zeros(0), np.zeros((0, 3))), ["no input samples", "gyro"]),
        (with_stream("gyro", values=LOG.streams["gyro"].values[:, :2]), ["'gyro'", "2 columns", "3"]),
        (with_stream("mag", values=LOG.streams["mag"].values[:, :1]), ["'mag'", "1 columns", "3"]),
    ],
)
def test_streams_that_do_not_fit_are_named(log, words):
    with pytest.raises(InputError) as caught:
        run(EKF(MODEL), log, START)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def two_inputs():
    return Model(
        name="two_inputs",
        state=(Vector("x", "1", 1),),
        inputs=(Vector("a", "1", 1), Vector("b", "1", 1)),
        noises=(Noise("w", "1", 1.0, 1),),
        sensors=(Sensor("y", "1", 1.0, 1),),
        equations=lambda s: Equations({"x": s.a + s.b + s.w}, {"y": s.x}),
        start_sd={"x": 1.0},
    )


def test_inputs_must_share_their_times():
    t, model = np.arange(5.0), two_inputs()
    one = {name: Stream(name, t, np.ones((5, 1)), "1") for name in ("a", "b", "y")}
    out = run(EKF(model), Log(one, "s"), Start.at(model), backend="numpy")
    assert out.settings["backend"] == "numpy"
    with pytest.raises(InputError, match="'a' and 'b'"):
        run(EKF(model), Log({**one, "b": Stream("b", t + 0.1, np.ones((5, 1)), "1")}, "s"), Start.at(model))


def test_a_start_is_given_by_block():
    start = Start.at(MODEL, {"gyro_bias": 1 * DPS}, q_nb=Q_NB, gyro_bias=0.1)
    np.testing.assert_array_equal(start.x, [*Q_NB, 0.1, 0.1, 0.1])
    np.testing.assert_allclose(np.sqrt(start.P.diagonal()) / DEG, [5, 5, 10, 1, 1, 1])
    with pytest.raises(InputError, match=r"block 'q_bn'(.|\n)*q_nb, gyro_bias"):
        Start.at(MODEL, q_bn=Q_NB)


def test_float_stays_near_double():
    one, other = (run(EKF(MODEL), LOG, START, backend=b) for b in ("c", "float"))
    assert other.settings["backend"] == "float"
    np.testing.assert_allclose(one.state["q_nb"], other.state["q_nb"], atol=2e-6)


def test_names_tell_the_filter_and_the_form():
    assert [e.name for e in (EKF(MODEL), EKF(EULER), UKF(MODEL), EKF(two_inputs()))] == [
        "mekf",
        "ekf-euler",
        "ukf",
        "ekf",
    ]
    assert [H2(m, 50.0, start_sd="steady").name for m in (MODEL, EULER)] == ["h2", "h2-euler"]


@pytest.mark.parametrize("kind", [EKF, UKF])
def test_gates_are_by_sensor_and_above_zero(kind):
    setup = kind(MODEL, outliers={"mag": Gate(11.3)}).setup(START.x, START.P)
    assert setup.rules == (Gate(), Gate(11.3))
    with pytest.raises(InputError, match="magnet"):
        kind(MODEL, outliers={"magnet": Gate(9.0)}).setup(START.x, START.P)
    with pytest.raises(InputError, match="gate"):
        kind(MODEL, outliers={"mag": Gate(0.0)}).setup(START.x, START.P)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"rate_hz": 0.0}, ["rate_hz", "0.0"]),
        ({"rate_hz": float("nan")}, ["rate_hz", "nan"]),
        ({"start_sd": "stedy"}, ["stedy", "steady"]),
        ({"sensor_rates_hz": {"mag": 0.0}}, ["'mag'", "0.0 Hz"]),
        ({"sensor_rates_hz": {"mag": 500.0}}, ["'mag'", "500.0 Hz", "(0, 50] Hz"]),
        ({"sensor_rates_hz": {"magnet": 5.0}}, ["magnet", "accel, mag"]),
    ],
)
def test_a_design_that_makes_no_sense_is_refused(options, words):
    with pytest.raises(InputError) as caught:
        H2(MODEL, **{"rate_hz": 50.0, **options})
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_no_constant_gain_for_what_no_sensor_sees():
    alone = replace(
        MODEL,
        name="alone",
        shipped=None,
        sensors=MODEL.sensors[:1],
        equations=lambda s: Equations(MODEL.equations(s).rates, directions={"accel": (0, 0, -s.gravity)}),
    )
    with pytest.raises(EstimatorError, match="no steady state"):
        H2(alone, 50.0)
