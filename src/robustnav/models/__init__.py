"""The applications: one model a file."""

from robustnav.models.alignment import AlignmentNoise, alignment
from robustnav.models.alignment_so3 import alignment_so3
from robustnav.models.attitude import attitude
from robustnav.models.attitude_euler import attitude_euler
from robustnav.models.attitude_noise import AttitudeNoise
from robustnav.models.inclination import inclination
from robustnav.models.inertial import AidingNoise, InertialNoise, inertial
from robustnav.models.ranging_noise import CARRIERS, RADIOS, Carrier, Radio, carrier_named, radio_named, uwb_of
from robustnav.models.uwb import RangeBias, uwb
from robustnav.models.uwb_planar import planar_stream, uwb_planar

__all__ = [
    "CARRIERS",
    "RADIOS",
    "AidingNoise",
    "AlignmentNoise",
    "AttitudeNoise",
    "Carrier",
    "InertialNoise",
    "Radio",
    "RangeBias",
    "alignment",
    "alignment_so3",
    "attitude",
    "attitude_euler",
    "carrier_named",
    "inclination",
    "inertial",
    "planar_stream",
    "radio_named",
    "uwb",
    "uwb_of",
    "uwb_planar",
]
