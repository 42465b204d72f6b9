"""A run's states and standard deviations as a table, unit in every column name."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustnav.files import write_whole
from robustnav.records import Run

_AXES = {"q_nb": ("w", "x", "y", "z"), "euler": ("roll_rad", "pitch_rad", "yaw_rad")}


def write_run(run: Run, path: Path) -> Path:
    """Write ``t_s``, every state block and every standard deviation, one row an input time, and return the path.

    Columns: ``q_nb_w`` ... (Hamilton, body FRD to NED), other blocks by axis, and ``<block>_sd_<axis>`` in the
    block's unit (rad for attitudes, about the axes of the model's error).  Numbers repeat exactly when read.
    """
    names, columns = ["t_s"], [run.t[:, None]]
    for name, values in run.state.items():
        axes = _AXES.get(name, ("x", "y", "z") if values.shape[1] == 3 else tuple(map(str, range(values.shape[1]))))
        names += [f"{name}_{axis}" for axis in axes]
        columns.append(values)
    for name, values in run.sd.items():
        axes = ("x", "y", "z") if values.shape[1] == 3 else tuple(map(str, range(values.shape[1])))
        names += [f"{name}_sd_{axis}" for axis in axes]
        columns.append(values)
    lines = (",".join("" if np.isnan(v) else repr(float(v)) for v in row) for row in np.hstack(columns))
    write_whole(path, ",".join(names) + "\n" + "\n".join(lines) + "\n")
    return path
