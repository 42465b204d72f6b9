"""Where the binary points of the integer filter lie, derived from ranges and gains so that no sum can overflow.

Qn: a number with n fractional bits.  Corrections, gyro and bias are half turns a step [rad].  Bounds take every
sensor at the end of its range on every axis.  Derivation and error budget: docs/firmware.md, section 4.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import floor, log2, sqrt

import numpy as np

from robustnav.errors import InputError
from robustnav.export.observer import ROWS, SENSORS, split_gain
from robustnav.export.schedule import Schedule
from robustnav.frames import Array
from robustnav.units import DPS, MICRO_TESLA, STANDARD_GRAVITY

FULL = 32768.0  # counts at the end of an int16
WIDTH = {"accel": 4, "mag": 3}  # fractional bits kept of a reading turned to navigation axes, in counts
_VECTOR = 2**15.9  # largest length of a vector whose product with a row of C (Q15) fits 31 bits
_LEVEL = 2**9.5  # largest integer bias gain: its product with 21 bits of C_bn t fits 31
_SMALL = 2.0**-8  # of the bias gain: what is smaller is below the resolution of the gains and left out
CUT = 10  # bits of C_bn t that the bias does not use


@dataclass(frozen=True)
class Counts:
    """What one count of each sensor is worth, and how far the gyro's bias may go.

    ``gyro`` [rad/s], ``accel`` [m/s^2], ``mag`` [T] a count; ``bias`` largest bias [rad/s].  Default: an MPU-9250 at
    2000 deg/s, 8 g and 0.15 uT a count, with 10 deg/s of bias.
    """

    gyro: float = 2000 * DPS / FULL
    accel: float = 8 * STANDARD_GRAVITY / FULL
    mag: float = 0.15 * MICRO_TESLA
    bias: float = 10 * DPS

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"counts: {name}", got=str(value), expected="a size above zero")


@dataclass(frozen=True)
class Correcting:
    """Integer gains of one set of sensors.

    With rho the reading in navigation axes, in counts with ``WIDTH`` fractional bits:
    t (Q``turn``) = sum gains rho >> gains_down; r = C_bn t; v = rest t >> rest_down;
    bias += (level (r >> CUT) + C_bn v) >> (bias_bits - points.bias).
    """

    rows: tuple[int, ...]
    gains: Array
    gains_down: int
    turn: int
    level: int
    rest: Array
    rest_down: int
    bias_bits: int
    reach: float


@dataclass(frozen=True)
class Scaling:
    """All points of an integer filter.

    ``rate``: half turns a step of one gyro count in Q``fine``; ``coarse``: fractional bits of the half turn that is
    used, the rest waits; ``bias``: fractional bits of the bias; ``field_bits``: readings of the magnetometer of
    2^(field_bits - 1) counts or more are refused; ``sets`` by mask.
    """

    counts: Counts
    dt: float
    rate: int
    fine: int
    coarse: int
    bias: int
    field_bits: int
    sets: Mapping[int, Correcting]

    @classmethod
    def of(cls, schedule: Schedule, counts: Counts, dt: float, field: float) -> Scaling:
        """Derive every point from a steady gain.

        Raises
        ------
        InputError : a start-up schedule, or ranges and gains that 32 bits do not hold.
        """
        if schedule.staged:
            raise InputError(
                "integer export",
                got="a start-up schedule, whose first gains leave no bits for the last",
                expected="a steady gain",
                do='H2(..., start_sd="steady"), and reset with the attitude of the first readings',
            )
        field_bits = 2 + floor(log2(4 * field / counts.mag))
        limits = {"accel": FULL, "mag": 2.0 ** (field_bits - 1)}
        sets = {mask: _correcting(schedule.gains[0, mask - 1], mask, counts, limits, dt) for mask in (3, 1, 2)}
        rate, reach = FULL * counts.gyro * dt / 2, max(s.reach for s in sets.values())
        bias = min(floor(log2(2**30 / (counts.bias * dt / 2))), *(s.bias_bits for s in sets.values()))
        drift = 2.0 ** (30 - bias)  # where an update is refused
        coarse = floor(log2(_VECTOR / (sqrt(3) * (rate + drift) + reach)))
        turn = min(s.turn for s in sets.values())
        fine = min(floor(log2(2**30.9 / (rate + drift + reach))), turn + 15, bias)
        if not 15 <= coarse < min(fine, 31) or field_bits > 15:
            got = f"half turns up to {rate:.3g} rad a step, fields of {field / counts.mag:.0f} counts"
            raise InputError("integer export", got=got, expected="about 0.01 to 0.9 rad, up to 4096 counts")
        return cls(counts, dt, round(counts.gyro * dt / 2 * 2.0**fine), fine, coarse, bias, field_bits, sets)

    @property
    def resolution(self) -> Mapping[str, float]:
        """What one unit in the last place is: of attitude [rad], of a correction [rad], of the bias [rad/s]."""
        turn = min(s.turn for s in self.sets.values())
        return {"attitude": 2.0**-15, "correction": 2.0 ** (1 - turn), "bias": 2.0**-self.bias * 2 / self.dt}


def _correcting(K: Array, mask: int, counts: Counts, limits: Mapping[str, float], dt: float) -> Correcting:
    rows = [i for i, (sensor, _) in enumerate(ROWS) if mask >> SENSORS.index(sensor) & 1]
    names = [ROWS[i][0] for i in rows]
    attitude, M = split_gain(K[:, rows])
    unit = attitude * np.array([getattr(counts, s) / 2 for s in names])  # half turn of a count
    ends = np.abs(unit) @ np.array([limits[s] * sqrt(3) for s in names])
    reach = float(np.linalg.norm(ends))
    scale = floor(log2(2**30 / float(ends.max())))
    gains = np.round(unit * 2.0 ** (scale - np.array([WIDTH[s] for s in names])))
    turn = min(floor(log2(_VECTOR / reach)), scale - 1)
    common, rest = min((_split(M * dt, i) for i in range(3)), key=lambda part: _products(part[1]))
    size = float(np.abs(rest).sum(axis=1).max())
    shared = floor(log2(_LEVEL / (abs(common) + float(np.linalg.norm(rest)))))
    whole = floor(log2(2**30 / (size * _VECTOR))) if size else 0
    down = whole - shared + CUT if size else 1
    if down < 1:
        raise InputError("integer export", got=f"a bias gain of {size:.3g} a step", expected="one below 0.1")
    return Correcting(
        tuple(rows), gains, scale - turn, turn, round(common * 2.0**shared), np.round(rest * 2.0**whole), down,
        turn + 15 - CUT + shared, reach,
    )  # fmt: skip


def _split(M: Array, i: int) -> tuple[float, Array]:
    """Return the i-th diagonal entry of a bias gain, and what is left of the gain without it on all axes."""
    rest = M - M[i, i] * np.eye(3)
    rest[np.abs(rest) < _SMALL * np.abs(M).max()] = 0.0
    return float(M[i, i]), rest


def _products(rest: Array) -> int:
    """Return how many products it takes to turn a vector by a matrix and that into body axes."""
    return int(np.count_nonzero(rest)) + 3 * int(np.count_nonzero(rest.any(axis=1)))
