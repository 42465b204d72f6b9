"""A live sensor: one call from Python a nine-axis sample, the loop included, the estimate left inside."""

from __future__ import annotations

from robustnav.benchmark import peer_imufusion, peer_vqf
from robustnav.benchmark.flight import DT, RATE_HZ, WHAT, flight, quaternion_model, rows
from robustnav.benchmark.ours import STREAM_SHARE, attitude_fault, sample_by_sample
from robustnav.benchmark.peer import require
from robustnav.benchmark.timing import Contender, Entry, Work
from robustnav.frames import quat_ned_frd_from_enu_flu, quat_normalize
from robustnav.run import EKF, H2


def _samples(n: int) -> int:
    return max(n // STREAM_SHARE, 2)


def _vqf(samples: int) -> Contender:
    vqf = require("vqf")
    axes, true_q_nb = flight(_samples(samples))
    filter_, inputs = vqf.VQF(DT), rows(*peer_vqf.in_its_axes(axes))
    update, fault = filter_.update, attitude_fault(true_q_nb[-1])

    def work() -> None:
        filter_.resetState()
        for gyro, accel, mag in inputs:
            update(gyro, accel, mag)

    return Contender(work, len(inputs), lambda _: fault(quat_ned_frd_from_enu_flu(filter_.getQuat9D())))


def _imufusion(samples: int) -> Contender:
    axes, true_q_nb = flight(_samples(samples))
    ahrs, inputs = peer_imufusion.ahrs(require("imufusion"), RATE_HZ), rows(*peer_imufusion.in_its_units(axes))
    update, fault = ahrs.update, attitude_fault(true_q_nb[-1])

    def work() -> None:
        ahrs.restart()
        for gyro, accel, mag in inputs:
            update(gyro, accel, mag)

    return Contender(work, len(inputs), lambda _: fault(quat_normalize(ahrs.get_quaternion())))


WORK = Work(
    "attitude-call",
    "a call of update() from Python with a nine-axis sample, the loop included",
    WHAT,
    {
        "h2": Entry(lambda n: sample_by_sample(H2(quaternion_model(), RATE_HZ), _samples(n))),
        "mekf": Entry(lambda n: sample_by_sample(EKF(quaternion_model()), _samples(n))),
        "vqf": Entry(_vqf, needs="vqf", baseline=True),
        "imufusion": Entry(_imufusion, needs="imufusion", baseline=True),
    },
)
