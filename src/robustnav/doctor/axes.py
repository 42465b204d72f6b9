"""The 48 ways to permute and negate three axes, their names, and which one explains a motion best."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from robustnav.records import Array


def signed_permutations() -> Array:
    """Return all signed permutation matrices (48, 3, 3), the identity first."""
    eye = np.eye(3)
    return np.array(
        [np.diag(signs) @ eye[list(p)] for p in permutations(range(3)) for signs in product((1, -1), repeat=3)]
    )


ALL_AXES: Array = signed_permutations()


def axes_name(M: Array) -> str:
    """Return the name of a signed permutation by rows: ``+x-y-z`` means (x, -y, -z) of the sensor."""
    columns = np.argmax(np.abs(M), axis=1)
    return "".join(("+" if row[k] > 0 else "-") + "xyz"[k] for row, k in zip(M, columns, strict=True))


@dataclass(frozen=True)
class AxisMatch:
    """Shares of a motion explained: by the axes as they are, by the best of the 48, by the best of the others."""

    share: float
    best: str
    best_share: float
    next_share: float

    @property
    def proper(self) -> bool:
        """Whether the best axes are a rotation of those given, not a mirror image."""
        signs = 1 if self.best.count("-") % 2 == 0 else -1
        order = "".join(c for c in self.best if c in "xyz")
        return signs * (1 if order in ("xyz", "yzx", "zxy") else -1) > 0


def match_axes(share_of: Callable[[Array], float]) -> AxisMatch:
    """Return the match of ``share_of``, the share explained under one signed permutation (3, 3)."""
    shares = np.array([share_of(M) for M in ALL_AXES])
    order = np.argsort(shares)[::-1]
    return AxisMatch(float(shares[0]), axes_name(ALL_AXES[order[0]]), float(shares[order[0]]), float(shares[order[1]]))
