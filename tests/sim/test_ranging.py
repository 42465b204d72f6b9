"""Ranges and differences along a track: geometry, noise covariances, losses, stamps, seeds, records."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import matrix_from_quat
from robustnav.records import Anchors
from robustnav.sim import quadcopter
from robustnav.sim.ranging import lost, outlier_errors, simulate_ranging
from robustnav.sim.ranging_arrivals import Arrivals, clock_error
from robustnav.sim.ranging_draws import EFFECTS, RangingDraws
from robustnav.sim.ranging_errors import (
    AnchorClocks,
    Colour,
    DistanceBias,
    LinkLine,
    Nlos,
    Outage,
    Outliers,
    RangingErrors,
)
from robustnav.sim.ranging_random import RandomTracks, WhiteAcceleration
from robustnav.sim.ranging_setup import RangingSetup, Schedule, ring_pairs, star_pairs

ANCHORS = Anchors(("A", "B", "C", "D"), np.array([[5.0, 4, -0.3], [5, -4, -4], [-5, -4, -0.3], [-5, 4, -4]]))
LEVERS = np.array([[0.1, 0.0, -0.05], [-0.2, 0.1, 0.0]])
PATH = quadcopter.flight()
MEASURED = quadcopter.measured_errors()


NOTHING = RangingErrors()


def setup(errors=NOTHING, simultaneous=False, duration=20.0, **more):
    return RangingSetup(ANCHORS, Schedule(10.0, duration, simultaneous), errors, **more)


def batch(one, runs=1, seed=0):
    return simulate_ranging(PATH.at(one.events.t), one, runs=runs, seed=seed)


def distance(t, anchor, lever):
    """The distance, one reading at a time and from nothing but the path."""
    states = PATH.at(np.array([t]))
    return np.linalg.norm(states.p_n[0] + matrix_from_quat(states.q_nb[0]) @ lever - ANCHORS.p_a[anchor])


def test_schedules():
    t, link = Schedule(2.0, 1.0, simultaneous=False).events(3)
    np.testing.assert_allclose(t, np.arange(7) / 6)
    np.testing.assert_array_equal(link, [0, 1, 2, 0, 1, 2, 0])
    t, link = Schedule(2.0, 1.0, simultaneous=True).events(3)
    np.testing.assert_allclose(t, [0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1])
    np.testing.assert_array_equal(link, [0, 1, 2] * 3)
    assert star_pairs(4, 2) == ((2, 0), (2, 1), (2, 3))
    assert ring_pairs(3) == ((0, 1), (1, 2), (2, 0))


@pytest.mark.parametrize("simultaneous", [False, True])
def test_ranges_without_errors_are_distances_of_the_tags(simultaneous):
    one = setup(simultaneous=simultaneous, tags=("left", "right"), lever_b=LEVERS)
    ranges = batch(one).ranges(0)
    assert len(ranges) == (201 * 8 if simultaneous else 20 * 80 + 1)
    assert (np.diff(ranges.t) >= 0).all() and set(ranges.tag) == {0, 1} and set(ranges.anchor) == {0, 1, 2, 3}
    np.testing.assert_array_equal(ranges.lever_b, LEVERS)
    for k in range(0, len(ranges), 97):
        expected = distance(ranges.t[k], ranges.anchor[k], LEVERS[ranges.tag[k]])
        assert ranges.distance[k] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("simultaneous", [False, True])
def test_differences_without_errors_are_second_less_first(simultaneous):
    one = setup(simultaneous=simultaneous, pairs=((0, 1), (3, 1), (2, 3)), tags=("left", "right"), lever_b=LEVERS)
    seen = batch(one).differences(0)
    assert set(zip(seen.first, seen.second, strict=True)) == {(0, 1), (3, 1), (2, 3)}
    for k in range(0, len(seen), 97):
        lever = LEVERS[seen.tag[k]]
        expected = distance(seen.t[k], seen.second[k], lever) - distance(seen.t[k], seen.first[k], lever)
        assert seen.difference[k] == pytest.approx(expected, abs=1e-12)


def test_noise_of_simultaneous_differences_is_correlated_as_their_anchors_are_shared():
    for pairs, expected in (
        (star_pairs(4), np.eye(3) + 1),
        (((0, 1), (1, 2), (2, 3)), np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 2]])),
    ):
        clean, noisy = setup(pairs=pairs, simultaneous=True), setup(RangingErrors(0.1), pairs=pairs, simultaneous=True)
        error = (batch(noisy, 100).values - batch(clean).values).reshape(-1, 3) / 0.1
        assert np.abs(np.cov(error.T) - expected).max() < 4.5 * 2 / np.sqrt(len(error))
    apart = setup(RangingErrors(0.1), pairs=star_pairs(4))
    error = (batch(apart, 100).values - batch(replace(apart, errors=NOTHING)).values) / 0.1
    assert abs(np.mean(error[:, 1:] * error[:, :-1])) < 4 * 2 / np.sqrt(error.size)


def test_a_clock_ahead_makes_its_anchor_look_far(in_band):
    clocks = AnchorClocks(1e-9, 0.0, 0.0)
    one = setup(RangingErrors(clocks=clocks), pairs=((0, 1), (1, 2)), simultaneous=True)
    error = batch(one, 2000).values - batch(setup(pairs=one.pairs, simultaneous=True)).values
    assert np.ptp(error.reshape(2000, -1, 2), axis=1).max() < 1e-12  # constant in time
    in_band(error[:, 0], 2 * (299792458.0 * 1e-9) ** 2)
    ahead = clock_error(Arrivals.of(one), clocks, RangingDraws(0, range(2000)))[:, :3]  # anchors 0, 1, 2 at time 0
    np.testing.assert_allclose(error[:, :2], 299792458.0 * np.diff(ahead, axis=1), atol=1e-12)


def test_outliers_have_their_share_and_interval(near):
    errors, draws = RangingErrors(outliers=Outliers(0.03, -4.0, 2.0)), RangingDraws(1, range(50))
    gross = outlier_errors(2000, errors, draws)
    hit = gross[gross != 0]
    near(len(hit) / gross.size, 0.03, np.sqrt(0.03 * 0.97), gross.size)
    assert -4.0 <= hit.min() < -3.9 and 1.9 < hit.max() < 2.0
    near(np.mean(hit), -1.0, 6 / np.sqrt(12), len(hit))
    every = outlier_errors(2000, RangingErrors(outliers=Outliers(1.0, -4.0, 2.0)), draws)
    np.testing.assert_array_equal(every[gross != 0], hit)


def test_losses(near):
    one = setup(RangingErrors(dropout_share=0.1, outages=(Outage(3.0, 4.0, None), Outage(8.0, 12.0, (2,)))))
    gone = lost(one.events, one.errors, RangingDraws(1, range(30)))
    t, anchor = one.events.t, one.events.second
    during = ((t >= 3) & (t < 4)) | ((t >= 8) & (t < 12) & (anchor == 2))
    assert during.sum() == 40 + 40 and gone[:, during].all()
    near(gone[:, ~during].mean(), 0.1, 0.3, gone[:, ~during].size)
    np.testing.assert_array_equal(np.isnan(batch(one, 2, seed=1).values), gone[:2])
    pairs = replace(one, pairs=ring_pairs(4)).events
    either = lost(pairs, RangingErrors(outages=(Outage(0.0, 99.0, (2,)),)), RangingDraws(1, range(1)))[0]
    np.testing.assert_array_equal(either, (pairs.first == 2) | (pairs.second == 2))


def test_lost_readings_are_missing_rows_in_records_and_nan_in_arrays():
    one = setup(MEASURED, pairs=ring_pairs(4))
    seen = batch(one, 3)
    array, table = seen.readings(), seen.differences(2)
    assert array.shape == (3, len(one.events), 7)
    keep = ~np.isnan(array[2, :, 0])
    assert 0 < np.count_nonzero(~keep) < 0.1 * len(keep)
    np.testing.assert_array_equal(array[2, keep], table.stream().values)
    np.testing.assert_array_equal(seen.t[keep], table.t)
    assert not np.isnan(array[..., 1:]).any()
    np.testing.assert_array_equal(seen.stream(2).values, table.stream().values)
    two_way = batch(setup(MEASURED), 2)
    np.testing.assert_array_equal(two_way.stream(1).values, two_way.ranges(1).stream().values)
    assert two_way.readings().shape[2] == 4


@pytest.mark.parametrize("delay", [0.18, -0.05])
def test_a_late_stamp_carries_an_older_range(delay):
    late, prompt = batch(setup(RangingErrors(stamp_delay=delay))), batch(setup())
    np.testing.assert_allclose(late.t, prompt.t + delay)
    np.testing.assert_array_equal(late.values, prompt.values)


def test_nlos_marks_the_readings_it_makes_longer():
    nlos = RangingErrors(nlos=Nlos(0.3, 1.0, 0.5, "exponential"))
    one = batch(setup(nlos), 4)
    error = one.values - batch(setup()).values
    assert (error[one.nlos] > 0).all() and np.abs(error[~one.nlos]).max() < 1e-12
    pairs = batch(setup(nlos, pairs=ring_pairs(4)), 4)
    error = pairs.values - batch(setup(pairs=ring_pairs(4))).values
    assert (np.abs(error[pairs.nlos]) > 0).all() and np.abs(error[~pairs.nlos]).max() < 1e-12
    assert (error[pairs.nlos] < 0).any() and (error[pairs.nlos] > 0).any()


def test_a_run_does_not_depend_on_the_others_and_a_seed_fixes_it():
    one = setup(replace(MEASURED, line=LinkLine(1.0, 0.0, 0.01, 0.1)))
    many = batch(one, 12).values
    np.testing.assert_array_equal(batch(one, 5).values, many[:5])
    np.testing.assert_array_equal(batch(one, range(7, 10)).values, many[7:10])
    np.testing.assert_array_equal(batch(one, range(7, 10)).ranges(8).distance, many[8][~np.isnan(many[8])])
    assert len({row.tobytes() for row in many}) == 12
    assert not np.array_equal(batch(one, 5, seed=1).values, many[:5])


def test_losing_readings_leaves_the_others_as_they_are():
    one = batch(setup(replace(MEASURED, dropout_share=None)), 2).values
    some = batch(setup(replace(MEASURED, dropout_share=0.3, outages=(Outage(1.0, 2.0, None),))), 2).values
    keep = ~np.isnan(some)
    assert 0.6 < keep.mean() < 0.72
    np.testing.assert_array_equal(some[keep], one[keep])


def test_streams_of_random_numbers_are_all_different():
    draws = RangingDraws(0, range(2))
    assert len({row.tobytes() for name in EFFECTS for row in draws.normal(name, (4,))}) == 2 * len(EFFECTS)


def test_tracks_that_differ_from_run_to_run():
    one = setup()
    white = WhiteAcceleration((0, 0, -2.0), (0, 0, 0), (1, 1, 0.2), (0.5, 0.5, 0.1), (0.3, 0.3, 0.05))
    tracks = white.draw(one.events.t, runs=3, seed=4)
    seen = simulate_ranging(tracks, one, runs=3, seed=4)
    expected = np.linalg.norm(tracks.p_n - ANCHORS.p_a[one.events.second], axis=2)
    np.testing.assert_allclose(seen.values, expected, atol=1e-12)


def far_track(t, **changes):
    return RandomTracks(**{"t": t, "p_n": np.zeros((2, len(t), 3)), "v_n": np.zeros((2, len(t), 3)), **changes})


T = setup().events.t


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: batch(setup(), 0), "runs"),
        (lambda: batch(setup(), range(-1, 2)), "runs"),
        (lambda: batch(setup(), seed=-1), "seed"),
        (lambda: simulate_ranging(PATH.at(T[:-1]), setup(), runs=1, seed=0), "track, t"),
        (lambda: simulate_ranging(PATH.at(T + 1e-6), setup(), runs=1, seed=0), "setup.events.t"),
        (lambda: simulate_ranging(far_track(T), setup(), runs=3, seed=0), "track, p_n"),
        (lambda: simulate_ranging(far_track(T), setup(lever_b=LEVERS[:1]), runs=2, seed=0), "attitude"),
        (lambda: batch(setup(), 2).ranges(2), "0 to 1"),
        (lambda: batch(setup()).differences(0), "two-way"),
        (lambda: batch(setup(pairs=ring_pairs(4))).ranges(0), "two-way"),
        (lambda: Schedule(0.0, 1.0, True), "rate"),
        (lambda: Schedule(1.0, 0.5, True), "duration"),
        (lambda: setup(pairs=((0, 0),)), "pairs"),
        (lambda: setup(pairs=((0, 4),)), "0 to 3"),
        (lambda: setup(pairs=()), "none"),
        (lambda: setup(tags=("x", "x")), "twice"),
        (lambda: setup(lever_b=LEVERS), "lever_b"),
        (lambda: setup(RangingErrors(clocks=AnchorClocks(0.0, 0.0, 0.0))), "two-way"),
        (lambda: setup(RangingErrors(outages=(Outage(0.0, 1.0, (4,)),))), "outage"),
        (lambda: setup(RangingErrors(line=LinkLine(np.ones(4), 0.0, 0.0, 0.0))), "link line"),
        (lambda: LinkLine(0.0, 0.0, 0.0, 0.0), "slope"),
        (lambda: LinkLine(1.0, np.nan, 0.0, 0.0), "offset"),
        (lambda: LinkLine(1.0, 0.0, -1.0, 0.0), "slope_sd"),
        (lambda: DistanceBias((1.0, 1.0), (0.0, 0.0)), "ascending"),
        (lambda: DistanceBias((1.0,), ()), "ascending"),
        (lambda: DistanceBias((), ()), "ascending"),
        (lambda: Colour(0.0, 1.0), "sd"),
        (lambda: Colour(1.0, np.inf), "tau"),
        (lambda: Nlos(1.0, 1.0, 1.0, "uniform"), "share"),
        (lambda: Nlos(0.1, 0.0, 1.0, "uniform"), "duration"),
        (lambda: Nlos(0.1, 1.0, -1.0, "uniform"), "excess_mean"),
        (lambda: Nlos(0.1, 1.0, 1.0, "normal"), "exponential or uniform"),
        (lambda: Outliers(1.1, 0.0, 1.0), "share"),
        (lambda: Outliers(0.1, 1.0, 1.0), "low below high"),
        (lambda: Outage(1.0, 1.0, None), "outage"),
        (lambda: Outage(1.0, 2.0, ()), "anchors"),
        (lambda: AnchorClocks(-1.0, 0.0, 0.0), "offset_sd"),
        (lambda: RangingErrors(white_sd=-1.0), "white_sd"),
        (lambda: RangingErrors(dropout_share=np.nan), "dropout_share"),
        (lambda: RangingErrors(stamp_delay=np.inf), "stamp_delay"),
    ],
)
def test_bad_input(make, words):
    with pytest.raises(InputError, match=words):
        make()
