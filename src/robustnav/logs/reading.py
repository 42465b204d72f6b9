"""``read``: the one door to every format; the content decides before the suffix does."""

from __future__ import annotations

import os
import re
from pathlib import Path

from robustnav.errors import InputError
from robustnav.logs.files import checked_path, unusable
from robustnav.records import Log

EXPECTED = "PX4 ULog (.ulg), BROAD (.mat), a table or an estimator replay table (.csv)"
ULOG_MAGIC = b"ULog\x01\x12\x35"
MATLAB_MAGIC = b"MATLAB "
_REPLAY = re.compile(rb"\s*\d+\s*,\s*[a-z_]+\s*,")  # a stamp, then the name of a sensor


def read(path: str | os.PathLike[str], mapping: str | os.PathLike[str] | None = None) -> Log:
    """Return the recording in ``path`` in SI units, body forward-right-down, each stream with its own times.

    Parameters
    ----------
    path : PX4 ULog, BROAD .mat, PX4-ECL replay table, or a table in the layout of ``write_table``.
    mapping : TOML file naming columns, units and frames of a foreign table (see ``logs.mapping``); only for tables.

    Raises
    ------
    InputError : the file is missing, empty, cut, damaged or of another kind, or a table has no mapping.
    """
    file = checked_path(path, EXPECTED)
    try:
        with file.open("rb") as handle:
            head = handle.read(256)
    except OSError as why:
        raise unusable(file, why.strerror or str(why), EXPECTED, do="check its permissions") from why
    kind = _kind(file, head)
    if mapping is not None and kind not in ("table", "replay"):
        raise InputError(
            "a mapping for a file that needs none",
            place=file.name,
            got=f"a mapping and a {kind} file",
            do="leave it out",
        )
    if mapping is not None:
        from robustnav.logs.foreign import read_foreign

        return read_foreign(file, checked_path(mapping, "a mapping in TOML"))
    return _read_kind(file, kind)


def _kind(file: Path, head: bytes) -> str:
    """Return the name of the format by content, then by suffix."""
    suffix = file.suffix.lower()
    if head.startswith(ULOG_MAGIC) or suffix == ".ulg":
        return "ULog"
    if head.startswith(MATLAB_MAGIC) or suffix == ".mat":
        return "MATLAB"
    if suffix in (".csv", ".txt", ".tsv"):
        return "replay" if _REPLAY.match(head) else "table"
    raise unusable(file, f"suffix {suffix!r} and unknown content", EXPECTED, do="convert it, or rename a table to .csv")


def _read_kind(file: Path, kind: str) -> Log:
    # Readers are imported when needed: pyulog and SciPy cost more than most files.
    if kind == "ULog":
        from robustnav.logs.px4 import read_px4

        return read_px4(file)
    if kind == "MATLAB":
        from robustnav.logs.broad import read_broad

        return read_broad(file)
    if kind == "replay":
        from robustnav.logs.replay import read_replay

        return read_replay(file)
    from robustnav.logs.table import read_table

    return read_table(file)
