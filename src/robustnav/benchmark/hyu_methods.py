"""Our filters on the HYU outdoor set: one set of parameters for every case, found on two of them.

A tag on a slow cart, four anchors on one rig, ranges at 10 Hz each.  The stamps of the ranges are 0.18 s late against
the reference on both development cases (docs/ranging.md, section 5).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from robustnav.benchmark.uwb_methods import Method, positions_at, snapshot_positions
from robustnav.filter.weighting import Gate, StudentT
from robustnav.frames import Array
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.models import CARRIERS, RADIOS, uwb, uwb_of
from robustnav.run.acquisition import Acquisition
from robustnav.run.estimators import EKF
from robustnav.run.tracking import ranging_ekf, track

RADIO, CARRIER = RADIOS["dw1000"], CARRIERS["cart"]
TIME_OFFSET = 0.18  # s


def ours(*, bias: bool = True) -> EKF:
    """Return the filter: with a bias of each anchor, or with white noise alone."""
    return ranging_ekf(uwb_of(RADIO, CARRIER, bias=bias, time_offset=TIME_OFFSET), StudentT())


def published() -> EKF:
    """Return the published filter: white noise on every axis, a gate at 99.7 %, stamps as they are."""
    model = uwb(range_sd=RADIO.white_sd, acceleration_density=CARRIER.acceleration_density)
    return ranging_ekf(model, Gate.probability(0.997))


def hyu_methods() -> Mapping[str, Method]:
    """Return what is compared: ``ekf`` and its smoother ``rts``; white noise; the published filter; single instants."""
    return {
        "ekf": partial(_tracked, estimator=ours()),
        "rts": partial(_tracked, estimator=ours(), smooth=True),
        "ekf-white": partial(_tracked, estimator=ours(bias=False)),
        "rts-white": partial(_tracked, estimator=ours(bias=False), smooth=True),
        "published-ekf": partial(_tracked, estimator=published(), restart=False),
        "snapshot": snapshot_positions,
    }


def _tracked(
    recording: RangeRecording, t: Array, *, estimator: EKF, smooth: bool = False, restart: bool = True
) -> Array:
    settings = Acquisition(speed=CARRIER.speed, restart=restart)
    run = track(estimator, recording.ranges, smooth=smooth, acquisition=settings)
    return positions_at(run, t, smoothed=smooth)
