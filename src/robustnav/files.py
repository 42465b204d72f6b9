"""Files that are either whole or not there."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from robustnav.errors import InputError


def write_whole(path: str | os.PathLike[str], text: str | Iterable[str]) -> Path:
    """Write text as UTF-8 beside ``path`` and rename it into place, so no reader ever meets half a file.

    Missing folders are made.  Returns the path.

    Raises
    ------
    InputError : the path is a folder, or cannot be written.
    """
    file = Path(path)
    if file.is_dir():
        raise InputError("cannot write a file", place=str(file), got="a folder", expected="a file name")
    beside: Path | None = None
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        descriptor, name = tempfile.mkstemp(prefix=f".{file.name}.", suffix=".part", dir=file.parent)
        beside = Path(name)
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="\n") as out:
            out.writelines([text] if isinstance(text, str) else text)
        beside.chmod(0o644)  # mkstemp lets only the owner read
        beside.replace(file)
    except OSError as why:
        got = why.strerror or str(why)
        raise InputError("cannot write a file", place=str(file), got=got, expected="a folder to write in") from why
    finally:
        if beside is not None:
            beside.unlink(missing_ok=True)
    return file
