"""Tracking: starts, mirror images, restarts, and nothing that looks ahead."""

import numpy as np
import pytest

from robustnav.errors import EstimatorError, InputError
from robustnav.filter.steps import pack
from robustnav.filter.weighting import Gate, StudentT
from robustnav.models import RangeBias, attitude, uwb
from robustnav.models.attitude_noise import AttitudeNoise
from robustnav.ranging import Anchors
from robustnav.run import hypotheses
from robustnav.run.acquisition import Acquisition
from robustnav.run.estimators import UKF
from robustnav.run.tracking import ranging_ekf, track
from robustnav.run.tracking_task import Source, TrackingTask
from robustnav.sim import rig
from robustnav.sim.ranging import simulate_ranging
from robustnav.sim.ranging_errors import Colour, Outage, Outliers, RangingErrors
from robustnav.sim.ranging_path import FigureEight, Leg, Path, Rest
from robustnav.sim.ranging_random import RandomTracks
from robustnav.sim.ranging_setup import RangingSetup, Schedule, ring_pairs

SD = 0.1
WHITE = RangingErrors(white_sd=SD)
MODEL = uwb(range_sd=SD, acceleration_density=1.0)
LINE = Anchors(tuple("abcd"), np.array([[x, 0.0, -1.0] for x in (-6.0, -2.0, 2.0, 6.0)]))


def level(start, *stops, seconds=5.0):
    """Return a path of legs from a start, after a second of rest."""
    return Path(start, 0.0, (Rest(1.0), *(Leg(to, seconds) for to in stops)), 9.8, tilts=False)


EIGHT = Path((0.0, 0.0, -1.2), 0.0, (FigureEight(3.0, 2.0, 0.5, 1, 12.0),), 9.8, tilts=False)
BELOW = level((1.0, 1.0, -1.2), (3.0, -2.0, -2.0), (-3.0, -1.0, -1.0))


def simulated(path=EIGHT, errors=WHITE, anchors=None, pairs=None, moved=None, seed=1):
    """Return a batch of one run; ``moved``: (time, by how far) the tag is carried."""
    setup = RangingSetup(anchors or rig.hall(), Schedule(10.0, path.duration, simultaneous=False), errors, pairs)
    t = setup.events.t
    p_n = path.at(t).p_n.copy()
    if moved is not None:
        p_n[t >= moved[0]] += moved[1]
    return simulate_ranging(RandomTracks(t, p_n, np.zeros_like(p_n)), setup, runs=1, seed=seed)


def ranges(**kwargs):
    """Return the ranges of one run."""
    return simulated(**kwargs).ranges(0)


def error_of(run, path=EIGHT, moved=None):
    """Return the position error (n, 3) [m] of a run."""
    truth = path.at(run.t).p_n
    if moved is not None:
        truth[run.t >= moved[0]] += moved[1]
    p = run.state["p_n"]
    return p - truth[:, : p.shape[1]]


STUDENT, GATE = ranging_ekf(MODEL, StudentT()), ranging_ekf(MODEL, Gate(8.8))
BIASED = ranging_ekf(uwb(range_sd=0.05, acceleration_density=1.0, bias=RangeBias(0.12, 3.0, 1e-3)), StudentT())
CARRIED = np.array([3.0, -2.5, -0.8])


def distance(error):
    return np.linalg.norm(error, axis=1)


def rms(error):
    return float(np.sqrt(np.mean(distance(error) ** 2)))


@pytest.mark.parametrize("estimator", [STUDENT, GATE, UKF(MODEL)], ids=["student", "gate", "ukf"])
def test_it_starts_without_a_prior_within_half_a_second_and_stays_within_its_deviation(estimator):
    run = track(estimator, ranges())
    assert run.t[0] < 0.6
    error = error_of(run)
    assert rms(error) < 0.2
    assert 0.6 < np.mean((error / run.sd["p_n"]) ** 2) < 1.8
    assert not any("fit" in e or "lost" in e for e in run.events)


def test_the_smoother_is_better_and_stays_near_the_filter():
    given = ranges()
    filtered, backward = track(STUDENT, given), track(STUDENT, given, smooth=True)
    assert rms(error_of(backward)) < 0.8 * rms(error_of(filtered))
    np.testing.assert_allclose(backward.state["p_n"][-1], filtered.state["p_n"][-1], atol=1e-9)
    assert (backward.sd["p_n"] <= filtered.sd["p_n"] + 1e-9).all()


