"""Planar pose errors: signs, the clock, the turned body, what is missing."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.evaluate.uwb_planar import PlanarPose, PoseReference, planar_figures
from robustnav.frames import quat_from_euler
from robustnav.records import Stream
from robustnav.units import DEG

T = np.arange(0.0, 10.0, 0.1)
YAW = 3.0 + 0.2 * T  # passes half a turn
XY = np.column_stack([T, -2 * T])


def reference(**changes):
    position = Stream("position", T, np.column_stack([XY, 0 * T - 0.9]), "m", "a")
    attitude = Stream("attitude", T, quat_from_euler(np.column_stack([0 * T, 0 * T, YAW])), "1", "a")
    return PoseReference(position, attitude, **changes)


def test_clock_and_turn_are_the_references():
    t = T[10:-10] + 0.03
    true = PlanarPose(t, np.column_stack([t - 0.04, -2 * (t - 0.04)]), 3.0 + 0.2 * (t - 0.04) - 7 * DEG)
    figures = planar_figures(true, reference(clock=-0.04, yaw=-7 * DEG))
    assert figures["rmse_2d"] < 1e-12 and figures["yaw_rmse_deg"] < 1e-9 and figures["samples"] == 80
    late = planar_figures(true, reference(yaw=-7 * DEG))
    assert late["rmse_2d"] == pytest.approx(0.04 * np.sqrt(5))
    assert late["yaw_mean_deg"] == pytest.approx(-0.008 / DEG)  # estimate minus reference
    assert planar_figures(true, reference(clock=-0.04))["yaw_mean_deg"] == pytest.approx(-7)


def test_poses_without_a_reference_do_not_count_and_missing_ones_do():
    xy = XY.copy()
    xy[50] = np.nan
    figures = planar_figures(PlanarPose(T - 5.0, xy, YAW), reference())
    assert figures["samples"] == 50 and figures["nan_estimates"] == 1
    assert np.isnan(figures["rmse_2d"])
    with pytest.raises(InputError, match="nothing to score"):
        planar_figures(PlanarPose(T + 100, XY, YAW), reference())
    with pytest.raises(InputError, match="planar pose"):
        planar_figures(PlanarPose(T, XY[:, :1], YAW), reference())
