"""The applications: one model a file."""

from robustnav.models.attitude import attitude
from robustnav.models.attitude_euler import attitude_euler

__all__ = ["attitude", "attitude_euler"]
