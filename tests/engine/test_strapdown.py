"""Strapdown integration in C is the NumPy form to rounding, and as unforgiving."""

import threading
from math import radians

import numpy as np
import pytest

from robustnav import strapdown as spec
from robustnav.engine import _kernel
from robustnav.engine import strapdown as compiled
from robustnav.errors import InputError
from robustnav.frames import quat_from_euler, rotation_error
from robustnav.strapdown import ImuSamples, Navigation, Place

PLACE = Place.at(radians(-35), 200.0)


def turning(n, dt, rate):
    """Samples of a unit that turns about all axes at up to ``rate`` [rad/s], with noise."""
    rng = np.random.default_rng(11)
    t = (np.arange(n) + 0.5)[:, None] * dt
    omega = rate * np.sin(np.array([3.0, 5.0, 4.0]) * t + [0, 1, 2]) + rng.normal(0, 0.01, (n, 3))
    force = np.array([0.5, -1.0, -9.8]) * (1 + 0.1 * np.sin(7 * t)) + rng.normal(0, 0.05, (n, 3))
    return ImuSamples(omega * dt, force * dt, dt)


START = Navigation(quat_from_euler([0.1, -0.2, 2.0]), np.array([50.0, -30.0, 2.0]), radians(-35), 2.0, 200.0)
# a gentle unit, and one that turns by more than the 0.2 rad below which the kernel uses a series
CASES = {"gentle": turning(600, 2e-3, 2.0), "wild": turning(600, 2e-2, 20.0)}


@pytest.fixture(params=CASES)
def samples(request):
    return CASES[request.param]


@pytest.mark.parametrize("every", [1, 7 - 1, 600])
def test_increments_are_those_of_numpy(samples, every):
    history = np.full((2, 6), 1e-3)
    for given in (None, history):
        one, other = compiled.preintegrate(samples, every, given), spec.preintegrate(samples, every, given)
        np.testing.assert_allclose(one.rows, other.rows, rtol=1e-12, atol=1e-13)
        assert one.dt == other.dt


@pytest.mark.parametrize("every", [1, 20])
def test_paths_are_those_of_numpy(samples, every):
    one, other = compiled.navigate(START, samples, every), spec.navigate(START, samples, every)
    np.testing.assert_allclose(one.q_nb, other.q_nb, atol=1e-12)
    np.testing.assert_allclose(one.v_n, other.v_n, atol=1e-10)
    np.testing.assert_allclose(one.latitude, other.latitude, atol=1e-15)
    np.testing.assert_allclose(one.longitude, other.longitude, atol=1e-14)
    np.testing.assert_allclose(one.height, other.height, atol=1e-8)


def test_long_intervals_at_speed_are_those_of_numpy():
    """Where half an interval moves the latitude by more than rounding."""
    north = Navigation(START.q_nb, np.array([300.0, 100.0, -5.0]), radians(50), 0.0, 1000.0)
    one, other = (integrate(north, turning(800, 0.05, 0.3), 40) for integrate in (compiled.navigate, spec.navigate))
    np.testing.assert_allclose(one.q_nb, other.q_nb, atol=1e-12)
    np.testing.assert_allclose(one.v_n, other.v_n, atol=1e-9)
    np.testing.assert_allclose(one.longitude, other.longitude, atol=1e-14)


def test_carrying_is_that_of_numpy(samples):
    increments = spec.preintegrate(samples, 20)
    walk = np.linspace(0, 1e-3, len(increments))[:, None] * [1, -2, 3]
    for bias in (None, (np.array([1e-3, -2e-3, 0]), np.array([0.01, 0, 0.02])), (walk, 10 * walk)):
        one = compiled.carry(START.q_nb, START.v_n, increments, PLACE, bias)
        other = spec.carry(START.q_nb, START.v_n, increments, PLACE, bias)
        np.testing.assert_allclose(one[0], other[0], atol=1e-12)
        np.testing.assert_allclose(one[1], other[1], atol=1e-10)


def test_single_precision_is_single_precision():
    samples = CASES["gentle"]
    double, single = (compiled.preintegrate(samples, 100, real=real).rows for real in ("double", "float"))
    off = np.abs(double - single).max()
    assert 1e-9 < off < 5e-6
    increments = compiled.preintegrate(samples, 20)
    q = [compiled.carry(START.q_nb, START.v_n, increments, PLACE, real=real)[0] for real in ("double", "float")]
    assert 1e-9 < np.linalg.norm(rotation_error(*q), axis=1).max() < 1e-5
    path = [compiled.navigate(START, samples, 20, real=real) for real in ("double", "float")]
    assert 1e-9 < np.abs(path[0].v_n - path[1].v_n).max() < 1e-3
    with pytest.raises(ValueError, match="real"):
        compiled.preintegrate(samples, 100, real="half")


