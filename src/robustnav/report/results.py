"""The folder of a run or a study: page, numbers and tables, written whole."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from robustnav import __version__
from robustnav.errors import InputError
from robustnav.evaluate.tables import plain
from robustnav.files import write_whole
from robustnav.report.page import Page


def write_results(
    folder: str | Path, results: Mapping[str, object], page: Page, tables: Mapping[str, str] | None = None
) -> Path:
    """Write ``results.json``, ``report.html`` and ``tables`` by file name into a folder and return the page's path.

    All texts are made before one is written: a failure leaves no half report.

    Raises
    ------
    InputError : the folder is a file, or a result has no plain form.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError("output folder", place=str(folder), got="a file", expected="a folder, or a name that is free")
    text = json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    texts = {**(tables or {}), "results.json": text, "report.html": page.html()}
    for name, whole in texts.items():
        write_whole(folder / name, whole)
    return folder / "report.html"


def versions() -> dict[str, str]:
    """Return the versions of what made a result."""
    found = {name: version(name) for name in ("numpy", "scipy", "matplotlib")}
    return {"robustnav": __version__, "python": platform.python_version(), **found}
