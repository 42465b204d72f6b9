"""The applications: one model a file."""

from robustnav.models.attitude import attitude
from robustnav.models.attitude_euler import attitude_euler
from robustnav.models.attitude_noise import AttitudeNoise

__all__ = ["AttitudeNoise", "attitude", "attitude_euler"]
