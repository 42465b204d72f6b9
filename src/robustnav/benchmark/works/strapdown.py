"""Strapdown integration: angle and velocity increments of an inertial unit in, increments or a path out."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from robustnav.benchmark.peer import require
from robustnav.benchmark.timing import Contender, Entry, Work
from robustnav.engine.strapdown import carry, navigate, preintegrate
from robustnav.frames import Array, matrix_from_quat, quat_from_euler, quat_from_matrix, rotation_error
from robustnav.sim.alignment_file import load_scenario
from robustnav.sim.sway import attitude_n, sway_increments
from robustnav.strapdown.increments import ImuSamples, Increments
from robustnav.strapdown.navigation import Navigation
from robustnav.strapdown.static import Place
from robustnav.units import DEG

EVERY = 10  # samples an interval
RIGHT = 1e-6  # rad at the end


@dataclass(frozen=True)
class _Swayed:
    """Exact samples at a place, the state at their start and the attitude ``q_nb`` (4,) at their end."""

    samples: ImuSamples
    place: Place
    start: Navigation
    end: Array


@lru_cache(maxsize=2)
def _swayed(samples: int) -> _Swayed:
    scenario, heading = load_scenario("s-10-10-60", "none"), 1.0
    n = max(samples - samples % EVERY, EVERY)
    measured = sway_increments(scenario.sway, n, scenario.imu_rate_hz).samples(heading, scenario.place)
    first, last = attitude_n(scenario.sway, heading, np.array([0.0, n * measured.dt]))
    start = Navigation(first, np.zeros(3), scenario.latitude, 0.0, scenario.height)
    return _Swayed(measured, scenario.place, start, last)


def _fault(q_nb: Array, true_q_nb: Array) -> float:
    return float(np.linalg.norm(rotation_error(q_nb, true_q_nb))) / RIGHT


def _preintegrated(samples: int) -> Contender:
    sway = _swayed(samples)

    def fault(increments: Increments) -> float:
        q_nb, _ = carry(sway.start.q_nb, sway.start.v_n, increments, sway.place)
        return _fault(q_nb[-1], sway.end)

    return Contender(lambda: preintegrate(sway.samples, EVERY), len(sway.samples), fault)


def _navigated(samples: int, every: int) -> Contender:
    sway = _swayed(samples)
    return Contender(
        lambda: navigate(sway.start, sway.samples, every),
        len(sway.samples),
        lambda path: _fault(path.q_nb[-1], sway.end),
    )


def _pyins_tables(sway: _Swayed) -> tuple[Any, Any]:
    """Return its table of inertial readings, whose first is the one before the start, and its start."""
    import pandas as pd

    util, transform = require("pyins.util"), require("pyins.transform")
    readings = np.vstack([sway.samples.history()[1], np.hstack([sway.samples.angle, sway.samples.velocity])])
    t = np.arange(len(readings)) * sway.samples.dt
    angles = transform.mat_to_rph(matrix_from_quat(sway.start.q_nb))
    start = [float(sway.start.latitude) / DEG, 0.0, 0.0, 0.0, 0.0, 0.0, *angles]
    return (
        pd.DataFrame(readings, t, columns=util.GYRO_COLS + util.ACCEL_COLS),
        pd.Series(start, util.LLA_COLS + util.VEL_COLS + util.RPH_COLS),
    )


def _pyins(samples: int) -> Contender:
    sway, strapdown = _swayed(samples), require("pyins.strapdown")
    imu, start = _pyins_tables(sway)

    def work() -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # it calls pandas in a way that pandas 3 dislikes
            increments = strapdown.compute_increments_from_imu(imu, "increment")
            return strapdown.Integrator(start).integrate(increments)

    def fault(path: Any) -> float:
        angles = path[["roll", "pitch", "heading"]].to_numpy()[-1]
        return _fault(quat_from_euler(angles * DEG), sway.end)

    return Contender(work, len(sway.samples), fault)


def _pyins_kernel(samples: int) -> Contender:
    sway, integrate = _swayed(samples), require("pyins._numba_integrate").integrate
    imu, start = _pyins_tables(sway)
    increments = require("pyins.strapdown").compute_increments_from_imu(imu, "increment").to_numpy()
    dt, angle, velocity = (np.ascontiguousarray(part) for part in np.split(increments, [1, 4], axis=1))
    n = len(sway.samples)
    lla, v_n, C_nb = np.empty((n + 1, 3)), np.zeros((n + 1, 3)), np.empty((n + 1, 3, 3))
    lla[0], C_nb[0] = start.to_numpy()[:3], matrix_from_quat(sway.start.q_nb)

    def work() -> Any:
        integrate(dt[:, 0], lla, v_n, C_nb, angle, velocity, 0, True)
        return C_nb[-1]

    return Contender(work, n, lambda C: _fault(quat_from_matrix(C), sway.end))


WORK = Work(
    "strapdown",
    "an inertial sample, whole arrays in double; pyins-kernel is given corrected increments",
    "exact increments at 1 kHz of a carrier that sways in roll by 3 deg at 10 Hz and in pitch by 5 deg at 2 Hz",
    {
        "preintegrate": Entry(_preintegrated),
        "navigate": Entry(lambda n: _navigated(n, EVERY)),
        "navigate-each": Entry(lambda n: _navigated(n, 1)),
        "pyins": Entry(_pyins, needs="pyins", baseline=True),
        "pyins-kernel": Entry(_pyins_kernel, needs="pyins", baseline=True),
    },
)
