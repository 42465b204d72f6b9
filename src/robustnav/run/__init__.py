"""Estimators over recordings, and Monte Carlo over them."""

from robustnav.run.estimators import EKF, H2, UKF, Estimator, HInfinity
from robustnav.run.gamma import smallest_gamma
from robustnav.run.loop import Start, covariance_of, run, stream
from robustnav.run.moving import align_moving
from robustnav.run.moving_setting import GnssAiding, InertialUnit, MovingStart
from robustnav.run.smoothing import batch, smooth

__all__ = [
    "EKF",
    "H2",
    "UKF",
    "Estimator",
    "GnssAiding",
    "HInfinity",
    "InertialUnit",
    "MovingStart",
    "Start",
    "align_moving",
    "batch",
    "covariance_of",
    "run",
    "smallest_gamma",
    "smooth",
    "stream",
]
