"""A study's folder: its page and its numbers, written whole."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from robustnav.errors import InputError
from robustnav.evaluate.tables import plain
from robustnav.files import write_whole
from robustnav.report.page import Page


def write_results(folder: str | Path, results: Mapping[str, object], page: Page) -> Path:
    """Write ``results.json`` and ``report.html`` into a folder and return the page's path.

    Raises
    ------
    InputError : the folder is a file, or a result has no plain form.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError("output folder", place=str(folder), got="a file", expected="a folder, or a name that is free")
    text = json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    html = page.html()
    write_whole(folder / "results.json", text)
    write_whole(folder / "report.html", html)
    return folder / "report.html"
