"""What a ULog file says about itself: firmware, settings, place and date."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from robustnav.logs.px4_gnss import ELLIPSOID, LATITUDE, LONGITUDE, TOPICS, Columns, claims_of, first_of, fixed_rows

EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
ESTIMATORS = {1: "attitude_estimator_q with LPE, not EKF2", 2: "EKF2", 3: "attitude_estimator_q, not EKF2"}


def describe(log: Any, topics: Mapping[str, Columns]) -> dict[str, str | float]:
    """Return ``Log.info`` of a pyulog ``ULog``: only what the file says, nothing assumed."""
    info: dict[str, str | float] = {"format": "PX4 ULog"}
    for key, name in (("ver_sw", "firmware"), ("ver_hw", "hardware"), ("ver_sw_branch", "branch")):
        value = log.msg_info_dict.get(key)
        if isinstance(value, str) and value:
            info[name] = value
    info.update(_settings(log))
    dropouts = [float(d.duration) for d in log.dropouts]
    if dropouts:
        info.update(dropouts=float(len(dropouts)), dropout_ms=sum(dropouts))
    gps = next((topics[name] for name in TOPICS if name in topics), None)
    if gps is not None:
        info |= _position(gps) | claims_of(gps)
    return info


def _settings(log: Any) -> dict[str, str | float]:
    group = _parameter(log, "SYS_MC_EST_GROUP")
    out: dict[str, str | float] = {}
    if group is not None:
        out["SYS_MC_EST_GROUP"] = group
        out["estimator"] = ESTIMATORS.get(int(group), f"unknown group {group:g}")
    # The two estimators keep their declination apart; the wrong one's is not in use.
    names = ("ATT_MAG_DECL", "EKF2_MAG_DECL") if group in (1.0, 3.0) else ("EKF2_MAG_DECL", "ATT_MAG_DECL")
    declination = next((d for name in names if (d := _parameter(log, name)) is not None), None)
    if declination is not None:
        out["declination_deg"] = declination
    for name, key in (("SENS_BOARD_X_OFF", "board_level_x_deg"), ("SENS_BOARD_Y_OFF", "board_level_y_deg")):
        level = _parameter(log, name)
        if level is not None:
            out[key] = level
    return out


def _parameter(log: Any, name: str) -> float | None:
    value = log.initial_parameters.get(name)
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _position(gps: Columns) -> dict[str, str | float]:
    """Return position, height above the ellipsoid and decimal year: medians over samples with a 3-D fix."""
    fixed = fixed_rows(gps)
    if fixed is None or not fixed.any():
        return {}
    out: dict[str, str | float] = {}
    for key, candidates in (("latitude_deg", LATITUDE), ("longitude_deg", LONGITUDE), ("height_m", ELLIPSOID)):
        column = first_of(gps, candidates)
        if column is not None and np.isfinite(value := float(np.median(column[fixed]))):
            out[key] = value
    if "time_utc_usec" in gps.columns:
        year = _year(float(np.median(gps.column("time_utc_usec")[fixed])))
        if year is not None:
            out["year"] = year
    return out


def _year(utc_us: float) -> float | None:
    """Return the decimal year of microseconds since 1970, or None for a clock that was never set."""
    try:
        now = EPOCH + timedelta(microseconds=utc_us)
    except (OverflowError, ValueError):
        return None
    if now.year < 2000:
        return None
    start, stop = datetime(now.year, 1, 1, tzinfo=UTC), datetime(now.year + 1, 1, 1, tzinfo=UTC)
    return now.year + (now - start) / (stop - start)
