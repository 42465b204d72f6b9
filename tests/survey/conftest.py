"""Anchors that the tests share, and what is ranged to them."""

from itertools import combinations

import numpy as np
import pytest

from robustnav.survey import Links, TagRanges

HALL = np.array([[0, 0, 0], [8, 0, 0], [7, 6, 0], [1, 5, -2.5], [4, 3, -3], [0, 6, -0.5]], float)


def draw_links(p, sd, rng=None, *, pairs=None, faults=None):
    """Return ranges between anchors, all pairs or some, with noise from ``rng`` and ``faults`` {row: metres}."""
    a, b = np.array(pairs or list(combinations(range(len(p)), 2))).T
    d = np.linalg.norm(p[a] - p[b], axis=1)
    d = d if rng is None else d + sd * rng.standard_normal(len(d))
    for row, error in (faults or {}).items():
        d[row] += error
    return Links(a, b, d, np.full(len(d), sd))


def path_of_tag(t):
    """Return where the tag of the hall is (n, 3)."""
    return np.column_stack([4 + 3 * np.cos(0.5 * t), 3 + 2.5 * np.sin(0.7 * t), -1 + 0.7 * np.sin(0.3 * t)])


def draw_tag(p, sd, rng, *, seconds=12.0, every=0.25, apart=0.0):
    """Return ranges of a moving tag to all anchors in turn, ``apart`` seconds from one to the next."""
    stamps = np.arange(0.0, seconds, every)
    t = np.repeat(stamps, len(p)) + apart * np.tile(np.arange(len(p)), len(stamps))
    anchor = np.tile(np.arange(len(p)), len(stamps))
    d = np.linalg.norm(path_of_tag(t) - p[anchor], axis=1) + sd * rng.standard_normal(len(t))
    return TagRanges(t, anchor, d, np.full(len(t), sd))


@pytest.fixture(scope="session")
def hall():
    """Six anchors; the first three lay the frame as they stand."""
    return HALL


@pytest.fixture(scope="session")
def links():
    return draw_links


@pytest.fixture(scope="session")
def tag():
    return draw_tag


@pytest.fixture(scope="session")
def tag_path():
    return path_of_tag
