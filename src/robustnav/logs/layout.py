"""Our own table: which column holds what, told by its name alone.

``t_s`` comes first.  A sensor's column is ``<stream>_<axis>_<unit>``: ``gyro_x_rad_s``, ``accel_z_m_s2``, ``mag_y_t``,
``range_0_m``.  A velocity measured from outside, by GNSS or at a mooring, is ``velocity_north_m_s``,
``velocity_east_m_s`` and, where known, ``velocity_down_m_s``; a receiver's on a carrier that moves are
``gnss_velocity_north_m_s`` .. and ``gnss_position_north_m`` .. about any origin.  Reference states are ``q_nb_w`` ..
``q_nb_z``, ``p_n_x_m`` .., ``v_n_x_m_s`` .. and ``moving`` (0 or 1); with ``estimate_`` before them they are a
recorder's own estimate.  All vectors are in body FRD or navigation NED.

Streams keep their own rates: a stream has a sample in the rows where one of its cells is filled.  An empty cell is
missing; ``nan`` marks a sample whose reading is missing.  Before the header may stand ``# robustnav table 1`` and one
line ``# {...}`` of JSON: origin_ns, conventions, skipped, info, frames by stream, and kind, north and accuracy of truth
and estimate, which a table with an attitude must have.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

TITLE = "# robustnav table 1"
TIME = "t_s"
MOVING = "moving"
UNITS = {"rad/s": "rad_s", "m/s^2": "m_s2", "T": "t", "m": "m", "m/s": "m_s", "rad": "rad", "Pa": "pa", "K": "k"}
SENSOR_UNITS = {
    "gyro": "rad/s",
    "accel": "m/s^2",
    "mag": "T",
    "velocity": "m/s",
    "gnss_velocity": "m/s",
    "gnss_position": "m",
}
SENSOR_FRAMES = dict.fromkeys(
    ("velocity", "gnss_velocity", "gnss_position"), "n"
)  # every other stream is in b unless the line of JSON says otherwise
NED = ("north", "east", "down")
ROLES = {"truth": "", "estimate": "estimate_"}  # role -> what stands before its columns
STATES = {
    "q_nb": ("q_nb_w", "q_nb_x", "q_nb_y", "q_nb_z"),
    "p_n": ("p_n_x_m", "p_n_y_m", "p_n_z_m"),
    "v_n": ("v_n_x_m_s", "v_n_y_m_s", "v_n_z_m_s"),
}
RESERVED = re.compile(r"(estimate_.*|p_n|v_n|q_nb|t|moving)")
_TOKENS = "|".join(sorted(UNITS.values(), key=len, reverse=True))
_NAME = re.compile(rf"([a-z][a-z0-9_]*?)_([xyz]|\d{{1,4}}|north|east|down)_({_TOKENS})")


@dataclass(frozen=True)
class Column:
    """What one sensor column holds: stream, axis number and SI unit."""

    stream: str
    axis: int
    unit: str


def parse_column(name: str) -> Column | None:
    """Return what a sensor column's name says, or None if it follows no rule of ours."""
    found = _NAME.fullmatch(name)
    if found is None or RESERVED.fullmatch(found[1]):
        return None
    unit = next(unit for unit, token in UNITS.items() if token == found[3])
    if (found[2] in NED) != (SENSOR_FRAMES.get(found[1]) == "n"):
        return None
    named = NED if found[2] in NED else tuple("xyz")
    return Column(found[1], named.index(found[2]) if found[2] in named else int(found[2]), unit)


def column_names(stream: str, unit: str, width: int) -> list[str]:
    """Return the names of a stream's columns: by its frame where that is known, axes x y z for three, else numbers."""
    axes: Sequence[str] = "xyz" if width == 3 else [str(k) for k in range(width)]
    if SENSOR_FRAMES.get(stream) == "n" and width <= len(NED):
        axes = NED[: max(width, 2)]  # a velocity has two horizontal parts at least
    return [f"{stream}_{axis}_{UNITS[unit]}" for axis in axes]


def state_columns(role: str) -> dict[str, tuple[str, ...]]:
    """Return the columns of each state of a role, ``truth`` or ``estimate``."""
    return {state: tuple(ROLES[role] + name for name in names) for state, names in STATES.items()}
