"""Pre-integration: many inertial samples become one rotation and one velocity increment, with bias Jacobians.

Of each sample: rotation vector with a coning correction, velocity with rotation and sculling corrections, both from
this sample and the two before it.  P. G. Savage, "Strapdown Inertial Navigation Integration Algorithm Design", parts 1
and 2, J. Guidance, Control and Dynamics 21(1-2), 1998; the coefficients are derived in docs/strapdown.md, section 1.
"""

from __future__ import annotations

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array, matrix_from_quat, quat_from_rotvec, quat_multiply, skew
from robustnav.strapdown.increments import ImuSamples, Increments


def preintegrate(samples: ImuSamples, every: int, history: Array | None = None) -> Increments:
    """Integrate samples over intervals.

    Parameters
    ----------
    samples : n of them.
    every : samples an interval; must divide n.
    history : (2, 6) angle [rad] and velocity [m/s] of the two samples before the first, the older one first; None where
        the recording begins.

    Raises
    ------
    InputError : ``every`` does not divide the number of samples, or ``history`` is not of that shape and finite.
    """
    angle, velocity = (
        _intervals(a, every) for a in corrected_samples(samples, checked_history(samples, every, history))
    )
    n, dt = len(angle), samples.dt
    q, v = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)), np.zeros((n, 3))
    J, H, C = np.zeros((n, 3, 3)), np.zeros((n, 3, 3)), np.tile(np.eye(3), (n, 1, 1))
    for k in range(every):
        step = np.einsum("nij,nj->ni", C, velocity[:, k])
        # The bias has turned the axes by J and half a sample more, and acts on the sample itself: hence half steps.
        J += C * (dt / 2)
        H -= skew(step) @ J
        v += step
        q = quat_multiply(q, quat_from_rotvec(angle[:, k]))
        C = matrix_from_quat(q)
        J += C * (dt / 2)
    return Increments.of(q, v, (J, H), dt * every)


def corrected_samples(samples: ImuSamples, history: Array) -> tuple[Array, Array]:
    """Return the rotation vector (n, 3) [rad] of each sample, and its velocity (n, 3) [m/s] in axes of its start.

    Rate and specific force are taken as parabolas through a sample and the two before it.
    """
    angle, velocity = samples.angle, samples.velocity
    past = np.concatenate([history, np.hstack([angle, velocity])])
    slope = (4 * past[1:-1] - past[:-2]) / 24
    rotation = angle + np.cross(slope[:, :3], angle)
    turned = np.cross(angle, velocity)
    sculling = np.cross(slope[:, :3], velocity) + np.cross(slope[:, 3:], angle)
    return rotation, velocity + turned / 2 + np.cross(angle, turned) / 6 + sculling


def checked_history(samples: ImuSamples, every: int, history: Array | None) -> Array:
    """Return the two samples before the first (2, 6); arguments and errors as for ``preintegrate``."""
    if every < 1 or len(samples) % every:
        raise InputError(
            "samples an interval",
            got=f"{every} for {len(samples)} samples",
            expected="a whole number that divides the number of samples",
            do="leave the last samples for the next call",
        )
    given = samples.history() if history is None else np.array(history, float)
    if given.shape != (2, 6) or not np.isfinite(given).all():
        raise InputError("the samples before the first", got=str(given), expected="finite numbers, shape (2, 6)")
    return given


def _intervals(values: Array, every: int) -> Array:
    return values.reshape(-1, every, 3)
