"""Satellite readings of a ULog file: fields of old and new firmware, what counts as a fix, what the receiver claims."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robustnav.logs.gnss import FIX_3D, Fixes
from robustnav.records import Array, BoolArray

TOPICS = ("vehicle_gps_position", "sensor_gps")  # the first that is there
LATITUDE = (("latitude_deg", 1.0), ("lat", 1e-7))
LONGITUDE = (("longitude_deg", 1.0), ("lon", 1e-7))
ELLIPSOID = (("altitude_ellipsoid_m", 1.0), ("alt_ellipsoid", 1e-3))
_SEA_LEVEL = (("altitude_msl_m", 1.0), ("alt", 1e-3))
_VELOCITY = ("vel_n_m_s", "vel_e_m_s", "vel_d_m_s")
_CLAIMS = {"eph": "gnss_horizontal_sd_m", "epv": "gnss_vertical_sd_m", "s_variance_m_s": "gnss_speed_sd_m_s"}


class Columns(Protocol):
    """A topic as far as this file needs it."""

    @property
    def columns(self) -> Mapping[str, NDArray[np.generic]]: ...  # noqa: D102

    def column(self, field: str) -> Array: ...  # noqa: D102


def first_of(gps: Columns, candidates: Sequence[tuple[str, float]]) -> Array | None:
    """Return the first of some fields that is there, times its factor, or None."""
    return next((gps.column(field) * factor for field, factor in candidates if field in gps.columns), None)


def fixed_rows(gps: Columns) -> BoolArray | None:
    """Return which rows have a fix in three dimensions, or None where the file does not say."""
    return gps.column("fix_type") >= FIX_3D if "fix_type" in gps.columns else None


def fixes_of(gps: Columns, t: Array) -> Fixes | None:
    """Return the readings of a topic, stamped ``t`` (n,) [s], or None where it does not say what is a fix.

    The height is above the ellipsoid, or above the sea where the file has only that: a position about the first fix
    is the same.
    """
    fixed = fixed_rows(gps)
    if fixed is None:
        return None
    parts = [first_of(gps, LATITUDE), first_of(gps, LONGITUDE), _height(gps, fixed)]
    told = [one for one in parts if one is not None]
    place = np.stack(told, axis=1) if len(told) == len(parts) else None
    v_n = None
    if all(field in gps.columns for field in _VELOCITY):
        v_n = np.stack([gps.column(field) for field in _VELOCITY], axis=1)
        if "vel_ned_valid" in gps.columns:
            v_n[gps.column("vel_ned_valid") == 0] = np.nan
    return Fixes(t, fixed, place, v_n)


def claims_of(gps: Columns) -> dict[str, str | float]:
    """Return the medians of what the receiver says of its own accuracy, over rows with a fix, for ``Log.info``."""
    fixed = fixed_rows(gps)
    if fixed is None or not fixed.any():
        return {}
    medians = {
        name: float(np.median(gps.column(field)[fixed])) for field, name in _CLAIMS.items() if field in gps.columns
    }
    return {name: value for name, value in medians.items() if 0 < value < np.inf}


def _height(gps: Columns, fixed: BoolArray) -> Array | None:
    ellipsoid = first_of(gps, ELLIPSOID)
    filled = ellipsoid is not None and bool(ellipsoid[fixed].any())  # firmware that does not know it leaves zeros
    return ellipsoid if filled else first_of(gps, _SEA_LEVEL)
