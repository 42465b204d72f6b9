"""Our filters on the HYU outdoor set: one set of parameters for every case, found on two of them.

A tag on a slow cart, four anchors on one rig, ranges at 10 Hz each.  The stamps of the ranges are 0.18 s late against
the reference on both development cases (docs/ranging.md, section 5).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from robustnav.benchmark.uwb_methods import Method, positions_at, snapshot_positions
from robustnav.filter.weighting import Gate, Rule, StudentT
from robustnav.frames import Array
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.models import RangeBias, uwb
from robustnav.run.acquisition import Acquisition
from robustnav.run.estimators import EKF
from robustnav.run.tracking import track

ACCELERATION_DENSITY = 0.55  # m/s^2/sqrt(Hz), of a carrier at walking pace that turns
VERTICAL_DENSITY = 1e-3  # m/s^2/sqrt(Hz), of wheels on a yard
RANGE_SD = 0.1  # m, white
WHITE_SD = 0.15  # m, where white noise has to stand for biases too
BIAS = RangeBias(sd=0.04, time=60.0, scale_sd=0.004)
TIME_OFFSET = 0.18  # s
LONGEST_STEP = 15.0  # s, a quarter of the biases' time constant


def ours(*, bias: bool = True, rule: Rule | None = None) -> EKF:
    """Return the filter: with a bias of each anchor, or with white noise alone; ``rule`` for outliers."""
    model = uwb(
        range_sd=RANGE_SD if bias else WHITE_SD,
        acceleration_density=ACCELERATION_DENSITY,
        vertical_density=VERTICAL_DENSITY,
        bias=BIAS if bias else None,
        time_offset=TIME_OFFSET,
    )
    return EKF(model, {"range": StudentT() if rule is None else rule}, LONGEST_STEP)


def published() -> EKF:
    """Return the published filter: white noise on every axis, a gate at 99.7 %, stamps as they are."""
    return EKF(
        uwb(range_sd=WHITE_SD, acceleration_density=ACCELERATION_DENSITY), {"range": Gate.probability(0.997)}
    )


def _tracked(recording: RangeRecording, t: Array, *, estimator: EKF, smooth: bool = False, restart: bool = True) -> Array:
    run = track(estimator, recording.ranges, smooth=smooth, acquisition=Acquisition(restart=restart))
    return positions_at(run, t, smoothed=smooth)


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
