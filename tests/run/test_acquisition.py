"""What starts and restarts a filter: windows, rivals, news, and where it may be lost."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.run.acquisition import (
    LASTING,
    Acquisition,
    Events,
    lost_at,
    news_of,
    places,
    rivals,
    span,
    track_cost,
)
from robustnav.sim import rig
from robustnav.sim.ranging import simulate_ranging
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.ranging_path import FigureEight, Leg, Path
from robustnav.sim.ranging_setup import RangingSetup, Schedule, ring_pairs

SD = 0.1
EIGHT = Path((0.0, 0.0, -1.2), 0.0, (FigureEight(3.0, 2.0, 0.5, 1, 12.0),), 9.8, tilts=False)
BELOW = Path((1.0, 1.0, -1.2), 0.0, (Leg((3.0, -2.0, -2.0), 5.0),), 9.8, tilts=False)


def simulated(path=EIGHT, anchors=None, pairs=None):
    schedule = Schedule(10.0, path.duration, simultaneous=False)
    setup = RangingSetup(anchors or rig.hall(), schedule, RangingErrors(white_sd=SD), pairs)
    return simulate_ranging(path.at(setup.events.t), setup, runs=1, seed=1)


def ranges(**kwargs):
    return simulated(**kwargs).ranges(0)


def events_of(given, down=None):
    return Events.joined([Events.of(given, SD)], down)


def test_readings_of_all_kinds_are_joined_in_time_order():
    one, two = ranges(), simulated(pairs=ring_pairs(8)).differences(0)
    events = Events.joined([Events.of(one, SD), Events.of(two, 2 * SD)], None)
    assert len(events.t) == len(one) + len(two)
    assert (np.diff(events.t) >= 0).all()
    assert events.pairs.sum() == len(two)
    assert set(events.sd[events.pairs]) == {2 * SD}
    rows = events.between(1.0, 2.0)
    assert events.t[rows.start] > 1.0 >= events.t[rows.start - 1]
    assert events.t[rows.stop - 1] <= 2.0 < events.t[rows.stop]


def test_the_window_grows_where_readings_are_slow_and_knows_only_its_own_time():
    fast, settings = ranges(), Acquisition()
    assert span(events_of(fast), settings) == settings.window
    slow = fast.where(np.arange(len(fast)) % 8 == 0)
    tau = span(events_of(slow), settings)
    assert tau == pytest.approx(12 * 0.1)
    early = slow.where(slow.t <= slow.t[0] + tau)
    assert span(events_of(early), settings) == tau
    rare = fast.where(np.arange(len(fast)) % 80 == 0)
    assert span(events_of(rare), settings) == settings.patience


def test_places_are_near_the_tag_and_pass_box_and_limit():
    events = events_of(ranges())
    rows = events.between(0.0, 0.5)
    (best, *_) = places(events, rows, Acquisition())
    np.testing.assert_allclose(best.p, EIGHT.at(np.array([0.25])).p_n[0], atol=0.3)
    (same, *_) = places(events, rows, Acquisition(), compiled=False)
    np.testing.assert_allclose(same.p, best.p, atol=1e-5)
    elsewhere = np.array([[5.0, 5.0, -9.0], [6.0, 6.0, 0.0]])
    assert places(events, rows, Acquisition(box=elsewhere)) == []
    assert places(events, rows, Acquisition(limit_sd=0.01)) == []
    assert places(events, slice(0, 7), Acquisition()) == []


def test_a_mirror_image_is_a_rival_and_a_clear_minimum_has_none():
    flat = events_of(ranges(anchors=rig.ceiling(), path=BELOW))
    rows = flat.between(0.0, 0.5)
    found = places(flat, rows, Acquisition())
    (rival,) = rivals(flat, rows, found)
    assert rival.p[2] + found[0].p[2] == pytest.approx(-8.0, abs=0.01)
    clear = events_of(ranges())
    rows = clear.between(0.0, 0.5)
    assert rivals(clear, rows, places(clear, rows, Acquisition())) == []


def test_a_track_costs_least_where_the_tag_is():
    events = events_of(ranges())
    rows, truth = events.between(3.0, 3.5), EIGHT.at(np.array([3.5]))
    at = track_cost(events, rows, truth.p_n[0], truth.v_n[0])
    assert at < track_cost(events, rows, truth.p_n[0] + [0.3, 0.0, 0.0], truth.v_n[0])
    assert at < track_cost(events, rows, truth.p_n[0], truth.v_n[0] + [2.0, 0.0, 0.0])


def test_news_counts_the_silence_of_an_anchor():
    given = ranges()
    share = news_of(given)
    assert (share[:8] == 1.0).all()
    np.testing.assert_allclose(share[8:], 0.1 / LASTING, rtol=1e-9)
    gone = news_of(given.where((given.t < 1.0) | (given.t > 5.0)))
    assert (gone == 1.0).sum() == 16
    pairs = news_of(simulated(pairs=ring_pairs(8)).differences(0))
    np.testing.assert_allclose(pairs[8:], 0.1 / LASTING, rtol=1e-9)


def test_a_filter_may_be_lost_where_half_of_a_window_is_off_or_after_silence():
    events = events_of(ranges())
    n = len(events.t)
    nothing = np.zeros(n, bool)
    assert not len(lost_at(events, nothing, 0.0, 0.5))
    off = nothing.copy()
    off[300:340] = np.arange(40) % 3 > 0
    found = lost_at(events, off, 0.0, 0.5)
    assert len(found)
    assert off[found].all()
    assert found[0] >= 300 + 28
    off[300:340] = np.arange(40) % 3 == 0
    assert not len(lost_at(events, off, 0.0, 0.5))
    quiet = events_of(ranges().where((ranges().t < 3.0) | (ranges().t > 7.0)))
    again = quiet.t[lost_at(quiet, np.zeros(len(quiet.t), bool), 0.0, 0.5)]
    assert again.min() >= 7.5
    assert again.max() <= 8.1


@pytest.mark.parametrize("name", ["window", "patience", "speed", "limit_sd"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_settings_must_be_positive(name, value):
    with pytest.raises(InputError, match=name):
        Acquisition(**{name: value})


def test_a_box_inside_out_is_refused():
    with pytest.raises(InputError, match="box"):
        Acquisition(box=np.zeros((2, 3)))
