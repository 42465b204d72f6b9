"""Whole recordings: arrays of nine axes in, an array of attitudes out, in one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from robustnav.benchmark.flight import DT, RATE_HZ, WHAT, euler_model, flight, quaternion_model
from robustnav.benchmark.ours import attitude_fault, whole_array
from robustnav.benchmark.peer import require
from robustnav.benchmark.peer_vqf import in_its_axes
from robustnav.benchmark.timing import Contender, Entry, Work
from robustnav.frames import Array, quat_ned_frd_from_enu_flu
from robustnav.run import EKF, H2

Batch = Callable[..., Mapping[str, Any]]


def _peer(run: Callable[[Any], Batch]) -> Entry:
    """Return a row of the library vqf; ``run`` makes, from the module, what is called with the three arrays."""

    def make(samples: int) -> Contender:
        axes, true_q_nb = flight(samples)
        called, fault = run(require("vqf")), attitude_fault(true_q_nb[-1])
        gyro, accel, mag = in_its_axes(axes)
        return Contender(
            lambda: called(gyro, accel, mag), samples, lambda out: fault(quat_ned_frd_from_enu_flu(out["quat9D"][-1]))
        )

    return Entry(make, needs="vqf", baseline=True)


def _online(filter_: Any) -> Batch:
    def called(gyro: Array, accel: Array, mag: Array) -> Mapping[str, Any]:
        filter_.resetState()
        out: Mapping[str, Any] = filter_.updateBatch(gyro, accel, mag)
        return out

    return called


WORK = Work(
    "attitude-batch",
    "a nine-axis sample, whole arrays in double",
    WHAT,
    {
        "h2": Entry(lambda n: whole_array(H2(quaternion_model(), RATE_HZ), n)),
        "mekf": Entry(lambda n: whole_array(EKF(quaternion_model()), n)),
        "mekf+covariance": Entry(lambda n: whole_array(EKF(quaternion_model()), n, outputs=True)),
        "h2-euler": Entry(lambda n: whole_array(H2(euler_model(), RATE_HZ, start_sd="steady"), n)),
        "ekf-euler": Entry(lambda n: whole_array(EKF(euler_model()), n)),
        "vqf": _peer(lambda vqf: _online(vqf.VQF(DT))),
        "basic-vqf": _peer(lambda vqf: _online(vqf.BasicVQF(DT))),
        "offline-vqf": _peer(lambda vqf: lambda *sensors: vqf.offlineVQF(*sensors, DT)),
    },
)
