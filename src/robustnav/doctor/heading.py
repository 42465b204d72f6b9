"""H: whether a recorded heading moves while the gyro says the vehicle stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.doctor.motion import MOVING, whole_rows
from robustnav.doctor.turning import FEW, interval_rates
from robustnav.frames import rotate
from robustnav.records import Array, Stream, Truth
from robustnav.units import DEG


@dataclass(frozen=True)
class Heading:
    """Heading moved over ``still_s`` seconds at rest: by the attitude, by the gyro, and by the gyro less its median."""

    attitude_deg: float
    gyro_deg: float
    unbiased_deg: float
    still_s: float


def heading_at_rest(gyro: Stream, truth: Truth) -> Heading | None:
    """Return the heading figures over the intervals below 10 deg/s (median removed), or None with too few."""
    if truth.q_nb is None:
        return None
    whole = np.isfinite(truth.q_nb).all(axis=1)
    t, q_nb = truth.t[whole], truth.q_nb[whole]
    rates = interval_rates(gyro, t, q_nb, longest=np.inf)  # what moved in a gap moved
    if len(rates.start) < FEW:
        return None
    unbiased = rates.gyro - np.median(whole_rows(gyro)[1], axis=0)
    still = np.linalg.norm(unbiased, axis=1) < MOVING
    span = (rates.stop - rates.start)[still]
    q_still = q_nb[np.searchsorted(t, rates.start[still])]

    def moved(rate_b: Array) -> float:
        return float(np.sum(rotate(q_still, rate_b[still])[:, 2] * span)) / DEG

    return Heading(moved(rates.attitude), moved(rates.gyro), moved(unbiased), float(span.sum()))
