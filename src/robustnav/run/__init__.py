"""Estimators over recordings, and Monte Carlo over them."""

from robustnav.run.estimators import EKF, H2, UKF, Estimator, HInfinity
from robustnav.run.gamma import smallest_gamma
from robustnav.run.loop import Start, covariance_of, run, stream
from robustnav.run.smoothing import batch, smooth

__all__ = [
    "EKF",
    "H2",
    "UKF",
    "Estimator",
    "HInfinity",
    "Start",
    "batch",
    "covariance_of",
    "run",
    "smallest_gamma",
    "smooth",
    "stream",
]
