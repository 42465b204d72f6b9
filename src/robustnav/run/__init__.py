"""Estimators over recordings, and Monte Carlo over them."""

from robustnav.run.estimators import EKF, H2, UKF, Estimator
from robustnav.run.loop import Start, covariance_of, run, stream

__all__ = ["EKF", "H2", "UKF", "Estimator", "Start", "covariance_of", "run", "stream"]
