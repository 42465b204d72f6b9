"""Units as factors to SI: multiply on the way in, divide on the way out.

>>> rate = 2.0 * DPS      # two degrees per second, in rad/s
>>> rate / DPS
2.0
"""

from __future__ import annotations

from math import pi

DEG = pi / 180.0  # rad
ARCMIN = DEG / 60.0  # rad
DPS = DEG  # rad/s
DEG_PER_HOUR = DEG / 3600.0  # rad/s
STANDARD_GRAVITY = 9.80665  # m/s^2
MILLI_G = 1e-3 * STANDARD_GRAVITY  # m/s^2
MICRO_G = 1e-6 * STANDARD_GRAVITY  # m/s^2
KNOT = 1852.0 / 3600.0  # m/s
KILOMETRE_PER_HOUR = 1.0 / 3.6  # m/s
GAUSS = 1e-4  # T
MILLI_GAUSS = 1e-7  # T
MICRO_TESLA = 1e-6  # T
NANO_TESLA = 1e-9  # T
MS = 1e-3  # s
US = 1e-6  # s