CASES = {
    "healthy": {"errors": RangingErrors(white_sd=SD, outliers=Outliers(0.2, 0.5, 5.0), dropout_share=0.1)},
    "silent and moved": {
        "errors": RangingErrors(white_sd=SD, outages=(Outage(4.0, 8.0, None),)),
        "moved": (6.0, CARRIED),
    },
    "jump": {"moved": (6.0, CARRIED)},
    "mirror": {"anchors": rig.ceiling(), "path": BELOW},
    "through the plane": {"anchors": rig.ceiling(), "path": level((1.0, 1.0, -3.0), (2.0, -2.0, -5.5))},
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("estimator", [GATE, BIASED], ids=["gate", "biased"])
def test_no_later_reading_changes_what_was_said_before(case, estimator):
    given = ranges(**CASES[case])
    whole = track(estimator, given)
    for end in (0.3, 0.55, 0.8):
        t = given.t[int(end * len(given))]
        part = track(estimator, given.where(given.t <= t))
        n = int(np.searchsorted(part.t, t, side="right"))
        for name in ("p_n", "v_n"):
            np.testing.assert_array_equal(part.state[name][:n], whole.state[name][:n])
            np.testing.assert_array_equal(part.sd[name][:n], whole.sd[name][:n])


@pytest.mark.parametrize("case", ["jump", "mirror"])
def test_numpy_says_what_c_says(case):
    given = ranges(**CASES[case])
    given = given.where((given.t < 0.8) | ((given.t > 5.7) & (given.t < 6.7)))
    for smooth in (False, True):
        c, numpy = (track(STUDENT, given, backend=b, smooth=smooth) for b in ("c", "numpy"))
        np.testing.assert_array_equal(c.t, numpy.t)
        np.testing.assert_allclose(numpy.state["p_n"], c.state["p_n"], atol=1e-6)
        np.testing.assert_allclose(numpy.sd["p_n"], c.sd["p_n"], rtol=1e-5)


@pytest.mark.parametrize("estimator", [GATE, STUDENT, BIASED], ids=["gate", "student", "biased"])
def test_a_tag_carried_away_is_found_within_a_second(estimator):
    for case in ("silent and moved", "jump"):
        moved = CASES[case]["moved"]
        run = track(estimator, ranges(**CASES[case]))
        late = run.t > (9.0 if case == "silent and moved" else 7.0)
        assert distance(error_of(run, moved=moved)[late]).max() < 0.8, case


def test_the_published_gate_never_finds_a_tag_that_jumped():
    run = track(GATE, ranges(moved=(6.0, CARRIED)), acquisition=Acquisition(restart=False))
    assert distance(error_of(run, moved=(6.0, CARRIED))[run.t > 8.0]).min() > 1.0
    found = track(GATE, ranges(moved=(6.0, CARRIED)))
    assert sum(e.startswith("lost at") for e in found.events) == 1


def test_silence_is_named_and_doubt_grows_in_it():
    given = ranges(errors=RangingErrors(white_sd=SD, outages=(Outage(4.0, 8.0, None),)))
    run = track(BIASED, given)
    assert any(e.startswith("no ranges from 3.99 to 8.00") for e in run.events)
    silent = (run.t > 4.0) & (run.t < 8.0)
    assert silent.sum() > 5
    assert (np.diff(np.linalg.norm(run.sd["p_n"][silent], axis=1)) > 0).all()
    assert rms(error_of(run)[run.t > 9.0]) < 0.4


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_smoother_tells_the_path_through_a_silence_from_both_ends(seed):
    given = ranges(errors=RangingErrors(white_sd=SD, outages=(Outage(3.0, 8.0, None),)), seed=seed)
    forward, both = (track(BIASED, given, smooth=smooth) for smooth in (False, True))
    silent = (both.t > 3.0) & (both.t < 8.0)
    end = (both.t > 7.0) & (both.t < 8.0)
    assert rms(error_of(both)[silent]) < 0.5 * rms(error_of(forward)[silent])
    assert distance(error_of(both)[end])[-1] < 0.5 * distance(error_of(forward)[end])[-1]  # it nears the far end
    assert (np.linalg.norm(both.sd["p_n"][end], axis=1) < np.linalg.norm(forward.sd["p_n"][end], axis=1)).all()


def test_a_mirror_image_is_named_and_lies_within_the_deviation():
    run = track(STUDENT, ranges(anchors=rig.ceiling(), path=BELOW))
    assert any("two places fit" in e and "not settled" in e for e in run.events)
    error = error_of(run, BELOW)
    assert (distance(error) < 3 * np.linalg.norm(run.sd["p_n"], axis=1)).all()
    np.testing.assert_allclose(error[:, :2], 0.0, atol=0.6)
    smoothed = track(STUDENT, ranges(anchors=rig.ceiling(), path=BELOW), smooth=True)
    assert (distance(error_of(smoothed, BELOW)) < 3 * np.linalg.norm(smoothed.sd["p_n"], axis=1)).all()


def test_a_tag_that_passes_the_plane_may_be_on_either_side():
    path = level((1.0, 1.0, -3.0), (2.0, -2.0, -5.5))
    run = track(STUDENT, ranges(anchors=rig.ceiling(), path=path))
    assert any("either side" in e for e in run.events)
    assert (distance(error_of(run, path)) < 4 * np.linalg.norm(run.sd["p_n"], axis=1)).all()


def test_of_two_ways_the_one_that_fits_is_taken_and_smoothed():
    dents = np.array([[0.0, 0.0, z] for z in (0.4, -0.4, 0.4, -0.4)])
    anchors = Anchors(tuple("abcd"), rig.ceiling().p_a + dents)
    task = TrackingTask.of(STUDENT, Source(ranges(anchors=anchors, path=BELOW)), Acquisition(), "auto")
    row, (best, *_) = task.first_place()
    wrong = best._replace(p=best.p * [1.0, 1.0, -1.0] - np.array([0.0, 0.0, 8.0]))
    leg = hypotheses.Leg.begin(task, row, [task.start(wrong), task.start(best)], 0.0)
    assert leg.settled
    x, P = hypotheses.smoothed(task, [leg])
    assert not leg.merged
    np.testing.assert_array_equal(x[-1], leg.ways[1].x[-1])
    np.testing.assert_array_equal(leg.reported()[0][-1], leg.ways[1].x[-1])
    assert np.linalg.norm(x[:, :3] - BELOW.at(task.feed.t[row:]).p_n, axis=1).max() < 0.8
    assert np.isfinite(P).all()


def test_a_mirror_image_is_as_far_from_every_anchor_of_the_plane():
    task = TrackingTask.of(STUDENT, Source(ranges(anchors=rig.ceiling(), path=BELOW)), Acquisition(), "auto")
    rng = np.random.default_rng(0)
    x, root = rng.normal(size=6), rng.normal(size=(6, 6))
    P = root @ root.T
    image = task.mirrored(x, pack(P))
    far = [np.linalg.norm(p - rig.ceiling().p_a, axis=1) for p in (x[:3], image.x[:3])]
    np.testing.assert_allclose(far[0], far[1])
    np.testing.assert_allclose(np.linalg.norm(image.x[3:]), np.linalg.norm(x[3:]))
    back = task.mirrored(image.x, pack(image.P))
    np.testing.assert_allclose(back.x, x)
    np.testing.assert_allclose(back.P, P)


def test_a_box_decides_between_mirror_images():
    box = np.array([[-9.0, -9.0, -4.0], [9.0, 9.0, 0.5]])
    run = track(STUDENT, ranges(anchors=rig.ceiling(), path=BELOW), acquisition=Acquisition(box=box))
    assert not any("two places" in e for e in run.events)
    assert rms(error_of(run, BELOW)) < 0.3


def test_anchors_on_a_line_are_refused():
    with pytest.raises(EstimatorError, match="no position to start from"):
        track(STUDENT, ranges(anchors=LINE, path=BELOW))


def test_range_differences_alone_and_beside_ranges():
    both = simulated(pairs=ring_pairs(8)).differences(0), ranges(seed=2)
    alone = track(STUDENT, both[0])
    assert rms(error_of(alone)) < 0.4
    joined = track(STUDENT, both)
    assert rms(error_of(joined)) < min(rms(error_of(alone)), rms(error_of(track(STUDENT, both[1]))))
    assert set(joined.innovations) >= {"range", "tdoa"}


def test_a_known_height_and_a_plane():
    path = level((1.0, 1.0, -1.0), (3.0, -2.0, -1.0), (-3.0, -1.0, -1.0))
    given = ranges(anchors=rig.ceiling(), path=path)
    run = track(STUDENT, given, height=1.0)
    assert rms(error_of(run, path)) < 0.25
    assert run.state["p_n"][0, 2] == pytest.approx(-1.0, abs=0.2)
    flat = ranging_ekf(uwb(range_sd=SD, acceleration_density=1.0, dimensions=2, tag_down=-1.0), StudentT())
    assert rms(error_of(track(flat, given), path)) < 0.25
    with pytest.raises(InputError, match="height"):
        track(flat, given, height=1.0)


def test_slow_ranges_start_later_and_still_look_back_only():
    given = ranges(path=BELOW)
    given = given.where(np.arange(len(given)) % 7 == 0)
    run = track(STUDENT, given)
    assert run.settings["acquisition window [s]"] == pytest.approx(12 * 7 / 80, rel=0.1)
    assert rms(error_of(run, BELOW)) < 0.5


def test_lasting_errors_leave_the_biased_model_consistent():
    given = ranges(errors=RangingErrors(white_sd=0.05, colour=Colour(0.12, 3.0)))
    white = ranging_ekf(uwb(range_sd=0.13, acceleration_density=1.0), StudentT())
    values = [np.mean((error_of(run) / run.sd["p_n"]) ** 2) for run in (track(BIASED, given), track(white, given))]
    assert values[0] < 2.0
    assert values[1] > 1.5 * values[0]


def test_bad_input_is_refused():
    given = ranges()
    with pytest.raises(InputError, match="a model of"):
        track(ranging_ekf(_attitude(), StudentT()), given)
    with pytest.raises(InputError, match="one table of a kind"):
        track(STUDENT, [given, given])
    with pytest.raises(InputError, match="not empty"):
        track(STUDENT, given.where(np.zeros(len(given), bool)))
    with pytest.raises(InputError, match="none"):
        track(STUDENT, [])
    with pytest.raises(EstimatorError, match="no position"):
        track(STUDENT, given.where(given.anchor < 2))
    with pytest.raises(InputError, match="backend"):
        track(STUDENT, given, backend="fortran")


def _attitude():
    return attitude(AttitudeNoise(1e-3, 1e-5, 0.5, 1e-6), field=48e-6, dip_deg=60.0)
