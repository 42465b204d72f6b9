"""Robust state estimators for small drones and inertial navigation.

>>> import robustnav as rn
>>> log = rn.logs.read("flight.ulg")                          # doctest: +SKIP
>>> run = rn.run_recorded("h2", log, rn.Sensors("mpu9250", "ak8963"))   # doctest: +SKIP
>>> rn.evaluate(run, log.estimate)                            # doctest: +SKIP

Heavy parts (SymPy, SciPy, matplotlib, cvxpy) load only when a function needs them.
"""

__version__ = "0.1.0"

from importlib import import_module
from typing import TYPE_CHECKING, Any

from robustnav import frames, model, models, units
from robustnav.errors import EstimatorError, InputError, MissingExtra, RobustnavError
from robustnav.evaluate import evaluate
from robustnav.export import export
from robustnav.filter.weighting import Gate, Huber, StudentT
from robustnav.model import Equations, Model, Noise, Rotation, Sensor, Symbols, Vector
from robustnav.records import Anchors, Innovations, Log, RangeDifferences, Ranges, Run, Score, Stream, Truth
from robustnav.report import report
from robustnav.run import EKF, H2, UKF, HInfinity, Start, batch, run, smooth, stream

if TYPE_CHECKING:
    from robustnav import alignment, calibrate, datasheet, doctor, logs, sim, snapshot, strapdown, survey
    from robustnav.run.acquisition import Acquisition
    from robustnav.run.inclination import LevelH2
    from robustnav.run.inertial import run_inertial
    from robustnav.run.inertial_start import InertialStart
    from robustnav.run.moving import align_moving
    from robustnav.run.moving_setting import GnssAiding, InertialUnit, MovingStart
    from robustnav.run.recorded import Sensors, estimator_for, run_recorded
    from robustnav.run.tracking import ranging_ekf, track

__all__ = [
    "EKF",
    "H2",
    "UKF",
    "Acquisition",
    "Anchors",
    "Equations",
    "EstimatorError",
    "Gate",
    "GnssAiding",
    "HInfinity",
    "Huber",
    "InertialStart",
    "InertialUnit",
    "Innovations",
    "InputError",
    "LevelH2",
    "Log",
    "MissingExtra",
    "Model",
    "MovingStart",
    "Noise",
    "RangeDifferences",
    "Ranges",
    "RobustnavError",
    "Rotation",
    "Run",
    "Score",
    "Sensor",
    "Sensors",
    "Start",
    "Stream",
    "StudentT",
    "Symbols",
    "Truth",
    "Vector",
    "align_moving",
    "alignment",
    "batch",
    "calibrate",
    "datasheet",
    "doctor",
    "estimator_for",
    "evaluate",
    "export",
    "frames",
    "logs",
    "model",
    "models",
    "ranging_ekf",
    "report",
    "run",
    "run_inertial",
    "run_recorded",
    "sim",
    "smooth",
    "snapshot",
    "strapdown",
    "stream",
    "survey",
    "track",
    "units",
]

# Not every program names these: a subpackage, or the module a name stands in, is loaded when it is first used.
_SUBPACKAGES = {"alignment", "calibrate", "datasheet", "doctor", "logs", "sim", "snapshot", "strapdown", "survey"}
_STANDS_IN = {
    "Acquisition": "run.acquisition",
    "GnssAiding": "run.moving_setting",
    "InertialStart": "run.inertial_start",
    "InertialUnit": "run.moving_setting",
    "LevelH2": "run.inclination",
    "MovingStart": "run.moving_setting",
    "Sensors": "run.recorded",
    "align_moving": "run.moving",
    "estimator_for": "run.recorded",
    "ranging_ekf": "run.tracking",
    "run_inertial": "run.inertial",
    "run_recorded": "run.recorded",
    "track": "run.tracking",
}


def __getattr__(name: str) -> Any:
    if name in _SUBPACKAGES:
        return import_module(f"robustnav.{name}")
    if name in _STANDS_IN:
        found = globals()[name] = getattr(import_module(f"robustnav.{_STANDS_IN[name]}"), name)
        return found
    raise AttributeError(f"module 'robustnav' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
