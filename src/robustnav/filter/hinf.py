"""The H-infinity half of an update: a Kalman covariance enlarged where the bound asks for it, existence checked.

With the Kalman covariance Pf = (P^-1 + H' R^-1 H)^-1 after an update the filter of bound gamma keeps
P+ = (Pf^-1 - gamma^-2 L' L)^-1, the state as the Kalman filter moved it.  It exists exactly when gamma^2 I - L Pf L' is
positive definite (docs/alignment.md, section 2; Hassibi, Sayed, Kailath 1999, chapter 4).
"""

from __future__ import annotations

import numpy as np

from robustnav.frames import Array


def enlarge(P: Array, L: Array, gamma: float) -> tuple[Array, float]:
    """Return the enlarged covariance (n, n), and the margin of existence.

    Parameters
    ----------
    P : Kalman covariance after the update (n, n).
    L : what is bounded, rows (l, n) on the error.
    gamma : the bound.

    Returns
    -------
    P, margin : the margin is the smallest pivot of gamma^2 I - L P L' over gamma^2; not above zero, or NaN, where no
        such filter exists, and P is then the Kalman covariance as it was.
    """
    out, margin = P.copy(), np.inf
    for row in L:
        PH = out @ row
        d = gamma**2 - float(row @ PH)
        margin = d / gamma**2 if not d / gamma**2 >= margin else margin
        if not d > 0:
            return P, margin
        out = out + np.outer(PH, PH) / d
    return (out + out.T) / 2, margin
