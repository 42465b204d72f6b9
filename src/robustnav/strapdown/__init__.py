"""Strapdown integration: coning and sculling, pre-integration, navigation equations on WGS-84.

The NumPy form is the specification; ``robustnav.engine.strapdown`` runs the same in C.
"""

from robustnav.strapdown.increments import ImuSamples, Increments
from robustnav.strapdown.navigation import LATITUDE_LIMIT, Navigation, navigate
from robustnav.strapdown.preintegration import preintegrate
from robustnav.strapdown.static import Place, backtrack, carry

__all__ = [
    "LATITUDE_LIMIT",
    "ImuSamples",
    "Increments",
    "Navigation",
    "Place",
    "backtrack",
    "carry",
    "navigate",
    "preintegrate",
]
