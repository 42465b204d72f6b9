"""Absolute trajectory error: a path laid on the reference by the best rotation and shift, never by a scale.

B. Horn, Closed-form solution of absolute orientation using unit quaternions, JOSA A 4(4), 1987; S. Umeyama,
Least-squares estimation of transformation parameters between two point patterns, IEEE PAMI 13(4), 1991, section III.
An alignment hides every constant offset of place and direction: such an error flatters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.position import position_at
from robustnav.frames import quat_from_matrix, rotvec_from_quat
from robustnav.records import Array, Stream

Turn = Literal["full", "yaw"]
SKIP = 3.0  # s after the reference's first stamp
LINE = 1e-9  # spread across a path over spread along it, both squared, below which a rotation is not determined


@dataclass(frozen=True)
class Alignment:
    """From the axes of a path to those of the reference: ``p_ref = C_ra p_a + shift``, all in metres."""

    C_ra: Array
    shift: Array

    def apply(self, p_a: Array) -> Array:
        """Return positions (n, 3) in the reference's axes."""
        out: Array = p_a @ self.C_ra.T + self.shift
        return out

    @property
    def angle(self) -> float:
        """Angle of the rotation [rad]."""
        return float(np.linalg.norm(rotvec_from_quat(quat_from_matrix(self.C_ra))))


@dataclass(frozen=True)
class AlignedErrors:
    """Errors (n, 3) [m] in the axes of the reference at ``t`` (n,) [s], and the alignment they come from.

    "2D" is what the reference's first two axes say: horizontal only where its third one is vertical.
    """

    t: Array
    errors: Array
    alignment: Alignment


def align(p_a: Array, p_ref: Array, turn: Turn = "full") -> Alignment:
    """Return the rotation and shift that lay positions on a reference in the least-squares sense.

    Parameters
    ----------
    p_a, p_ref : (n, 3) positions [m], row by row of one instant.
    turn : ``full``: any rotation, three points or more that are on no line; ``yaw``: about the third axis, which both
        frames must have vertical.

    Raises
    ------
    InputError : another shape, numbers that are not finite, or a path that does not determine the rotation.
    """
    good = p_a.shape == p_ref.shape and p_a.ndim == 2 and p_a.shape[1] == 3 and np.isfinite(p_a + p_ref).all()
    if not good or not len(p_a):
        got = f"shapes {p_a.shape} and {p_ref.shape}, or NaN"
        raise InputError("paths to align", got=got, expected="the same shape (n, 3), finite")
    if turn not in ("full", "yaw"):
        raise InputError("alignment", got=repr(turn), expected="full or yaw")
    centre_a, centre = p_a.mean(axis=0), p_ref.mean(axis=0)
    cross = (p_ref - centre).T @ (p_a - centre_a)
    C = _full(cross) if turn == "full" else _yaw(cross)
    return Alignment(C, centre - C @ centre_a)


def aligned_errors(path: Stream, reference: Stream, *, turn: Turn = "full", skip: float = SKIP) -> AlignedErrors:
    """Return the errors of a path after alignment to the reference, at the path's stamps.

    Stamps without a reference, or within ``skip`` seconds of the reference's first one, do not count.

    Raises
    ------
    InputError : no common time, a NaN in the path, or as ``align``.
    """
    reference_p = position_at(reference.t, reference.values, path.t)
    keep = np.isfinite(reference_p).all(axis=1) & (path.t >= reference.t[0] + skip)
    if not keep.any():
        raise InputError(
            f"nothing to align of {path.name!r}",
            got=f"{len(path)} stamps, none with a reference {skip:g} s after its start",
            expected="stamps on the clock of the reference",
        )
    found = align(path.values[keep], reference_p[keep], turn)
    return AlignedErrors(path.t[keep], found.apply(path.values[keep]) - reference_p[keep], found)


def _full(cross: Array) -> Array:
    U, s, Vt = np.linalg.svd(cross)
    if not s[1] > LINE * s[0]:
        raise InputError("alignment", got="points on a line", expected="a path that turns", do="align by yaw or not")
    # A mirror image would fit a planar path as well: only proper rotations are taken.
    sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    out: Array = U @ np.diag([1.0, 1.0, sign]) @ Vt
    return out


def _yaw(cross: Array) -> Array:
    along, across = cross[0, 0] + cross[1, 1], cross[1, 0] - cross[0, 1]
    size = np.hypot(along, across)
    if not size > LINE * np.abs(cross).max():
        raise InputError("alignment by yaw", got="no horizontal extent", expected="a path that moves level")
    c, s = along / size, across / size
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
