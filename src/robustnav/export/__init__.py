"""A self-contained C99 tree from a model and a filter, for firmware: ``export(estimator, "firmware/ahrs")``."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robustnav.export.build import Exportable
    from robustnav.export.scaling import Counts
    from robustnav.export.tree import Exported

__all__ = ["export"]


def export(
    estimator: Exportable,
    out: str | os.PathLike[str],
    *,
    name: str | None = None,
    real: str = "float",
    rate_hz: float | None = None,
    counts: Counts | None = None,
    measure: bool = True,
) -> Exported:
    """Write a filter as C99: sources, test vectors recorded from the Python filter, host programs, CMake, README.

    Parameters
    ----------
    estimator : ``H2`` on ``models.attitude``, ``LevelH2`` on ``models.inclination``, or ``EKF`` on any model.
    out : folder to write to; made if missing, files of these names replaced.
    name : prefix of every symbol; None: ``rn_<model>_<filter>``.
    real : ``float``, ``double``, or ``int32`` for the constant gain on raw counts.
    rate_hz : rate of the inputs [Hz]; None: the estimator's own, else 100.
    counts : of the sensors, for ``int32``; None: an MPU-9250's.
    measure : state the cost in the README where the cross compiler and the emulator are installed.

    Returns
    -------
    Exported : folder, name, files and measured cost.

    Raises
    ------
    InputError : no C form of this estimator in this type, an unusable name or rate, or a folder that is a file.
    MissingExtra : SymPy or symengine is not installed, for a covariance filter.
    """
    from robustnav.export.whole import export_tree

    return export_tree(estimator, out, name=name, real=real, rate_hz=rate_hz, counts=counts, measure=measure)
