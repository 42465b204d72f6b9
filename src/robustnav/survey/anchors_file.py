"""Surveyed anchors into the TOML that ranging recordings are read with."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from robustnav.files import write_whole
from robustnav.records import Anchors


def write_anchors(anchors: Anchors, path: str | os.PathLike[str], notes: tuple[str, ...] = ()) -> Path:
    """Write anchors as TOML with z down, every coordinate bit for bit, and return the path.

    The file holds one sd for each anchor: the root mean square of the three.

    Parameters
    ----------
    anchors : positions in frame a.
    path : an existing file is replaced only by a complete one.
    notes : printable lines of comment at the head.

    Raises
    ------
    InputError : a path that cannot be written.
    """
    return write_whole(path, "\n".join(_lines(anchors, notes)) + "\n")


def _lines(anchors: Anchors, notes: tuple[str, ...]) -> Iterator[str]:
    yield from (f"# {note}" for note in notes)
    yield 'z = "down"'
    for k, name in enumerate(anchors.ids):
        yield "\n[[anchor]]"
        yield f"id = {json.dumps(name, ensure_ascii=False)}"
        yield from (f"{axis}_m = {float(x)!r}" for axis, x in zip("xyz", anchors.p_a[k], strict=True))
        if anchors.sd is not None:
            yield f"sd_m = {float(np.sqrt(np.mean(anchors.sd[k] ** 2)))!r}"
