"""Statistics of every effect on an arrival, and the independence of their random numbers."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.records import Anchors
from robustnav.sim.ranging_arrivals import (
    SPEED_OF_LIGHT,
    Arrivals,
    arrival_errors,
    clock_error,
    colour,
    line_bias,
    nlos_excess,
)
from robustnav.sim.ranging_draws import RangingDraws
from robustnav.sim.ranging_errors import AnchorClocks, Colour, DistanceBias, LinkLine, Nlos, RangingErrors
from robustnav.sim.ranging_setup import RangingSetup, Schedule, ring_pairs, star_pairs

ANCHORS = Anchors(("A", "B", "C"), np.array([[0.0, 0, 0], [9, 0, -1], [0, 9, -2]]))
NOTHING = RangingErrors()
EVERYTHING = RangingErrors(
    white_sd=0.05,
    line=LinkLine(1.01, 0.1, 0.002, 0.03),
    distance_bias=DistanceBias((0.0, 10.0), (0.0, 0.2)),
    colour=Colour(0.1, 2.0),
    nlos=Nlos(0.2, 1.0, 0.4, "uniform"),
    clocks=AnchorClocks(1e-9, 1e-10, 1e-10),
)


def arrivals(rounds_hz=10.0, duration=10.0, simultaneous=False, **more):
    return Arrivals.of(RangingSetup(ANCHORS, Schedule(rounds_hz, duration, simultaneous), NOTHING, **more))


def test_two_way_ranges_have_an_arrival_each():
    some = arrivals(1.0, 3.0)
    assert some.first is None
    np.testing.assert_array_equal(some.second, np.arange(10))
    np.testing.assert_array_equal(some.anchor, [0, 1, 2, 0, 1, 2, 0, 1, 2, 0])
    np.testing.assert_array_equal(some.previous, [-1, -1, -1, 0, 1, 2, 3, 4, 5, 6])
    np.testing.assert_allclose(some.since, [0, 1 / 3, 2 / 3, 1, 1, 1, 1, 1, 1, 1])


def test_differences_at_one_instant_share_the_arrival_of_a_common_anchor():
    star = arrivals(1.0, 1.0, simultaneous=True, pairs=star_pairs(3, 1))
    assert len(star.t) == 6 and len(star.second) == 4
    np.testing.assert_array_equal(star.anchor[star.first], 1)
    np.testing.assert_array_equal(star.anchor[star.second], [0, 2, 0, 2])
    assert star.first[0] == star.first[1] != star.first[2]
    in_turn = arrivals(1.0, 1.0, pairs=star_pairs(3, 1))
    assert len(in_turn.t) == 2 * len(in_turn.second)


def test_white_noise_is_white_and_has_its_sd(in_band, near):
    some, draws = arrivals(), RangingDraws(1, range(50))
    white = arrival_errors(some, np.zeros((1, len(some.t))), RangingErrors(white_sd=0.05), draws).parts["white"]
    in_band(white, 0.05**2)
    near(np.mean(white), 0.0, 0.05, white.size)
    for a, b in ((white[:, 1:], white[:, :-1]), (white[1:], white[:-1])):
        near(np.mean(a * b), 0.0, 0.05**2, a.size)


def test_colour_is_stationary_decays_with_its_time_constant_and_belongs_to_an_anchor(in_band, near):
    some = arrivals(2.0, 20.0)
    # Uneven times: the process may not depend on when it is looked at.
    uneven = replace(some, t=np.sort(np.random.default_rng(0).uniform(0, 20.0, len(some.t))))
    x = colour(uneven, Colour(0.12, 3.0), RangingDraws(2, range(3000))) / 0.12
    for k in (0, 1, 50, 100, len(some.t) - 1):
        in_band(x[:, k], 1.0)
        near(np.mean(x[:, k]), 0.0, 1.0, len(x))
    for k, j in ((3, 0), (60, 57), (60, 30), (61, 1)):
        rho = np.exp(-(uneven.t[k] - uneven.t[j]) / 3.0)
        near(np.mean(x[:, k] * x[:, j]), rho, np.sqrt(1 + rho**2), len(x))
    near(np.mean(x[:, 60] * x[:, 61]), 0.0, 1.0, len(x))  # another anchor


def test_two_tags_at_one_instant_see_the_same_colour_of_an_anchor():
    some = arrivals(5.0, 4.0, simultaneous=True, tags=("left", "right"))
    x = colour(some, Colour(0.12, 3.0), RangingDraws(2, range(3)))
    left, right = x[:, some.tag == 0], x[:, some.tag == 1]
    np.testing.assert_array_equal(left, right)
    assert np.ptp(left) > 0


@pytest.mark.parametrize("kind", ["exponential", "uniform"])
def test_bursts_have_their_share_memory_length_and_excess(kind, near):
    nlos = Nlos(0.2, 1.5, 0.4, kind)
    some = arrivals(20.0, 100.0)
    excess, blocked = nlos_excess(some, nlos, RangingDraws(3, range(40)))
    own = blocked[:, some.anchor == 1], excess[:, some.anchor == 1]
    state, size = own[0].astype(float), own[1]
    # A mean over a time T of a process with the time constant tau counts for T / (2 tau) independent numbers.
    tau, seconds = 1.5 * 0.8, 40 * 100.0
    near(np.mean(state), 0.2, 0.4, seconds / (2 * tau))
    ends = np.count_nonzero(np.diff(state, axis=1) == -1)
    near(state.sum() / 20.0 / ends, 1.5, 1.5, ends)  # exponential bursts: sd = mean
    begun = (state[:, 1:] == 1) & (state[:, :-1] == 0)
    fresh = size[:, 1:][begun]
    near(np.mean(fresh), 0.4, 0.4 if kind == "exponential" else 0.4 / np.sqrt(3), len(fresh))
    assert (excess[blocked] > 0).all() and not excess[~blocked].any()
    assert (fresh.max() < 0.8) == (kind == "uniform")
    held = (state[:, 1:] == 1) & (state[:, :-1] == 1)
    np.testing.assert_array_equal(size[:, 1:][held], size[:, :-1][held])


def test_bursts_are_stationary_from_the_first_reading_and_forget_exponentially(near):
    some = arrivals(2.0, 5.0)
    blocked = nlos_excess(some, Nlos(0.3, 1.0, 1.0, "uniform"), RangingDraws(4, range(4000)))[1].astype(float)
    sd = np.sqrt(0.3 * 0.7)
    for k in (0, 3, len(some.t) - 1):
        near(np.mean(blocked[:, k]), 0.3, sd, 4000)
    rho = np.exp(-1.0 / 0.7)  # two rounds are 1 s; time constant duration (1 - share)
    product = (blocked[:, 6] - 0.3) * (blocked[:, 0] - 0.3)
    near(np.mean(product), rho * sd**2, np.std(product), 4000)
    product = (blocked[:, 1] - 0.3) * (blocked[:, 0] - 0.3)
    near(np.mean(product), 0.0, np.std(product), 4000)  # another anchor


def test_lines_by_link_and_their_spread(in_band, near):
    some = arrivals(5.0, 1.0, simultaneous=True, tags=("left", "right"))
    distance = np.linspace(1, 20, len(some.t))[None]
    slope, offset = np.array([[1.0, 1.1], [1.2, 1.3], [1.4, 1.5]]), np.array([[0.1], [0.2], [0.3]])
    fixed = line_bias(some, distance, LinkLine(slope, offset, 0.0, 0.0), RangingDraws(1, range(2)))
    for k, (anchor, tag) in enumerate(zip(some.anchor, some.tag, strict=True)):
        expected = slope[anchor, tag] * distance[0, k] + offset[anchor, 0] - distance[0, k]
        np.testing.assert_allclose(fixed[:, k], expected, atol=1e-12)
    spread = line_bias(some, distance, LinkLine(1.0, 0.0, 0.01, 0.05), RangingDraws(1, range(4000)))
    for k in (0, 7, len(some.t) - 1):
        in_band(spread[:, k], (0.01 * distance[0, k]) ** 2 + 0.05**2)
    links = spread[:, :6] / np.sqrt((0.01 * distance[0, :6]) ** 2 + 0.05**2)
    near(np.abs(np.triu(links.T @ links / 4000, 1)).max(), 0.0, 1.3, 4000)  # the largest of 15
    again = np.linalg.lstsq(np.column_stack([distance[0, ::6], np.ones(len(distance[0, ::6]))]), spread[0, ::6])[1]
    assert again < 1e-20  # one line a link throughout a run


def test_distance_bias_is_straight_between_knots_and_level_beyond():
    bias = DistanceBias((1.0, 3.0), (0.1, 0.3))
    np.testing.assert_allclose(bias.at(np.array([[0.0, 1.0, 2.0, 3.0, 9.0]])), [[0.1, 0.1, 0.2, 0.3, 0.3]])


def test_clocks_are_offset_drift_and_walk_of_an_anchor(in_band, near):
    some, draws = arrivals(5.0, 20.0, pairs=ring_pairs(3)), RangingDraws(5, range(3000))
    figures = AnchorClocks(2e-9, 3e-10, 4e-10)
    x = clock_error(some, figures, draws)
    for k in (0, 100, len(some.t) - 1):
        t = some.t[k]
        in_band(x[:, k], 2e-9**2 + 3e-10**2 * t**2 + 4e-10**2 * t)
    k, j = (np.flatnonzero(some.anchor == 1)[i] for i in (-1, 40))
    cov = 2e-9**2 + 3e-10**2 * some.t[k] * some.t[j] + 4e-10**2 * some.t[j]
    near(np.mean(x[:, k] * x[:, j]), cov, np.std(x[:, k] * x[:, j]), 3000)
    other = np.flatnonzero(some.anchor == 2)[-1]
    near(np.mean(x[:, k] * x[:, other]), 0.0, np.std(x[:, k] * x[:, other]), 3000)
    ramp = clock_error(some, replace(figures, frequency_density=0.0), RangingDraws(5, range(1)))[0]
    for anchor in range(3):
        own = some.anchor == anchor
        np.testing.assert_allclose(
            np.polyval(np.polyfit(some.t[own], ramp[own], 1), some.t[own]), ramp[own], atol=1e-20
        )


def test_every_effect_keeps_its_numbers_when_others_come_and_go():
    some, draws = arrivals(pairs=ring_pairs(3)), RangingDraws(6, range(3))
    distance = np.linspace(1, 20, len(some.t))[None]
    together = arrival_errors(some, distance, EVERYTHING, draws)
    names = {name: name for name in ("line", "distance_bias", "colour", "nlos", "clocks")} | {"white_sd": "white"}
    for field, part in names.items():
        alone = arrival_errors(some, distance, replace(NOTHING, **{field: getattr(EVERYTHING, field)}), draws)
        assert list(alone.parts) == [part]
        np.testing.assert_array_equal(alone.parts[part], together.parts[part])
    assert len(together.parts) == 6
    np.testing.assert_array_equal(together.total(), sum(together.parts.values()))
    np.testing.assert_array_equal(
        together.parts["clocks"], SPEED_OF_LIGHT * clock_error(some, EVERYTHING.clocks, draws)
    )
    assert not arrival_errors(some, distance, NOTHING, draws).total().any()
