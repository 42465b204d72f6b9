"""What the readers of ranging recordings return, and the steps they share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array, IntArray, Log, Ranges, Stream

NANO = 1e-9  # s


@dataclass(frozen=True)
class RangeRecording:
    """Ranges of one recording, with what else was recorded beside them.

    Parameters
    ----------
    ranges : as reported; ``calibrate`` corrects them.
    log : other sensors in SI units and body FRD, source, conventions, start, and what was left out.
    reference : where the tag's carrier was and how it stood, as ``position`` (n, 3) [m] and, where there is one,
        ``attitude`` (n, 4) as ``q_ab`` or ``course`` (n, 1) [rad].  The stream says its frame: ``a`` for the anchors',
        another word for axes of its own that must be aligned before anything is scored.
    estimates : positions (n, 3) [m] in frame a by other estimators, by name; no truth.

    Stamps count from ``log.origin_ns`` in whole nanoseconds: ``origin_ns + round(t * 1e9)`` is the source's stamp.
    """

    ranges: Ranges
    log: Log
    reference: Mapping[str, Stream] = field(default_factory=dict)
    estimates: Mapping[str, Stream] = field(default_factory=dict)

    def log_with(self, ranges: Ranges, name: str = "range") -> Log:
        """Return the log with ``ranges`` (n) beside its streams as the readings (n, 4) of the sensor ``name``.

        Raises
        ------
        InputError : the log already has a stream of this name.
        """
        if name in self.log.streams:
            raise InputError(f"stream {name!r}", place=self.log.source, got="one already", expected="another name")
        return replace(self.log, streams={**self.log.streams, name: ranges.stream(name)})


@dataclass(frozen=True)
class StaticRanges:
    """Ranges between points that do not move, with their true distances: what a calibration is fitted to.

    Parameters
    ----------
    t : (n,) seconds since ``origin_ns``, in order within a file.
    distance_true, measured : (n,) m.
    anchor : (n,) id of the anchor.
    file : (n,) index into ``files``.
    files : names of the files that hold ranges.
    rssi_dbm, rssi_first_path_dbm : (n,) received and first-path power [dBm]; NaN where the receiver gave none.
    skipped : what was left out and why, one line each.
    """

    t: Array
    distance_true: Array
    measured: Array
    anchor: tuple[str, ...]
    file: IntArray
    files: tuple[str, ...]
    rssi_dbm: Array
    rssi_first_path_dbm: Array
    origin_ns: int
    skipped: tuple[str, ...] = ()


def seconds(stamps_ns: Sequence[int] | IntArray, origin_ns: int) -> Array:
    """Return stamps [ns] as seconds since ``origin_ns``, subtracted as integers."""
    return np.asarray((np.asarray(stamps_ns, np.int64) - origin_ns) * NANO, float)
