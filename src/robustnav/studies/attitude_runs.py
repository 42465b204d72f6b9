"""The runs of the attitude study: every estimator over every seed, and the bound beside them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robustnav.design.bounds import posterior_bound
from robustnav.engine.backends import functions_of
from robustnav.evaluate import Consistency, MonteCarlo, consistency, monte_carlo, nees, settle_time
from robustnav.frames import Array, euler_from_quat, matrix_from_quat, quat_from_euler, rotation_error, wrap_angle
from robustnav.model.blocks import Model
from robustnav.run import EKF, Start
from robustnav.run.ensemble import Ensemble, Readings, run_ensemble
from robustnav.sim.attitude_cases import environment, sensors
from robustnav.sim.batch import Batch, Sensors, simulate
from robustnav.sim.trajectory import Trajectory
from robustnav.studies.attitude_setting import (
    Acquisition,
    euler_from_rotation,
    lineup,
    noise,
    quaternion_model,
    start_at,
)
from robustnav.units import DEG

Progress = Callable[[], None]


@dataclass(frozen=True)
class ProtocolResult:
    """One case under one protocol.

    By estimator: ``scores``, ``ns_per_step``, ``total`` (runs, n) size of the error [rad], ``example`` (n, 3) Euler
    errors of the first run [rad].  ``bound_deg`` (3,) RMS and ``bound_sd`` (n, 3) [rad] of roll, pitch, yaw, or None
    where the filters share no start covariance.
    """

    t: Array
    scores: dict[str, MonteCarlo]
    ns_per_step: dict[str, float]
    total: dict[str, Array]
    example: dict[str, Array]
    bound_deg: Array | None
    bound_sd: Array | None


def simulated(trajectory: Trajectory, seeds: int, seed: int, carried: Sensors | None = None) -> Batch:
    """Return sensors along a motion; None takes the study's."""
    return simulate(trajectory, carried or sensors(), environment(), runs=seeds, seed=seed)


def run_protocol(trajectory: Trajectory, batch: Batch, protocol: str, seed: int, progress: Progress) -> ProtocolResult:
    """Run every estimator of a protocol over a batch."""
    rate_hz = 1.0 / float(batch.t[1] - batch.t[0])
    line = lineup(protocol, rate_hz)
    errors = start_errors(line.drawn, len(batch.runs), seed)
    truth = euler_from_quat(batch.q_nb)
    scores, times, total, example = {}, {}, {}, {}
    for name, estimator in line.estimators.items():
        ensemble = run_ensemble(
            estimator, readings(batch), starts(estimator.model, batch, line.told, errors), progress=progress
        )
        q = attitudes(estimator.model, ensemble)
        apart = wrap_angle(euler_from_quat(q) - truth)
        scores[name] = monte_carlo(batch.t, apart)
        times[name] = ensemble.ns_per_step
        total[name] = np.linalg.norm(rotation_error(q, batch.q_nb), axis=-1)
        example[name] = apart[0]
    sd = None if protocol == "published" else bound_sd(trajectory, line.drawn)
    rms = None if sd is None else np.degrees(np.sqrt(np.mean(sd**2, axis=0)))
    return ProtocolResult(batch.t, scores, times, total, example, rms, sd)


def start_errors(P: Array, runs: int, seed: int) -> Array:
    """Return start errors (runs, 6) drawn from a covariance (6, 6), the same for every estimator."""
    normal = np.random.default_rng([seed, 1]).standard_normal((runs, 6))
    values, vectors = np.linalg.eigh(P)
    drawn: Array = normal @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
    return drawn


def starts(model: Model, batch: Batch, told: Array, errors: Array) -> list[Start]:
    """Return one start a run, off by ``errors`` (runs, 6) and told the covariance ``told`` (6, 6)."""
    return [start_at(model, batch.q_nb[0], batch.gyro_bias[i, 0], told, e) for i, e in enumerate(errors)]


def readings(batch: Batch) -> Readings:
    """Return a batch as the filters take it."""
    return Readings(batch.t, batch.gyro, [(batch.t, batch.accel), (batch.t_mag, batch.mag)])


