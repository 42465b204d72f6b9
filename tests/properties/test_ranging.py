"""Filters on ranges: consistent and near their bound on tracks of their own model, in every form of the model."""

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav.evaluate import consistency, nees
from robustnav.filter.weighting import Gate
from robustnav.models import RangeBias, uwb
from robustnav.run.ensemble import Readings, run_ensemble
from robustnav.run.estimators import EKF, UKF
from robustnav.run.loop import Start
from robustnav.run.tracking import ranging_ekf
from robustnav.sim.ranging import simulate_ranging
from robustnav.sim.ranging_errors import Colour, RangingErrors
from robustnav.sim.ranging_random import WhiteAcceleration
from robustnav.sim.ranging_setup import RangingSetup, Schedule, ring_pairs
from robustnav.sim.rig import hall
from robustnav.studies.uwb_own import range_bound

RUNS, SECONDS, DENSITY, SD = 120, 4.0, 0.3, 0.1
MOTION = WhiteAcceleration((0.0, 0.0, -2.0), (0.0,) * 3, (0.3,) * 3, (0.5,) * 3, (DENSITY,) * 3)
WHITE, COLOURED = RangingErrors(white_sd=SD), RangingErrors(white_sd=0.05, colour=Colour(0.12, 3.0))


def drawn(errors, pairs=None, seed=5):
    setup = RangingSetup(hall(), Schedule(10.0, SECONDS, simultaneous=False), errors, pairs)
    tracks = MOTION.draw(setup.events.t, runs=RUNS, seed=seed)
    return setup, tracks, simulate_ranging(tracks, setup, runs=RUNS, seed=seed)


def fed(model, batch, sensor):
    values = batch.readings()
    if "range_bias" in model.state_slices:
        slots = np.eye(8)[batch.setup.events.second]
        values = np.concatenate([values, np.broadcast_to(slots, (*values.shape[:2], 8))], axis=2)
    sensors = [(batch.t, values) if s.name == sensor else None for s in model.sensors]
    return Readings(batch.t, np.zeros((RUNS, len(batch.t), 0)), sensors)


def errors_of(estimator, batch, tracks, sensor="range"):
    start = Start.at(estimator.model, {"p_n": MOTION.p_sd, "v_n": MOTION.v_sd}, p_n=MOTION.p_mean, v_n=MOTION.v_mean)
    out = run_ensemble(estimator, fed(estimator.model, batch, sensor), [start] * RUNS, covariance=True)
    return out.x[..., :3] - tracks.p_n, out.P[..., :3, :3]


def in_band(error, P):
    """Return whether the mean NEES at the end lies in its band, which a right filter leaves once in a thousand."""
    low, high = chi2.ppf([0.0005, 0.9995], 3 * RUNS) / RUNS
    return low < nees(error[:, -1], P[:, -1]).mean() < high


MODEL = uwb(range_sd=SD, acceleration_density=DENSITY)


@pytest.mark.parametrize("estimator", [EKF(MODEL), UKF(MODEL)], ids=["ekf", "ukf"])
def test_white_ranges_leave_filters_consistent_and_at_the_bound(estimator):
    setup, tracks, batch = drawn(WHITE)
    error, P = errors_of(estimator, batch, tracks)
    assert in_band(error, P)
    assert consistency(nees(error, P), 3).inside > 0.8
    bound = range_bound(MODEL, Start.at(MODEL, {"p_n": MOTION.p_sd, "v_n": MOTION.v_sd}).P, setup, tracks)
    limit = np.sqrt(np.trace(bound[..., :3, :3], axis1=-2, axis2=-1).mean())
    assert 0.92 * limit < np.sqrt((error**2).sum(axis=2).mean()) < 1.1 * limit


def test_range_differences_leave_the_filter_consistent():
    _, tracks, batch = drawn(WHITE, ring_pairs(8))
    assert in_band(*errors_of(EKF(MODEL), batch, tracks, "tdoa"))


def test_lasting_errors_need_their_states():
    _, tracks, batch = drawn(COLOURED)
    biased = uwb(range_sd=0.05, acceleration_density=DENSITY, bias=RangeBias(0.12, 3.0, 1e-4))
    white = uwb(range_sd=0.13, acceleration_density=DENSITY)
    assert in_band(*errors_of(ranging_ekf(biased, Gate()), batch, tracks))
    error, P = errors_of(EKF(white), batch, tracks)
    assert nees(error[:, -1], P[:, -1]).mean() > 5.0


def test_a_wrong_noise_leaves_the_band():
    _, tracks, batch = drawn(WHITE)
    for sd in (0.07, 0.14):
        assert not in_band(*errors_of(EKF(uwb(range_sd=sd, acceleration_density=DENSITY)), batch, tracks))


def test_the_bound_of_one_still_step_is_the_inverse_of_its_information():
    setup, tracks, _ = drawn(WHITE)
    P0 = np.diag([4.0, 4.0, 4.0, 1.0, 1.0, 1.0])
    bound = range_bound(MODEL, P0, setup, tracks)
    away = tracks.p_n[7, 0] - setup.anchors.p_a[0]
    H = np.r_[away / np.linalg.norm(away), np.zeros(3)]
    np.testing.assert_allclose(np.linalg.inv(bound[0, 7]), np.linalg.inv(P0) + np.outer(H, H) / SD**2, atol=1e-9)
