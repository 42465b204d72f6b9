"""BROAD: IMU, magnetometer and optical truth of one trial; sensor axes FLU and world ENU turned to FRD and NED.

D. Laidig, M. Caruso, A. Cereatti, T. Seel, BROAD - A Benchmark for Robust Inertial Orientation Estimation, Data 6(7),
2021, doi 10.3390/data6070072.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustnav.frames import frd_from_flu, ned_from_enu, quat_ned_frd_from_enu_flu, quat_normalize
from robustnav.logs.files import unusable
from robustnav.logs.matlab5 import load_matlab5
from robustnav.logs.unit_check import not_unit
from robustnav.records import Array, Log, Stream, Truth
from robustnav.units import MICRO_TESLA

EXPECTED = "a BROAD trial: imu_gyr, imu_acc, imu_mag, opt_quat, opt_pos, movement, sampling_rate"
WIDTHS = {"imu_gyr": 3, "imu_acc": 3, "imu_mag": 3, "opt_quat": 4, "opt_pos": 3, "movement": 1, "sampling_rate": 1}
CONVENTIONS = (
    "sensor axes FLU to body FRD: y and z negated",
    "world ENU to NED; the first world axis is magnetic north, no declination applied",
    "magnetometer microtesla to tesla; no stamps in the file: t = k / sampling_rate",
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
    """Return the fields as (n, width) numbers, all of one row count."""
    variables = load_matlab5(path)
    do = "check that it is a trial of BROAD, and copy it again"
    missing = [name for name in WIDTHS if name not in variables]
    if missing:
        raise unusable(path, f"no field {', '.join(missing)}", EXPECTED, do=do)
    fields: dict[str, Array] = {}
    for name in WIDTHS:
        values = variables[name].values
        if values is None:
            raise unusable(path, variables[name].kind, "real numbers", place=name, do=do)
        fields[name] = values
    rows = len(fields["imu_gyr"])
    for name, width in WIDTHS.items():
        wanted = (1 if name == "sampling_rate" else rows, width)
        if fields[name].shape != wanted or rows < 2:
            raise unusable(path, f"shape {fields[name].shape}", f"shape {wanted}, two rows at least", place=name, do=do)
    return fields
