"""A ULog file through pyulog, made safe: quiet, bounded, and with one error for all its ways to fail."""

from __future__ import annotations

import contextlib
import io
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from robustnav.logs.files import unusable

EXPECTED = "a PX4 ULog recording"


class _Endless(Exception):
    """pyulog reads the same damaged bytes again and again."""


class _Bounded:
    """A binary file that ends the search when far more is read than it holds, and knows whether it ended early.

    pyulog steps back after an unknown message; at the end of a file it can step back further than it came.
    """

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file = file
        self._calls_left, self._bytes_left = size + 1000, 8 * size + 1_000_000
        self.cut = False

    def read(self, size: int) -> bytes:
        data = self._file.read(size)
        self._calls_left -= 1
        self._bytes_left -= len(data)
        if self._calls_left < 0 or self._bytes_left < 0:
            raise _Endless
        self.cut = len(data) < size and not (size == 3 and not data)  # three bytes are a message header
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def close(self) -> None:
        """Leave closing to the owner."""


@dataclass(frozen=True)
class ULogFile:
    """What pyulog found: its ``ULog`` object, and what of the file it could not use, in words, or nothing."""

    log: Any
    incomplete: str


def load_ulog(path: Path) -> ULogFile:
    """Return the content of a ULog file.

    Raises
    ------
    InputError : no ULog file, or one pyulog cannot follow.
    """
    from pyulog import ULog
    from pyulog.exceptions import ULogException

    do = "copy the recording again, or repair it with the tools of PX4"
    try:
        with path.open("rb") as raw, contextlib.redirect_stdout(io.StringIO()):
            bounded = _Bounded(raw, path.stat().st_size)
            log = ULog(bounded)
    except _Endless as why:
        raise unusable(path, "damaged messages without end", EXPECTED, do=do) from why
    except ULogException as why:
        raise unusable(path, str(why), EXPECTED, place="header", do="check that this is a .ulg file") from why
    # pyulog catches these for most messages; what escapes comes from damaged definitions or from stepping back too far.
    except (OSError, ValueError, LookupError, TypeError, ArithmeticError, RecursionError, struct.error) as why:
        raise unusable(path, f"damaged definitions ({type(why).__name__}: {why})", EXPECTED, do=do) from why
    if log.file_corruption:
        return ULogFile(log, "damaged messages are left out, what they held is missing")
    return ULogFile(log, "the file ends inside a message, which is left out" if bounded.cut else "")
