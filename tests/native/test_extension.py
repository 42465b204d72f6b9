"""The extension itself: whatever Python hands it, it answers or raises, and never reads or writes past an array.

``make native`` runs these tests again on an extension built with the address and undefined-behaviour sanitizers.
"""

import gc
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.engine import _kernel

KINDS = range(4)
NAMES = ("attitude", "attitude_euler")
SPREAD = (1.0, 2.0, 0.0)
ANYTHING = st.one_of(
    st.none(),
    st.integers(-3, 3),
    st.floats(allow_nan=True, allow_infinity=True),
    st.text(max_size=2),
    st.binary(max_size=32),
    st.lists(st.floats(), max_size=8),
    st.lists(st.one_of(st.none(), st.text(max_size=1)), max_size=4),
    st.builds(np.zeros, st.integers(0, 9)),
    st.builds(lambda n: np.zeros(n, np.float32), st.integers(0, 9)),
    st.builds(lambda n: np.zeros(n, ">f8"), st.integers(0, 9)),
    st.builds(lambda n: np.zeros((n, 2))[:, 0], st.integers(0, 9)),
    st.builds(lambda n: np.zeros((n, n)), st.integers(0, 4)),
)
REFUSALS = (TypeError, ValueError, IndexError, KeyError, OverflowError)


def new_filter(name: str, kind: int, real: str = "double", sets: int = 1):
    model = _kernel.Model(name, real)
    nx, ne, _, noises, parameters, rows = model.sizes
    x = np.zeros(nx)
    x[0] = float(nx != ne)
    P = np.array([float(i == j) for i in range(ne) for j in range(i, ne)])
    gains = np.zeros(sets * (2 ** len(rows) - 1) * ne * sum(rows))
    variances = np.ones(len(rows))
    arguments = (
        x,
        P,
        np.ones(parameters),
        np.ones(noises),
        variances,
        (0,) * len(rows),
        np.full(len(rows), np.inf),
        SPREAD,
        1.0,
    )
    return model, _kernel.Filter(model, kind, *arguments, np.arange(float(sets)), gains, 5.0, np.eye(ne))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", KINDS)
@given(st.lists(ANYTHING, max_size=5))
def test_update_answers_or_refuses(name, kind, arguments):
    _, one = new_filter(name, kind)
    try:
        one.update(*arguments)
    except REFUSALS:
        return
    assert len(arguments) == 4


@pytest.mark.parametrize("name", NAMES)
@given(
    st.integers(-2, 11), st.integers(-2, 9), st.lists(ANYTHING, max_size=5), st.floats(), st.lists(ANYTHING, max_size=3)
)
def test_call_answers_or_refuses(name, what, sensor, inputs, dt, outputs):
    model = _kernel.Model(name)
    try:
        model.call(what, sensor, tuple(inputs), dt, tuple(outputs))
    except REFUSALS:
        return
    assert 0 <= what < 9


@pytest.mark.parametrize("kind", KINDS)
@given(st.lists(ANYTHING, min_size=6, max_size=6), st.lists(ANYTHING, max_size=3))
def test_run_store_and_load_answer_or_refuse(kind, arguments, sensors):
    _, one = new_filter("attitude", kind)
    t, u, x, sd, P, first = arguments
    for call in (
        lambda: one.run(t, u, tuple(sensors), x, sd, P),
        lambda: one.run(np.zeros(0), np.zeros(0), (None, (t, u, x, sd, P, first)), None, None, None),
        lambda: one.store(x, P),
        lambda: one.load(x, P, 0.0, 0.0),
    ):
        try:
            call()
        except REFUSALS:
            continue


@given(st.lists(ANYTHING, min_size=9, max_size=9), st.integers(-2, 4))
def test_construction_answers_or_refuses(arguments, kind):
    model = _kernel.Model("attitude")
    try:
        _kernel.Filter(
            model,
            kind,
            *arguments[:5],
            tuple(arguments[8:]),
            arguments[5],
            SPREAD,
            1.0,
            *arguments[6:8],
            1.0,
            arguments[8],
        )
    except REFUSALS:
        return
    raise AssertionError("nothing here fits the model")


