"""What every reader does with a path, and says about a file it cannot use."""

from __future__ import annotations

import os
from pathlib import Path

from robustnav.errors import InputError


def unusable(path: Path, got: str, expected: str, *, place: str = "", do: str = "") -> InputError:
    """Return the error for a file that cannot be used; ``place`` is the topic, column, row or byte in it."""
    where = f"{path.name}, {place}" if place else path.name
    return InputError("cannot use this file", place=where, got=got, expected=expected, do=do)


def checked_path(path: str | os.PathLike[str], expected: str) -> Path:
    """Return ``path`` if it is a file with something in it; raise ``InputError`` otherwise."""
    file = Path(path)
    try:
        empty = file.stat().st_size == 0
        found = file.is_file()
    except (OSError, ValueError) as why:  # ValueError: a path with a zero byte
        reason = getattr(why, "strerror", None) or str(why)
        raise unusable(file, reason, expected, do="check the path") from why
    if not found:
        raise unusable(file, "not a regular file", expected, do="give one file, not a folder")
    if empty:
        raise unusable(file, "an empty file", expected, do="copy the recording again")
    return file


def read_text(path: Path, expected: str) -> str:
    """Return a text file's content, UTF-8 with or without a mark; raise ``InputError`` for anything else."""
    try:
        data = path.read_bytes()
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as why:
        got = f"byte 0x{data[why.start]:02x} that is no UTF-8 text"
        raise unusable(path, got, expected, place=f"byte {why.start}", do="convert it to UTF-8 text") from why
    except OSError as why:
        raise unusable(path, why.strerror or str(why), expected, do="check the path and its permissions") from why
