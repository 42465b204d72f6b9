"""Alignment on two recorded flights of a simulator, PX4-ECL's replay tables, beside the heading of their compass."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robustnav.frames import euler_from_quat
from robustnav.logs import read
from robustnav.models.inertial import InertialNoise
from robustnav.records import Innovations
from robustnav.run.inertial_course import found_at
from robustnav.run.moving import align_moving
from robustnav.run.moving_setting import GnssAiding, InertialUnit
from robustnav.units import DEG

# Widened for a simulated MEMS unit that shakes; velocities at rest spread by 0.02 m/s.
UNIT = InertialUnit(InertialNoise(2e-3, 0.05, 2e-5, 5e-4), 0.3 * DEG, 0.3)
AIDING = GnssAiding(velocity_sd=0.03, position_sd=0.3)
DELAYS = (0.0, 0.1)  # s; nothing in the files says how late the receiver's stamps are


@dataclass(frozen=True)
class Flight:
    """A recording by ``name``, in the air from ``begin`` to ``end``; ``heading_deg`` by its compass at ``judged`` [s].

    The compass says about 88 and 22 deg magnetic, the World Magnetic Model adds 2.8 deg there.
    """

    name: str
    begin: float
    end: float
    judged: float
    heading_deg: float


FLIGHTS = (Flight("ekf_gsf_reset.csv", 22.1, 33.0, 31.0, 90.8), Flight("iris_gps.csv", 20.2, 33.4, 32.0, 24.8))


def moving_recordings(folder: Path) -> list[dict[str, object]]:
    """Return a row a flight and a delay.

    When the heading was found [s], NaN where it was not; heading and its sd beside the compass's [deg]; in the air, the
    mean NIS of a velocity's component, expected 1 with the stated noise, and the largest correlation of its neighbours.

    Raises
    ------
    InputError : a table is not in the folder.
    """
    rows: list[dict[str, object]] = []
    for flight in FLIGHTS:
        log = read(folder / flight.name)
        for delay in DELAYS:
            said = align_moving(log, UNIT, replace(AIDING, delay=delay))
            k = int(np.searchsorted(said.t, flight.judged))
            times = found_at(said.events)
            nis, neighbours = _white(said.innovations["velocity"], flight)
            rows.append(
                {
                    "recording": flight.name,
                    "delay_s": delay,
                    "found_s": times[0] if times else float("nan"),
                    "heading_deg": float(euler_from_quat(said.state["q_nb"][k])[2]) / DEG,
                    "heading_sd_deg": float(said.sd["q_nb"][k, 2]) / DEG,
                    "compass_deg": flight.heading_deg,
                    "nis": nis,
                    "neighbours": neighbours,
                }
            )
    return rows


def _white(seen: Innovations, flight: Flight) -> tuple[float, float]:
    """Return the mean NIS of a component and the largest lag-one correlation of the components, in the air."""
    flown = (seen.t > flight.begin) & (seen.t < flight.end) & np.isfinite(seen.nis)
    z = seen.z[flown] / np.sqrt(seen.s[flown])
    lag = np.sum(z[1:] * z[:-1], axis=0) / np.sum(z**2, axis=0)
    return float(seen.nis[flown].mean()) / z.shape[1], float(np.abs(lag).max())
