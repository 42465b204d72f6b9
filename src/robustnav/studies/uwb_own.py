"""Filters on tracks of their own motion model, from a known prior: beside the bound, and with errors that last."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robustnav.design.bounds import PathRows, posterior_bound
from robustnav.engine.backends import functions_of
from robustnav.evaluate import Consistency, consistency, nees
from robustnav.filter.weighting import Gate, StudentT
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.run.ensemble import Readings, run_ensemble
from robustnav.run.estimators import EKF
from robustnav.run.loop import Start
from robustnav.run.tracking import ranging_ekf
from robustnav.sim.quadcopter import COLOUR_SD, WHITE_SD
from robustnav.sim.ranging import RangingBatch, simulate_ranging
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.ranging_random import RandomTracks
from robustnav.sim.ranging_setup import RangingSetup
from robustnav.studies.uwb_figures import position_figures
from robustnav.studies.uwb_setting import (
    OWN_DENSITY,
    PUBLISHED_GATE,
    RANGE_SD,
    biased_model,
    coloured_errors,
    hall_setup,
    own_motion,
    white_model,
)

Progress = Callable[[], None]
OWN_SECONDS = 10.0


@dataclass(frozen=True)
class Bounded:
    """Filters on tracks of their own model, from a known prior, beside the bound.

    By filter: ``figures``, ``test`` and ``values`` (runs, n) of the position's NEES; ``rms`` (n,) of the position's
    error over runs [m]; ``bound`` (n,) [m], or None.
    """

    t: Array
    figures: dict[str, dict[str, float]]
    tests: dict[str, Consistency]
    values: dict[str, Array]
    rms: dict[str, Array]
    bound: Array | None


def run_bounded(seeds: int, seed: int, progress: Progress) -> Bounded:
    """Run filters with Gaussian ranges on tracks of their own model, and reckon the bound along those tracks."""
    setup = hall_setup(OWN_SECONDS, RangingErrors(white_sd=RANGE_SD))
    tracks = own_motion().draw(setup.events.t, runs=seeds, seed=seed)
    model = white_model(RANGE_SD, OWN_DENSITY)
    filters = {
        "ekf": EKF(model),
        "gate": ranging_ekf(model, Gate(PUBLISHED_GATE)),
        "student": ranging_ekf(model, StudentT()),
    }
    return _own_runs(filters, setup, tracks, seed, progress, bound=True)


def run_coloured(seeds: int, seed: int, progress: Progress) -> Bounded:
    """Run the model with white noise and the one with biases on ranges whose errors last."""
    setup = hall_setup(OWN_SECONDS, coloured_errors())
    tracks = own_motion().draw(setup.events.t, runs=seeds, seed=seed)
    sd = float(np.hypot(WHITE_SD, COLOUR_SD))
    filters = {
        "white noise": EKF(white_model(sd, OWN_DENSITY)),
        "biased": ranging_ekf(biased_model(OWN_DENSITY), Gate()),
    }
    return _own_runs(filters, setup, tracks, seed, progress, bound=False)


def _own_runs(
    filters: dict[str, EKF], setup: RangingSetup, tracks: RandomTracks, seed: int, progress: Progress, *, bound: bool
) -> Bounded:
    """Run filters over tracks of their own model; they know the distribution the tracks start from."""
    runs = len(tracks.p_n)
    batch = simulate_ranging(tracks, setup, runs=runs, seed=seed)
    figures, tests, values, rms = {}, {}, {}, {}
    start = own_start(white_model(RANGE_SD, OWN_DENSITY))
    for name, estimator in filters.items():
        model = estimator.model
        ensemble = run_ensemble(
            estimator, _fed(model, batch), [own_start(model)] * runs, covariance=True, progress=progress
        )
        error = ensemble.x[..., :3] - tracks.p_n
        P = np.empty(0) if ensemble.P is None else ensemble.P[..., :3, :3]
        values[name] = nees(error, P)
        tests[name] = consistency(values[name], 3)
        figures[name] = position_figures(list(error)) | {"nees": tests[name].mean, "lost": 0.0, "runs": float(runs)}
        rms[name] = np.sqrt((error**2).sum(axis=2).mean(axis=0))
    limit = None
    if bound:
        P = range_bound(white_model(RANGE_SD, OWN_DENSITY), start.P, setup, tracks)
        limit = np.sqrt(np.trace(P[..., :3, :3], axis1=-2, axis2=-1).mean(axis=1))
        plane = np.sqrt(np.trace(P[..., :2, :2], axis1=-2, axis2=-1).mean())
        figures["bound"] = {"rmse_2d": float(plane), "rmse_3d": float(np.sqrt(np.mean(limit**2)))}
    return Bounded(setup.events.t, figures, tests, values, rms, limit)


def own_start(model: Model) -> Start:
    """Return the start that ``own_motion`` draws tracks from."""
    motion = own_motion()
    return Start.at(model, {"p_n": motion.p_sd, "v_n": motion.v_sd}, p_n=motion.p_mean, v_n=motion.v_mean)


def _fed(model: Model, batch: RangingBatch) -> Readings:
    """Return a batch as filters take it."""
    t, values = batch.t, batch.readings()
    if "range_bias" in model.state_slices:
        slots = np.eye(len(batch.setup.anchors.ids))[batch.setup.events.second]
        values = np.concatenate([values, np.broadcast_to(slots, (*values.shape[:2], slots.shape[1]))], axis=2)
    sensors = [(t, values) if s.name == "range" else None for s in model.sensors]
    return Readings(t, np.zeros((len(values), len(t), 0)), sensors)


def range_bound(model: Model, P0: Array, setup: RangingSetup, tracks: RandomTracks) -> Array:
    """Return the posterior Cramer-Rao bound (n, runs, 6, 6) along every true track.

    Averaged over tracks it bounds the mean square error of any estimator (Tichavsky et al. 1998, section II).
    """
    functions, t = functions_of(model), setup.events.t
    steps = [functions.transition(np.zeros(6), np.zeros(0), dt) for dt in np.diff(t, prepend=t[0])]
    F, Q = (np.array([s[k] for s in steps])[:, None] for k in (0, 1))
    away = np.swapaxes(tracks.p_n, 0, 1) - setup.anchors.p_a[setup.events.second][:, None]
    H = np.zeros((*away.shape[:2], 1, 6))
    H[..., 0, :3] = away / np.linalg.norm(away, axis=2, keepdims=True)
    F = np.broadcast_to(F, (*away.shape[:2], 6, 6))
    return posterior_bound(F, Q, [PathRows(H, np.array([model.variances[0]]))], P0)
