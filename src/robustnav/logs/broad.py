"""BROAD: IMU, magnetometer and optical truth of one trial; sensor axes FLU and world ENU turned to FRD and NED.

D. Laidig, M. Caruso, A. Cereatti, T. Seel, BROAD - A Benchmark for Robust Inertial Orientation Estimation, Data 6(7),
2021, doi 10.3390/data6070072.
"""

from __future__ import annotations

import struct
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from robustnav.frames import frd_from_flu, ned_from_enu, quat_ned_frd_from_enu_flu, quat_normalize
from robustnav.logs.files import unusable
from robustnav.logs.unit_check import not_unit
from robustnav.records import Array, Log, Stream, Truth
from robustnav.units import MICRO_TESLA

EXPECTED = "a BROAD trial: imu_gyr, imu_acc, imu_mag, opt_quat, opt_pos, movement, sampling_rate"
WIDTHS = {"imu_gyr": 3, "imu_acc": 3, "imu_mag": 3, "opt_quat": 4, "opt_pos": 3, "movement": 1, "sampling_rate": 1}
MOST_ROWS = 20_000_000
CONVENTIONS = (
    "sensor axes FLU to body FRD: y and z negated",
    "world ENU to NED; the first world axis is magnetic north, no declination applied",
    "magnetometer microtesla to tesla; no stamps in the file: t = k / sampling_rate",
)
# What SciPy raises on damaged files, found by feeding it damaged files.
DAMAGE = (
    OSError,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    NotImplementedError,
    AttributeError,
    MemoryError,
    RecursionError,
    EOFError,
    struct.error,
    zlib.error,
    Warning,
)


def read_broad(path: Path) -> Log:
    """Return one BROAD trial: streams gyro, accel, mag; ``truth`` the optical attitude (NaN rows kept) and position.

    Raises
    ------
    InputError : no MATLAB 5 file, cut or damaged, or not the fields of BROAD.
    """
    fields = _load(path)
    rate = float(fields["sampling_rate"][0, 0])
    if not 1 <= rate <= 100_000:
        raise unusable(path, f"{rate} Hz", "a sampling rate in Hz", place="sampling_rate")
    t = np.arange(len(fields["imu_gyr"])) / rate
    moving = fields["movement"][:, 0]
    if not np.isin(moving, (0, 1)).all():
        raise unusable(path, "other numbers", "0 or 1 in every row", place="movement")
    streams = (
        Stream("gyro", t, frd_from_flu(fields["imu_gyr"]), "rad/s"),
        Stream("accel", t, frd_from_flu(fields["imu_acc"]), "m/s^2"),
        Stream("mag", t, frd_from_flu(fields["imu_mag"]) * MICRO_TESLA, "T"),
    )
    truth = Truth(
        t,
        q_nb=quat_ned_frd_from_enu_flu(_unit(path, fields["opt_quat"])),
        kind="optical",
        north="magnetic",
        p_n=ned_from_enu(fields["opt_pos"]),
        moving=moving.astype(bool),
        accuracy="eight cameras; attitude aligned to sensor axes and magnetic north by the authors of the data",
    )
    return Log({s.name: s for s in streams}, path.name, CONVENTIONS, truth=truth, info={"format": "BROAD"})


def _unit(path: Path, q: Array) -> Array:
    bad = not_unit(q)
    if bad:
        raise unusable(path, f"norm {bad[1]:.3g}", "unit quaternions or NaN", place=f"opt_quat row {bad[0]}")
    return quat_normalize(q)


def _load(path: Path) -> dict[str, Array]:
    """Return the fields as (n, width) numbers; shapes are checked in the file's directory before anything is loaded."""
    from scipy.io import loadmat, whosmat

    do = "check that it is a MATLAB 5 file of BROAD, and copy it again"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            listed = {name: shape for name, shape, _ in whosmat(path)}
            missing = [name for name in WIDTHS if name not in listed]
            shapes = {name: listed[name] for name in WIDTHS if name in listed}
            if not missing and _consistent(shapes):
                content = loadmat(path, variable_names=list(WIDTHS))
    except DAMAGE as why:
        raise unusable(path, f"a damaged or foreign file ({type(why).__name__}: {why})", EXPECTED, do=do) from why
    if missing:
        raise unusable(path, f"no field {', '.join(missing)}", EXPECTED, do=do)
    if not _consistent(shapes):
        raise unusable(path, f"shapes {shapes}", "one row count, 3 columns (opt_quat 4, movement 1)", do=do)
    return {name: _numbers(path, name, content.get(name), shapes[name]) for name in WIDTHS}


def _consistent(shapes: dict[str, tuple[int, ...]]) -> bool:
    rows = shapes["imu_gyr"][0] if shapes["imu_gyr"] else 0
    wanted = {name: (1 if name == "sampling_rate" else rows, width) for name, width in WIDTHS.items()}
    return 2 <= rows <= MOST_ROWS and all(tuple(shapes[name]) == wanted[name] for name in WIDTHS)


def _numbers(path: Path, name: str, value: Any, shape: tuple[int, ...]) -> Array:
    """Return a real numeric array as float; refuse complex, object, text and sparse ones."""
    kind = getattr(getattr(value, "dtype", None), "kind", "nothing")
    if not isinstance(value, np.ndarray) or kind not in "fiub" or value.shape != tuple(shape):
        raise unusable(path, f"{type(value).__name__} of kind {kind!r}", f"real numbers {shape}", place=name)
    return value.astype(float)
