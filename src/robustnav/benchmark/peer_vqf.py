"""The library vqf (D. Laidig, T. Seel, "VQF", Information Fusion 91, 2023): online, retuned and offline.

It returns the attitude to east-north-up of whatever axes it is given.  It gets forward-left-up: with an axis that
points down it starts at the one attitude where its levelling rotation has no direction.
"""

from __future__ import annotations

from types import ModuleType

from robustnav.benchmark.nine_axes import NineAxes
from robustnav.benchmark.peer import Peer
from robustnav.frames import Array, frd_from_flu, quat_ned_frd_from_enu_flu

TUNED_TAU_MAG = 20.0  # s; the best of eleven settings on thirty trials of BROAD, the default being 9 s


def in_its_axes(axes: NineAxes) -> tuple[Array, Array, Array]:
    """Return gyro [rad/s], specific force [m/s^2] and field [T] in forward-left-up, each (n, 3)."""
    return frd_from_flu(axes.gyro), frd_from_flu(axes.accel), frd_from_flu(axes.mag)


def _online(vqf: ModuleType, axes: NineAxes) -> Array:
    found = vqf.VQF(1.0 / axes.rate_hz).updateBatch(*in_its_axes(axes))
    return quat_ned_frd_from_enu_flu(found["quat9D"])


def _tuned(vqf: ModuleType, axes: NineAxes) -> Array:
    found = vqf.VQF(1.0 / axes.rate_hz, tauMag=TUNED_TAU_MAG).updateBatch(*in_its_axes(axes))
    return quat_ned_frd_from_enu_flu(found["quat9D"])


def _offline(vqf: ModuleType, axes: NineAxes) -> Array:
    found = vqf.offlineVQF(*in_its_axes(axes), 1.0 / axes.rate_hz)
    return quat_ned_frd_from_enu_flu(found["quat9D"])


PEERS = (
    Peer("vqf", "vqf", _online, {"settings": "defaults"}),
    Peer("vqf-tuned", "vqf", _tuned, {"settings": "defaults", "tauMag [s]": TUNED_TAU_MAG}),
    Peer("offline-vqf", "vqf", _offline, {"settings": "defaults"}, smoother=True),
)
