"""The compiled minima of a window are the NumPy ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.engine import _kernel
from robustnav.engine.snapshot_window import robust_minima, robust_search
from robustnav.errors import InputError
from robustnav.snapshot import window as numpy_form
from robustnav.snapshot.window import WindowReadings, robust_cost

KINDS = ("ranges", "differences", "both")
HEIGHTS = ("free", "sd", "plane")


def drawn(seed, kind, height, outliers=0.15):
    """Draw readings of a still tag, some of them far off, and the tag."""
    rng = np.random.default_rng(seed)
    k, m = int(rng.integers(5, 9)), int(rng.integers(20, 65))
    anchors, tag = rng.uniform(-6, 6, (k, 3)), rng.uniform(-4, 4, 3)
    first = rng.integers(k, size=m)
    second = (first + 1 + rng.integers(k - 1, size=m)) % k
    pairs = {"ranges": np.zeros(m, bool), "differences": np.ones(m, bool), "both": rng.random(m) < 0.5}[kind]
    far = np.linalg.norm(anchors - tag, axis=1)
    value = np.where(pairs, far[second] - far[first], far[first]) + 0.1 * rng.normal(size=m)
    off = rng.random(m) < outliers
    value[off] += rng.uniform(0.5, 4.0, off.sum())
    down, down_sd = {"free": (None, 0.0), "sd": (tag[2] + 0.05, 0.1), "plane": (tag[2], 0.0)}[height]
    return WindowReadings(value, anchors[first], anchors[second], pairs, np.full(m, 0.1), down, down_sd), tag


@pytest.mark.parametrize("height", HEIGHTS)
@pytest.mark.parametrize("kind", KINDS)
def test_the_best_minimum_is_that_of_numpy_in_both_number_types(kind, height):
    found = 0
    for seed in range(12):
        readings, tag = drawn(seed, kind, height)
        guess = tag[None] + 1.0
        slow, fast = numpy_form.robust_minima(readings, guess)[0], robust_minima(readings, guess)[0]
        coarse = robust_minima(readings, guess, "float")[0]
        sd = np.sqrt(np.trace(slow.P))
        assert fast.cost == pytest.approx(slow.cost, rel=1e-9)
        assert np.linalg.norm(fast.p - slow.p) < 1e-4 * sd
        np.testing.assert_allclose(fast.P / sd**2, slow.P / sd**2, atol=1e-5)
        assert coarse.cost == pytest.approx(slow.cost, abs=1e-3)
        assert np.linalg.norm(coarse.p - slow.p) < 0.01 * sd
        found += np.linalg.norm(fast.p - tag) < 5 * sd
        if height == "plane":
            assert fast.p[2] == pytest.approx(tag[2], abs=1e-12) and not fast.P[2].any()
    assert found >= 11


def test_rivals_are_those_of_numpy():
    """Anchors in one plane: the image behind it costs the same."""
    for seed in range(8):
        readings, _ = drawn(seed, "ranges", "free", outliers=0.0)
        first = readings.first * [1, 1, 0]
        tag = np.array([1.0, 0.5, 2.0])
        value = np.linalg.norm(first - tag, axis=1) + 0.05 * np.random.default_rng(seed).normal(size=len(first))
        readings = readings._replace(first=first, second=first, value=value)
        slow, fast = numpy_form.robust_minima(readings), robust_minima(readings)
        assert {1.0, -1.0} <= {np.sign(m.p[2]) for m in fast[:2]}
        for a, b in zip(slow[:2], fast[:2], strict=True):
            assert b.cost == pytest.approx(a.cost, rel=1e-6)
            assert np.abs(b.p) == pytest.approx(np.abs(a.p), abs=1e-4)


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("height", HEIGHTS)
def test_a_track_costs_what_numpy_says_and_is_a_start(height, real):
    readings, tag = drawn(3, "both", height)
    since = np.linspace(-0.5, 0.0, len(readings.value))
    track = tag + [0.2, -0.1, 0.0] + since[:, None] * [1.0, -0.5, 0.2]
    found, cost = robust_search(readings, track, real)
    assert cost == pytest.approx(float(robust_cost(readings, track)), rel=1e-9 if real == "double" else 1e-4)
    assert found[0].cost < cost
    assert found[0].cost == pytest.approx(robust_minima(readings, track[-1:], real)[0].cost)


def test_a_frame_far_from_its_origin_costs_no_accuracy():
    readings, _ = drawn(5, "differences", "sd")
    shift = np.array([4.0e6, -3.0e5, 120.0])
    moved = readings._replace(
        first=readings.first + shift, second=readings.second + shift, down=readings.down + shift[2]
    )
    for real, apart in (("double", 1e-6), ("float", 1e-2)):
        here, there = robust_minima(readings, real=real)[0], robust_minima(moved, real=real)[0]
        assert there.p - shift == pytest.approx(here.p, abs=apart)


def test_pairs_that_form_a_chain_are_enough():
    """No anchor is in every pair: the starts need the arrivals that all pairs together give."""
    rng = np.random.default_rng(7)
    anchors, tag = rng.uniform(-6, 6, (8, 3)), np.array([1.0, -2.0, 0.5])
    first = np.repeat(np.arange(7), 4)
    far = np.linalg.norm(anchors - tag, axis=1)
    value = far[first + 1] - far[first] + 0.02 * rng.normal(size=28)
    readings = WindowReadings(value, anchors[first], anchors[first + 1], np.ones(28, bool), np.full(28, 0.02))
    assert robust_minima(readings)[0].p == pytest.approx(tag, abs=0.2)


def test_too_little_to_go_by_is_no_place():
    readings, _ = drawn(1, "ranges", "free")
    for m in (0, 2):
        few = WindowReadings(*(a[:m] for a in readings[:5]))
        assert robust_minima(few) == numpy_form.robust_minima(few) == []


BASE, _ = drawn(2, "both", "sd")
M = len(BASE.value)
BAD = {
    "values": (BASE._replace(value=np.full(M, np.nan)), "value, row 0"),
    "short": (BASE._replace(sd=np.ones(3)), "sd"),
    "sd": (BASE._replace(sd=np.zeros(M)), "sd, row 0"),
    "first": (BASE._replace(first=np.full((M, 3), np.inf)), "first, row 0"),
    "second": (BASE._replace(second=BASE.second[:, :2]), "second"),
    "pairs": (BASE._replace(pairs=np.ones(2, bool)), "pairs"),
    "height": (BASE._replace(down=np.nan), "height"),
    "height sd": (BASE._replace(down_sd=-1.0), "height"),
    "many": (WindowReadings(*(np.concatenate([a] * 30) for a in BASE[:5])), "at most 512"),
    "places": (WindowReadings(*(np.concatenate([a, a]) for a in BASE[:5]))._replace(
        first=np.random.default_rng(0).normal(size=(2 * M, 3))), "at most 32"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_readings_are_named(name):
    readings, told = BAD[name]
    with pytest.raises(InputError, match=told):
        robust_minima(readings)


def test_bad_guesses_tracks_and_types_are_named():
    for bad in (np.zeros((9, 3)), np.zeros((1, 2)), np.full((1, 3), np.nan)):
        with pytest.raises(InputError, match="guesses"):
            robust_minima(BASE, bad)
    for bad in (np.zeros((M - 1, 3)), np.full((M, 3), np.inf)):
        with pytest.raises(InputError, match="track"):
            robust_search(BASE, bad)
    with pytest.raises(InputError, match="real"):
        robust_minima(BASE, real="half")


SOUND = (
    "double", np.ones(4), np.ones(4), np.eye(4)[:, :3].copy(), np.ones((4, 3)), np.zeros(4, np.uint8), (0, 0.0, 0.0),
    np.zeros((1, 3)), np.zeros((4, 3)), np.empty((36, 10)),
)  # fmt: skip
ANYTHING = st.one_of(
    st.none(),
    st.floats(),
    st.text(max_size=2),
    st.builds(np.zeros, st.integers(0, 40)),
    st.builds(lambda n: np.zeros(n, np.uint8), st.integers(0, 9)),
    st.builds(lambda n: np.zeros((n, 2))[:, 0], st.integers(0, 9)),
)


@settings(max_examples=80, deadline=None)
@given(place=st.integers(0, 9), value=ANYTHING)
def test_the_kernel_answers_or_refuses(place, value):
    arguments = list(SOUND)
    arguments[place] = value
    try:
        count, _ = _kernel.window(*arguments)
    except (TypeError, ValueError):
        return
    assert 0 <= count <= 36


@settings(max_examples=80, deadline=None)
@given(
    numbers=st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=48, max_size=48),
    pairs=st.lists(st.integers(0, 1), min_size=6, max_size=6),
    known=st.integers(0, 2),
    real=st.sampled_from(["double", "float"]),
)
def test_any_numbers_end(numbers, pairs, known, real):
    value, sd, first, second, guess = np.split(np.array(numbers), [6, 12, 30, 45])
    second = np.r_[second, first[:3]]
    rows = np.empty((36, 10))
    arguments = (real, value, sd, first, second, np.array(pairs, np.uint8), (known, 1.0, 0.1), guess, None, rows)
    if real == "double" and np.isfinite(np.r_[first, second]).all() and np.abs(np.r_[first, second]).max() < 1e300:
        assert 0 <= _kernel.window(*arguments)[0] <= 36
        return
    try:
        assert 0 <= _kernel.window(*arguments)[0] <= 36
    except ValueError as why:
        assert "not numbers" in str(why)
