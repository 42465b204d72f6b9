"""Our filter of the planar pose on the LIAS sets: one set of parameters for every set, figures of the rig.

Errors of calibrated ranges go with the anchor's bearing from the trolley and with its double, differently for each tag:
antennas, the trolley's body, and where a tag really sits.  Amplitudes fitted to motion capture on either half of the
development set agree within 0.014 m, and those of one half serve the other.
"""

from __future__ import annotations

import numpy as np

from robustnav.benchmark.lias_pose import planar_poses
from robustnav.errors import InputError
from robustnav.evaluate.uwb_planar import PlanarPose
from robustnav.filter.weighting import StudentT
from robustnav.models.uwb_planar import planar_stream, uwb_planar
from robustnav.records import Log, Ranges
from robustnav.run.estimators import EKF
from robustnav.run.loop import Start, run
from robustnav.run.smoothing import smooth as smooth_log
from robustnav.units import DEG

RANGE_SD = 0.3  # m: errors of 0.06 m that last for a quarter of a second, at 100 Hz a link
ACCELERATION_DENSITY, YAW_ACCELERATION_DENSITY = 0.1, 0.2  # m/s^2/sqrt(Hz), rad/s^2/sqrt(Hz)
PATTERN = np.array(  # m, by tag: cosine and sine of the bearing, of twice the bearing
    [[0.0053, -0.0323, 0.0132, 0.0414], [0.0131, 0.0015, -0.0102, -0.0387], [0.0055, -0.0089, 0.0194, 0.0316]]
)
START_SD = {"p_n": 0.1, "v_n": 0.3, "yaw": 10 * DEG, "yaw_rate": 0.3}
_START_WITHIN = 1.0  # s


def followed_poses(ranges: Ranges, height: float, every: int, *, smooth: bool = False) -> PlanarPose:
    """Return the pose at every so-manieth instant from calibrated ranges, started at the first pose they tell.

    Parameters
    ----------
    ranges : calibrated, of the three tags of the set, with ``lever_b``.
    height : z of the trolley's origin in frame a [m], down.
    every : take one instant in so many.
    smooth : by all ranges, later ones too; else by those up to each instant.

    Raises
    ------
    InputError : no pose in the first second, or as ``planar_stream``.
    """
    begin = planar_poses(ranges.where(ranges.t <= ranges.t[0] + _START_WITHIN), height)
    known = np.flatnonzero(np.isfinite(begin.yaw))
    if not known.size:
        raise InputError("planar pose", got=f"none in the first {_START_WITHIN:g} s", expected="ranges of one instant")
    k = int(known[0])
    model = uwb_planar(
        range_sd=RANGE_SD,
        acceleration_density=ACCELERATION_DENSITY,
        yaw_acceleration_density=YAW_ACCELERATION_DENSITY,
        body_down=height,
    )
    start = Start.at(model, START_SD, p_n=begin.xy[k], yaw=begin.yaw[k])
    later = ranges.where(ranges.t > begin.t[k])
    log = Log({"range": planar_stream(later, PATTERN)}, "ranges")
    out = (smooth_log if smooth else run)(EKF(model, {"range": StudentT()}), log, start)
    chosen = slice(every - 1, None, every)  # the instant of the start was the first one
    return PlanarPose(out.t[chosen], out.state["p_n"][chosen], out.state["yaw"][chosen, 0])