def attitudes(model: Model, ensemble: Ensemble) -> Array:
    """Return q_nb (runs, n, 4) of an ensemble of either model."""
    if model.rotation is not None:
        return ensemble.x[..., :4]
    return quat_from_euler(ensemble.x[..., :3])


def bound_sd(trajectory: Trajectory, P0: Array) -> Array:
    """Return the posterior Cramer-Rao bound on roll, pitch, yaw (n, 3) [rad] along a motion.

    The recursion runs on the true path with the quaternion model's Jacobians; its attitude error in navigation axes
    is then turned into Euler angles.
    """
    motion = trajectory.sample()
    dt = float(motion.t[1] - motion.t[0])
    model = quaternion_model(noise(1.0 / dt))
    functions = functions_of(model)
    still = (np.eye(6), np.zeros((6, 6)))
    steps = [still] + [
        functions.transition(np.r_[q, np.zeros(3)], omega, dt)
        for q, omega in zip(motion.q_nb[:-1], motion.omega_b[1:], strict=True)
    ]
    F, Q = (np.array(part) for part in zip(*steps, strict=True))
    H = [functions.jacobian(j, model.nominal_state()) for j in range(2)]
    updates = [(np.broadcast_to(h, (len(F), *h.shape)), v) for h, v in zip(H, model.variances, strict=True)]
    turn = np.eye(6)
    turn[3:, 3:] = matrix_from_quat(motion.q_nb[0]).T
    P = posterior_bound(F, Q, updates, turn @ P0 @ turn.T)  # type: ignore[arg-type]
    M = euler_from_rotation(euler_from_quat(motion.q_nb))
    covariance = M @ P[:, :3, :3] @ np.swapaxes(M, -1, -2)
    sd: Array = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    return sd


def time_to_one_degree(batch: Batch, wide: Acquisition, seed: int, progress: Progress) -> dict[str, Array]:
    """Return by estimator the time (runs,) [s] from a wide start after which the error stays below one degree."""
    errors = start_errors(wide.P, len(batch.runs), seed)
    out = {}
    for name, estimator in wide.estimators.items():
        begin = starts(estimator.model, batch, wide.P, errors)
        q = attitudes(estimator.model, run_ensemble(estimator, readings(batch), begin, progress=progress))
        total = np.linalg.norm(rotation_error(q, np.broadcast_to(batch.q_nb, q.shape)), axis=-1)
        out[name] = settle_time(batch.t, total, 1.0 * DEG)
    return out


def mekf_consistency(batch: Batch, seed: int, progress: Progress) -> dict[str, tuple[Consistency, Array]]:
    """Return NEES and NIS of the MEKF over a batch, cold start, with their values (runs, steps)."""
    rate_hz = 1.0 / float(batch.t[1] - batch.t[0])
    line = lineup("cold", rate_hz)
    estimator = line.estimators["mekf"]
    if not isinstance(estimator, EKF):
        raise TypeError("the line-up's mekf is an EKF")
    errors = start_errors(line.drawn, len(batch.runs), seed)
    ensemble = run_ensemble(
        estimator,
        readings(batch),
        starts(estimator.model, batch, line.told, errors),
        covariance=True,
        progress=progress,
    )
    apart = rotation_error(np.broadcast_to(batch.q_nb, ensemble.x[..., :4].shape), ensemble.x[..., :4])
    error = np.concatenate([apart, batch.gyro_bias - ensemble.x[..., 4:]], axis=-1)
    values = {"NEES": nees(error, ensemble.P if ensemble.P is not None else np.empty(0))}
    rows = {"accel": 2, "mag": 3}
    for j, name in enumerate(rows):
        part = ensemble.nis[j]
        if part is not None:
            values[f"NIS {name}"] = part
    dof = {"NEES": 6} | {f"NIS {name}": count for name, count in rows.items()}
    return {name: (consistency(v, dof[name]), v) for name, v in values.items()}
