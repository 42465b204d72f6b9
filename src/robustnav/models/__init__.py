"""The applications: one model a file."""

from robustnav.models.attitude import attitude
from robustnav.models.attitude_euler import attitude_euler
from robustnav.models.attitude_noise import AttitudeNoise
from robustnav.models.inertial import AidingNoise, InertialNoise, inertial
from robustnav.models.uwb import RangeBias, uwb

__all__ = [
    "AidingNoise",
    "AttitudeNoise",
    "InertialNoise",
    "RangeBias",
    "attitude",
    "attitude_euler",
    "inertial",
    "uwb",
]
