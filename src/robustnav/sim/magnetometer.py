"""What an ideal magnetometer would read along a motion."""

from __future__ import annotations

from robustnav.errors import InputError
from robustnav.frames import Array, quat_conjugate, rotate
from robustnav.sim.trajectory import Motion


def every(motion: Motion, rate_hz: float) -> int:
    """Return how many samples of ``motion`` make one of a magnetometer at ``rate_hz`` [Hz].

    Raises
    ------
    InputError : the motion's rate is not a whole multiple.
    """
    stride = round(motion.rate_hz / rate_hz) if rate_hz > 0 else 0
    if stride < 1 or abs(stride * rate_hz - motion.rate_hz) > 1e-6 * motion.rate_hz:
        raise InputError(
            "magnetometer rate",
            got=f"{rate_hz} Hz",
            expected=f"{motion.rate_hz:g} Hz divided by a whole number",
        )
    return stride


def true_field(q_nb: Array, field_n: Array) -> Array:
    """Return the field ``C_bn field_n`` (n, 3) [T] of attitudes (n, 4) and the local field (3,) [T]."""
    return rotate(quat_conjugate(q_nb), field_n)
