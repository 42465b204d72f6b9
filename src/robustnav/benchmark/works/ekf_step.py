"""One step of an extended Kalman filter with its covariance: predict, then update with both sensors."""

from __future__ import annotations

from robustnav.benchmark.callbacks import few, filterpy_steps
from robustnav.benchmark.flight import WHAT, euler_model, quaternion_model
from robustnav.benchmark.ours import sample_by_sample, whole_array
from robustnav.benchmark.peer_filterpy import EulerEkf, EulerEkfJoint
from robustnav.benchmark.timing import Entry, Work
from robustnav.run import EKF

WORK = Work(
    "ekf-step",
    "a predict and an update with accelerometer and magnetometer; +call: one Python call a step",
    WHAT,
    {
        "ekf-euler": Entry(lambda n: whole_array(EKF(euler_model()), n)),
        "ekf-euler+call": Entry(lambda n: sample_by_sample(EKF(euler_model()), n)),
        "mekf": Entry(lambda n: whole_array(EKF(quaternion_model()), n)),
        "mekf+call": Entry(lambda n: sample_by_sample(EKF(quaternion_model()), n)),
        "filterpy-ekf-euler": Entry(lambda n: filterpy_steps(EulerEkf, n), needs="filterpy", baseline=True),
        "filterpy-ekf-euler-joint": Entry(lambda n: filterpy_steps(EulerEkfJoint, n), needs="filterpy", baseline=True),
        "numpy-ekf-euler": Entry(
            lambda n: sample_by_sample(EKF(euler_model()), few(n), backend="numpy"), needs="symengine", baseline=True
        ),
        "numpy-mekf": Entry(
            lambda n: sample_by_sample(EKF(quaternion_model()), few(n), backend="numpy"),
            needs="symengine",
            baseline=True,
        ),
    },
)
