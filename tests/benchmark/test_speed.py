import gc
import json
import sys

import numpy as np
import pytest

from robustnav.benchmark import speed, timing
from robustnav.benchmark.flight import DT, euler_model, flight, start
from robustnav.benchmark.peer_filterpy import EulerEkf, EulerEkfJoint, EulerEquations, EulerUkf
from robustnav.benchmark.timing import Contender, Entry, Work, time_rounds
from robustnav.benchmark.works import WORKS
from robustnav.engine.backends import functions_of
from robustnav.errors import EstimatorError, InputError
from robustnav.evaluate.tables import plain, text_table
from robustnav.run import EKF, UKF, stream

TINY = {"seconds": 0.001, "repeats": 2, "samples": 120}


def made_up(name, work=lambda: None, **about):
    return {name: Entry(lambda n: Contender(work, n, lambda _: 0.0), **about)}


def test_a_tiny_run_has_every_row_with_its_ratios():
    steps = []
    results = speed.benchmark_speed(**TINY, progress=lambda: steps.append(1))
    assert len(steps) == speed.steps_of(2) == 2 * len(WORKS)
    by_work = {work.name: [row for row in results["rows"] if row["work"] == work.name] for work in WORKS}
    for work in WORKS:
        rows = by_work[work.name]
        assert {row["name"] for row in rows} == set(work.entries) - set(results["missing"])
        baselines = {row["name"] for row in rows if row["baseline"]}
        for row in rows:
            assert row["ns"] >= row["least_ns"] > 0 and row["steps"] >= 2
            assert row["ratio"].keys() == baselines
            assert row["ratio"].get(row["name"], 1.0) == 1.0
    assert {"h2", "mekf", "mekf+covariance", "ekf-euler"} <= {row["name"] for row in by_work["attitude-batch"]}
    assert results["machine"]["processor"] and results["machine"]["python"]
    json.dumps(plain(results), allow_nan=False)
    titles = [title for title, _ in speed.tables(results)]
    assert [title.split(":")[0] for title in titles] == [work.name for work in WORKS]
    assert all(text_table(rows) for _, rows in speed.tables(results))


def test_missing_peers_are_listed_with_what_they_need(monkeypatch):
    for module in ("vqf", "imufusion", "filterpy", "symengine"):
        monkeypatch.setitem(sys.modules, module, None)
    results = speed.benchmark_speed(**TINY)
    assert results["missing"]["offline-vqf"] == "vqf" and results["missing"]["filterpy-ekf-euler"] == "filterpy"
    assert results["missing"]["numpy-ukf"] == "symengine"
    assert {row["name"] for row in results["rows"] if row["work"] == "attitude-call"} == {"h2", "mekf"}
    # the snapshot rows compare with our own NumPy form and with SciPy, which are always there
    assert not any(row["ratio"] for row in results["rows"] if row["work"] != "snapshot")
    assert "vqf" not in results["machine"]


def test_a_ratio_is_taken_within_rounds_so_a_slow_phase_cancels(monkeypatch):
    ours, peer = np.array([10.0, 30.0, 10.0, 30.0, 10.0]), np.array([20.0, 60.0, 20.0, 60.0, 20.0])
    monkeypatch.setattr(speed, "time_rounds", lambda *_: {"ours": ours, "peer": peer})
    work = Work("made-up", "a step", "nothing", made_up("ours") | made_up("peer", baseline=True))
    results = speed.benchmark_speed(works=[work])
    row = results["rows"][0]
    assert (row["ns"], row["least_ns"], row["ratio"]) == (10.0, 10.0, {"peer": 0.5})
    ((title, shown),) = speed.tables(results)
    assert title == "made-up: a step"
    assert shown[0] == {"name": "ours", "ns": 10.0, "least_ns": 10.0, "x of peer": "0.5"}


def test_contenders_take_turns_with_collection_off_and_every_other_round_reversed():
    order, collecting = [], []

    def work(name):
        order.append(name)
        collecting.append(gc.isenabled())
        return sum(range(20000))

    contenders = {name: Contender(lambda name=name: work(name), 1, lambda _: 0.0) for name in ("a", "b")}
    was_on = gc.isenabled()
    times = time_rounds(contenders, 1e-9, 2, lambda: None)
    assert order[-4:] == ["a", "b", "b", "a"]
    assert not any(collecting[-4:]) and gc.isenabled() == was_on
    assert all(len(t) == 2 and (t >= 0).all() for t in times.values())