def test_the_same_input_errors():
    samples = CASES["gentle"]
    with pytest.raises(InputError, match="samples an interval"):
        compiled.preintegrate(samples, 7)
    with pytest.raises(InputError, match="start of navigation"):
        compiled.navigate(Navigation(START.q_nb, START.v_n, 1.6, 0.0, 0.0), samples)
    fast = Navigation(START.q_nb, np.array([3000.0, 0, 0]), radians(89.89), 0.0, 0.0)
    told = []
    for navigate in (compiled.navigate, spec.navigate):
        with pytest.raises(InputError, match="pole") as refused:
            navigate(fast, samples, 10)
        told.append(refused.value.place)
    assert told[0] == told[1]


@pytest.mark.parametrize(
    "bad", [np.zeros((600, 2)), np.zeros(601), np.zeros(600, np.float32), np.zeros((600, 6))[:, ::2], None, "x"]
)
@pytest.mark.parametrize("at", [1, 2, 3, 6])
def test_the_kernel_checks_every_array(at, bad):
    s = CASES["gentle"]
    args = ["double", s.angle, s.velocity, np.zeros((2, 6)), 20, s.dt, np.empty((30, 25))]
    _kernel.preintegrate(*args)
    args[at] = bad
    with pytest.raises((TypeError, ValueError)):
        _kernel.preintegrate(*args)


@pytest.mark.parametrize(
    ("name", "args", "match"),
    [
        ("preintegrate", ("double", np.zeros(6), np.zeros(6), np.zeros(12), 0, 0.1, np.zeros(25)), "every"),
        ("preintegrate", ("double", np.zeros(9), np.zeros(9), np.zeros(12), 2, 0.1, np.zeros(25)), "angle"),
        ("navigate", ("double", np.zeros(9), np.zeros(6), np.zeros(6), np.zeros(12), 1, 0.1, np.zeros(20)), "start"),
        ("navigate", ("double", np.zeros(10), np.zeros(6), np.zeros(6), np.zeros(12), 1, 0.1, np.zeros(19)), "out"),
        ("carry", ("double", np.zeros(6), np.zeros(25), np.zeros(6), np.zeros(6), 0.1, np.zeros(7)), "start"),
        ("carry", ("double", np.zeros(7), np.zeros(26), np.zeros(6), np.zeros(6), 0.1, np.zeros(7)), "rows"),
        ("carry", ("double", np.zeros(7), np.zeros(25), np.zeros(5), np.zeros(6), 0.1, np.zeros(7)), "place"),
        ("carry", ("double", np.zeros(7), np.zeros(25), np.zeros(6), np.zeros(7), 0.1, np.zeros(7)), "bias"),
        ("carry", ("double", np.zeros(7), np.zeros(25), np.zeros(6), np.zeros(6), 0.1, np.zeros(8)), "out"),
        ("carry", ("half", np.zeros(7), np.zeros(25), np.zeros(6), np.zeros(6), 0.1, np.zeros(7)), "real"),
    ],
)
def test_the_kernel_says_which_array_is_wrong(name, args, match):
    with pytest.raises(ValueError, match=match):
        getattr(_kernel, name)(*args)


def test_nothing_in_gives_nothing_out():
    empty = np.zeros((0, 3))
    _kernel.preintegrate("double", empty, empty, np.zeros(12), 5, 0.1, np.zeros((0, 25)))
    assert _kernel.navigate("double", np.zeros(10), empty, empty, np.zeros(12), 1, 0.1, np.zeros((0, 10))) == 0


def test_numbers_that_are_none_do_not_hang_or_pass_for_a_path():
    hostile = np.full((60, 3), np.nan)
    out = np.zeros((60, 10))
    assert _kernel.navigate("double", START.rows(), hostile, hostile, np.zeros(12), 1, 0.1, out) == 0
    huge = np.full((60, 3), 1e300)
    for real in ("double", "float"):
        assert _kernel.navigate(real, START.rows(), huge, huge, np.zeros(12), 1, 0.1, out) < 60


def test_other_threads_run_meanwhile():
    still = np.zeros((1_000_000, 3))
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(1)
            done.wait(1e-4)

    thread = threading.Thread(target=tick)
    thread.start()
    before = len(ticks)
    _kernel.preintegrate("double", still, still, np.zeros(12), 1000, 1e-3, np.empty((1000, 25)))
    during = len(ticks) - before
    done.set()
    thread.join()
    assert during > 3
