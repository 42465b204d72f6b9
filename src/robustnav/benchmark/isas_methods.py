"""Our inertial filter on the ISAS walks: one set of parameters for every walk, figures of the rig.

An inertial unit and a tag on one stick, five anchors.  The unit's driver gives means of eight samples at 82 Hz: its
noise at rest is white only over longer times, and its stamps are 43 ms late; those of the ranges are about 20 ms late.
Range errors last for half a second and more, with 0.1 m of standard deviation; neither offsets of the anchors nor an
antenna's pattern fitted to one half of walk 1 helps on its other half, so none is corrected.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from robustnav.benchmark.uwb_methods import Method, positions_at, snapshot_positions
from robustnav.filter.weighting import StudentT
from robustnav.frames import Array
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.models import AidingNoise, InertialNoise, RangeBias, inertial
from robustnav.run.estimators import EKF
from robustnav.run.inertial import run_inertial

# Densities: the gyro's as measured at rest; the accelerometer's at rest is a third of this, walking adds the rest.
NOISE = InertialNoise(gyro_density=4e-3, accel_density=0.03, gyro_bias_density=2e-5, accel_bias_density=2e-4)
RANGE_SD = 0.05  # m, from one range to the next
BIAS = RangeBias(sd=0.1, time=0.5, scale_sd=1e-3)
LEVER_B = np.array([[0.1, 0.025, 0.0]])  # m, tag from the inertial unit, the authors' figure in FRD
TIME_OFFSET = -0.02  # s, of ranges against the unit's readings
LONGEST_STEP = 0.05  # s


def ours() -> EKF:
    """Return the filter: strapdown with a bias of each anchor, Student-t weights."""
    model = inertial(NOISE, AidingNoise(range_sd=RANGE_SD), bias=BIAS, time_offset=TIME_OFFSET)
    return EKF(model, {"range": StudentT()}, longest_step=LONGEST_STEP)


def isas_methods() -> Mapping[str, Method]:
    """Return what is compared: ``ekf``, causal and started without a prior; its smoother ``rts``; single instants."""
    return {"ekf": _followed, "rts": partial(_followed, smooth=True), "snapshot": snapshot_positions}


def _followed(recording: RangeRecording, t: Array, *, smooth: bool = False) -> Array:
    ranges = replace(recording.ranges, lever_b=LEVER_B)
    return positions_at(run_inertial(ours(), ranges, recording.log, smooth=smooth), t, smoothed=smooth)