@pytest.mark.parametrize("change", range(8))
@pytest.mark.parametrize("by", [-1, 1])
def test_each_array_must_have_its_size(change, by):
    model = _kernel.Model("attitude")
    nx, ne, _, noises, parameters, rows = model.sizes
    sizes = [nx, ne * (ne + 1) // 2, parameters, noises, len(rows), len(rows), 1, 3 * ne * sum(rows)]
    sizes[change] += by
    arrays = [np.zeros(n) for n in sizes]
    with pytest.raises(ValueError):
        _kernel.Filter(
            model,
            1 if change != 1 else 0,
            *arrays[:5],
            (0,) * len(rows),
            arrays[5],
            SPREAD,
            1.0,
            *arrays[6:],
            0.0,
            None,
        )


@pytest.mark.parametrize("rules", [(), (0,), (0, "gate"), (0, 2**70)])
def test_each_sensor_has_a_rule(rules):
    model = _kernel.Model("attitude")
    arrays = [np.zeros(n) for n in (7, 21, 5, 3, 2)]
    with pytest.raises(REFUSALS):
        _kernel.Filter(model, 0, *arrays, rules, np.zeros(2), SPREAD, 1.0, None, None, 0.0, None)


def test_a_constant_gain_needs_a_gain():
    with pytest.raises(ValueError, match="gain"):
        new_filter("attitude", 1, sets=0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("real", ["double", "float"])
def test_missing_readings_leave_the_state_finite(name, kind, real):
    model, one = new_filter(name, kind, real)
    x, P = np.empty(model.sizes[0]), np.empty(21)
    missing = np.array([np.nan, 0.0, -9.8])
    for _ in range(50):
        one.update(np.array([0.01, -0.02, 0.03]), missing, None, 0.01)
        one.update(None, np.array([0.1, 0.1, -9.8]), np.array([0.2, 0.0, 0.4]), 0.0)
    one.store(x, P)
    assert np.isfinite(x).all() and np.isfinite(P).all()


@pytest.mark.parametrize("kind", ["f4", ">f8", "i8", "u1"])
def test_an_array_must_hold_doubles(kind):
    model, one = new_filter("attitude", 0)
    with pytest.raises(TypeError, match="expected 'd'"):
        one.load(np.zeros(model.sizes[0], kind), None, 0.0, 0.0)
    with pytest.raises(TypeError, match="contiguous"):
        one.load(np.zeros(2 * model.sizes[0])[::2], None, 0.0, 0.0)


def test_an_output_must_be_writable():
    model, one = new_filter("attitude", 0)
    state = np.zeros(model.sizes[0])
    state.flags.writeable = False
    with pytest.raises(TypeError, match="state"):
        one.store(state, None)


@pytest.mark.parametrize("position", range(3))
@pytest.mark.parametrize("size", [0, 1, 2, 4, 1000])
@pytest.mark.parametrize("make", [np.zeros, lambda n: [0.0] * n], ids=["array", "list"])
def test_each_streamed_reading_must_have_its_size(position, size, make):
    _, one = new_filter("attitude", 0)
    arguments = [np.zeros(3), np.zeros(3), np.zeros(3), 0.01]
    arguments[position] = make(size)
    with pytest.raises(ValueError, match="expected 3 numbers"):
        one.update(*arguments)


@pytest.mark.parametrize("count", [0, 1, 3, 5, 12])
def test_update_takes_one_argument_a_sensor(count):
    _, one = new_filter("attitude", 0)
    with pytest.raises(TypeError, match="update takes"):
        one.update(*[None] * (count - 1), *[0.0] * (count > 0))


def test_strided_and_plain_readings_are_the_same():
    model, one = new_filter("attitude", 0)
    _, other = new_filter("attitude", 0)
    table = np.arange(12.0).reshape(3, 4) / 10
    one.update(table[:, 1], table[:, 2], table[::-1, 3], 0.01)
    other.update(list(table[:, 1]), tuple(table[:, 2]), table[::-1, 3].copy(), 0.01)
    states = np.empty((2, model.sizes[0]))
    one.store(states[0], None)
    other.store(states[1], None)
    np.testing.assert_array_equal(*states)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_an_input_must_be_finite(bad):
    _, one = new_filter("attitude", 0)
    with pytest.raises(ValueError, match="finite"):
        one.update(np.array([0.0, bad, 0.0]), None, None, 0.01)


@pytest.mark.parametrize("dt", [-1e-9, -1.0, np.nan, np.inf, 1e300])
def test_an_interval_must_be_finite_and_not_negative(dt):
    _, one = new_filter("attitude", 0)
    with pytest.raises(ValueError, match="dt"):
        one.update(np.zeros(3), None, None, dt)


def test_a_filter_outlives_its_model_and_gives_its_memory_back():
    _, one = new_filter("attitude", 1)
    gc.collect()
    one.update(np.zeros(3), np.ones(3), np.ones(3), 0.01)
    del one
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    for _ in range(100):
        new_filter("attitude", 0)[1].update(np.zeros(3), [0.0, 0.0, -9.8], None, 0.01)
    gc.collect()
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert after - before < 50e3  # one filter takes about 10 kB
