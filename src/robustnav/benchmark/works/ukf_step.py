"""One step of an unscented Kalman filter: predict, then update with both sensors."""

from __future__ import annotations

from robustnav.benchmark.callbacks import few, filterpy_steps
from robustnav.benchmark.flight import WHAT, euler_model, quaternion_model
from robustnav.benchmark.ours import sample_by_sample, whole_array
from robustnav.benchmark.peer_filterpy import EulerUkf
from robustnav.benchmark.timing import Entry, Work
from robustnav.run import UKF

WORK = Work(
    "ukf-step",
    "a predict and an update with accelerometer and magnetometer, thirteen points",
    WHAT,
    {
        "ukf": Entry(lambda n: whole_array(UKF(quaternion_model()), n)),
        "ukf-euler": Entry(lambda n: whole_array(UKF(euler_model()), n)),
        "filterpy-ukf-euler": Entry(lambda n: filterpy_steps(EulerUkf, n), needs="filterpy", baseline=True),
        "numpy-ukf": Entry(
            lambda n: sample_by_sample(UKF(quaternion_model()), few(n), backend="numpy"),
            needs="symengine",
            baseline=True,
        ),
    },
)
