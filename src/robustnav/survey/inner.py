"""Standard deviations of a shape, whichever anchors happen to lay its frame.

W. Baarda, "S-transformations and criterion matrices", Netherlands Geodetic Commission (1973).
"""

from __future__ import annotations

import numpy as np

from robustnav.records import Array


def inner_covariance(p: Array, covariance: Array, level: bool) -> Array:
    """Return the covariance (3k, 3k) of positions ``p`` (k, 3) once shifts and turns of the whole are taken out.

    ``level``: heights are known, so only shifts in x and y and turns about z are free.
    """
    axes = np.eye(3)[:2] if level else np.eye(3)
    turns = np.eye(3)[2:] if level else np.eye(3)
    off = p - p.mean(axis=0)
    moves = [np.tile(axis, len(p)) for axis in axes] + [np.cross(axis, off).ravel() for axis in turns]
    basis, sizes, _ = np.linalg.svd(np.stack(moves, axis=1), full_matrices=False)
    basis = basis[:, sizes > 1e-9 * sizes[0]]  # anchors in a row do not turn about themselves
    project = np.eye(p.size) - basis @ basis.T
    return np.asarray(project @ covariance @ project.T, float)
