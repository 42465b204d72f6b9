"""What satellite receivers log, into streams: velocity, and position in level axes about the first fix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.earth import ned_from_geodetic
from robustnav.records import Array, BoolArray, Stream
from robustnav.units import DEG

FIX_3D = 3  # what receivers and their loggers call a fix in three dimensions, or better
CONVENTION = "gnss_position: north, east, down of the first fix, in straight axes that are level there"


@dataclass(frozen=True)
class Fixes:
    """A receiver's readings at ``t`` (n,) [s]; ``fixed`` (n,) where it says that it has a fix in three dimensions.

    ``place`` (n, 3) latitude [deg], longitude [deg], height [m], or None; ``v_n`` (n, 3) [m/s] north, east, down, or
    None.
    """

    t: Array
    fixed: BoolArray
    place: Array | None
    v_n: Array | None


def gnss_streams(fixes: Fixes, skipped: list[str]) -> tuple[list[Stream], dict[str, str | float]]:
    """Return streams ``gnss_velocity`` and ``gnss_position``, frame n, and where the origin is, for ``Log.info``.

    Rows without a fix, or with numbers that are no place or no velocity, are NaN and named in ``skipped``; a stream
    without any reading is absent.
    """
    n = len(fixes.t)
    if not fixes.fixed.all():
        skipped.append(f"gnss: {int((~fixes.fixed).sum())} of {n} rows without a 3-D fix")
    streams: list[Stream] = []
    info: dict[str, str | float] = {}
    if fixes.v_n is not None:
        whole = fixes.fixed & np.isfinite(fixes.v_n).all(axis=1)
        _name("velocity", fixes.fixed & ~whole, n, skipped)
        if whole.any():
            streams.append(Stream("gnss_velocity", fixes.t, np.where(whole[:, None], fixes.v_n, np.nan), "m/s", "n"))
    if fixes.place is not None:
        whole = fixes.fixed & _somewhere(fixes.place)
        _name("place", fixes.fixed & ~whole, n, skipped)
        if whole.any():
            origin = fixes.place[np.argmax(whole)]
            p_n = np.full((n, 3), np.nan)
            p_n[whole] = ned_from_geodetic(fixes.place[whole] * _SCALE, origin * _SCALE)
            streams.append(Stream("gnss_position", fixes.t, p_n, "m", "n"))
            info = {
                f"origin_{name}": float(v)
                for name, v in zip(("latitude_deg", "longitude_deg", "height_m"), origin, strict=True)
            }
    return streams, info


_SCALE = np.array([DEG, DEG, 1.0])
_HIGHEST = 1e6  # m; no receiver for aircraft is above it


def _somewhere(place: Array) -> BoolArray:
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(place) <= [90.0, 360.0, _HIGHEST]).all(axis=1), bool)


def _name(what: str, bad: BoolArray, n: int, skipped: list[str]) -> None:
    if bad.any():
        skipped.append(f"gnss: {int(bad.sum())} of {n} rows with a fix tell no {what}")