def test_time_is_divided_by_steps_and_passes(monkeypatch):
    clock, passes = [0], []

    def work():
        passes.append(1)
        clock[0] += 3_000_000

    monkeypatch.setattr(timing, "process_time_ns", lambda: clock[0])
    times = time_rounds({"made-up": Contender(work, 1500, lambda _: 0.0)}, 0.09, 3, lambda: None)
    assert times["made-up"].tolist() == [2000.0] * 3
    assert len(passes) >= 3 * 5  # a round of 30 ms holds several passes of 3 ms


@pytest.mark.parametrize("fault", [2.0, float("nan")])
def test_a_contender_that_does_not_work_is_not_timed(fault):
    with pytest.raises(EstimatorError, match="'broken' does not estimate"):
        time_rounds({"broken": Contender(lambda: None, 1, lambda _: fault)}, 0.001, 1, lambda: None)


@pytest.mark.parametrize("bad", [{"seconds": 0.0}, {"seconds": float("nan")}, {"repeats": 0}, {"samples": 1}])
def test_numbers_that_measure_nothing_are_refused(bad):
    with pytest.raises(InputError, match="speed benchmark"):
        speed.benchmark_speed(**(TINY | bad))


def test_the_hand_written_equations_are_those_of_the_compiled_model():
    """Both sides of the filterpy rows then do the same work, and what differs is the library."""
    model = euler_model()
    ours, theirs = functions_of(model), EulerEquations(model, DT)
    random = np.random.default_rng(4)
    for _ in range(20):
        x = random.uniform(-1.2, 1.2, 6) * [1, 1, 2.5, 0.02, 0.02, 0.02]
        u = random.normal(0, 2, 3)
        np.testing.assert_allclose(theirs.propagate(x, u), ours.propagate(x, u, DT), rtol=1e-13, atol=1e-15)
        F, Q = ours.transition(x, u, DT)
        np.testing.assert_allclose(theirs.transition(x, u)[0], F, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(theirs.transition(x, u)[1], Q, rtol=1e-12, atol=1e-24)
        for sensor, part in ((0, slice(0, 3)), (1, slice(3, 6))):
            np.testing.assert_allclose(theirs.measure(x)[part], ours.measure(sensor, x), rtol=1e-12, atol=1e-18)
            np.testing.assert_allclose(theirs.jacobian(x)[part], ours.jacobian(sensor, x), rtol=1e-12, atol=1e-18)
        np.testing.assert_allclose(np.r_[theirs.accel(x), theirs.mag(x)], theirs.measure(x), rtol=1e-14, atol=1e-18)
        single = np.vstack([theirs.accel_jacobian(x), theirs.mag_jacobian(x)])
        np.testing.assert_allclose(single, theirs.jacobian(x), rtol=1e-13, atol=1e-18)


@pytest.mark.parametrize(
    ("peer", "ours", "apart"), [(EulerEkf, EKF, 1e-10), (EulerEkfJoint, EKF, 1e-5), (EulerUkf, UKF, 1e-5)]
)
def test_filterpy_estimates_what_our_filter_does(peer, ours, apart):
    """The same algorithm gives the same numbers; the other two take all six rows at one point, where we move it."""
    kalman = pytest.importorskip("filterpy.kalman", reason="needs the peer library filterpy")
    model = euler_model()
    axes, q_nb = flight(300)
    begin = start(model, q_nb[0])
    theirs = peer(kalman, EulerEquations(model, DT), begin.x, begin.P)
    mine = stream(ours(model), begin)
    for gyro, accel, mag in zip(axes.gyro, axes.accel, axes.mag, strict=True):
        theirs.step(gyro, np.r_[accel, mag])
        mine.update(gyro, accel, mag, DT)
    np.testing.assert_allclose(theirs.filter.x, mine.state, atol=apart)
    np.testing.assert_allclose(np.diag(theirs.filter.P), np.diag(mine.covariance), rtol=10 * apart)
