"""Layouts that the tests share."""

from dataclasses import dataclass

import numpy as np
import pytest

from robustnav.snapshot import Height, Snapshot, solve_differences, solve_ranges


@dataclass(frozen=True)
class Scene:
    """Anchors, a tag, the sd of a range and what is measured."""

    anchors: np.ndarray
    tag: np.ndarray
    sd: float
    kind: str = "ranges"
    height_sd: float | None = None

    def measure(self, rng, fault=None) -> Snapshot:
        """Draw noise, add ``fault`` (k,) to the ranges and solve."""
        r = np.linalg.norm(self.anchors - self.tag, axis=1) + self.sd * rng.normal(size=len(self.anchors))
        r = r if fault is None else r + fault
        height = None
        if self.height_sd is not None:
            height = Height(float(self.tag[2] + self.height_sd * rng.normal()), self.height_sd)
        if self.kind == "differences":
            return solve_differences(self.anchors, r[1:] - r[0], self.sd, height)
        return solve_ranges(self.anchors, r, self.sd, height)


@pytest.fixture(scope="session")
def scene():
    return Scene


@pytest.fixture(scope="session")
def box():
    """Eight corners of a room of 10 x 8 x 3 m."""
    return np.array([[x, y, z] for x in (0.0, 10.0) for y in (0.0, 8.0) for z in (0.0, 3.0)])


@pytest.fixture(scope="session")
def ceiling():
    """Four anchors in one plane."""
    return np.array([[0.0, 0.0, 3.0], [10.0, 0.0, 3.0], [10.0, 8.0, 3.0], [0.0, 8.0, 3.0]])
