"""What the structure of a model alone tells: where a gain can be non-zero, which errors a step or a reading touches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robustnav.model.blocks import Model
from robustnav.model.derive import Derivation, Exprs, Rows

BoolMatrix = NDArray[np.bool_]


def gain_pattern(derivation: Derivation, H: list[Rows]) -> BoolMatrix:
    """Return (ne, rows) True where a gain designed at the nominal point can be non-zero.

    Zeros follow from the structure alone: the covariance pattern that prediction and update cannot leave.  Only a
    model whose error is kept in navigation axes has one gain for every attitude; other models get a full pattern.
    """
    n, rows = derivation.model.error_size, [row for part in H for row in part]
    rotation = derivation.model.rotation
    if rotation is None or rotation.error != "n" or derivation.steps:
        return np.ones((n, len(rows)), bool)
    values = [*derivation.model.nominal_state(), *derivation.model.nominal_input()]
    at = dict(zip([*derivation.x, *derivation.u], values, strict=True))
    A, G = derivation.error_rate()
    F = _nonzero(A, at) | np.eye(n, dtype=bool)
    Q = _nonzero(G, at)
    Hs = _nonzero(rows, at)
    P = _product(Q, Q.T) | np.eye(n, dtype=bool)
    while True:
        gain = _product(P, Hs.T)
        new = P | _product(_product(F, P), F.T) | _joined(gain)
        if (new == P).all():
            return gain
        P = new


def errors_seen(derivation: Derivation, sensor: str) -> int:
    """Return how many leading errors a reading depends on."""
    H = derivation.on_error(derivation.h[sensor])
    return max((j + 1 for row in H for j, e in enumerate(row) if e != 0), default=0)


def errors_moved(model: Model, x: Exprs, stepped: Exprs) -> int:
    """Return how many leading errors a step changes that takes the state from ``x`` to ``stepped``."""
    moved = 0
    for block in model.state:
        part = model.state_slices[block.name]
        if stepped[part] != x[part]:
            moved = model.error_slices[block.name].stop
    return moved


def _nonzero(rows: Rows, at: dict[object, float]) -> BoolMatrix:
    import symengine as se

    values = [[se.sympify(e).subs(at) for e in row] for row in rows]
    return np.array([[not (e.is_Number and float(e) == 0.0) for e in row] for row in values], bool)


def _product(a: BoolMatrix, b: BoolMatrix) -> BoolMatrix:
    out: BoolMatrix = (a.astype(int) @ b.astype(int)) > 0
    return out


def _joined(gain: BoolMatrix) -> BoolMatrix:
    """Each scalar row ties together the errors it corrects."""
    out = np.zeros((len(gain), len(gain)), bool)
    for column in gain.T:
        out |= np.outer(column, column)
    return out
