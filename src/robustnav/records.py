"""What travels between the stages: sensor streams, logs, reference truth, estimates and scores.

Arrays only; pandas appears nowhere here.  All records are frozen and checked when they are made.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from robustnav.errors import InputError
from robustnav.ranging import Anchors as Anchors
from robustnav.ranging import RangeDifferences as RangeDifferences
from robustnav.ranging import Ranges as Ranges
from robustnav.streams import Array as Array
from robustnav.streams import BoolArray as BoolArray
from robustnav.streams import IntArray as IntArray
from robustnav.streams import Stream as Stream
from robustnav.streams import check_names as check_names
from robustnav.streams import check_time as check_time


@dataclass(frozen=True)
class Truth:
    """Reference states, or another estimator's states, with their own times.

    Parameters
    ----------
    t : (n,) seconds since the log's start.
    q_nb : (n, 4) attitude, Hamilton, w first, body FRD to NED; NaN rows where the reference is missing.
    kind : ``optical``, ``simulated`` ... for a reference; ``estimate`` for another estimator's output, which is
        never scored as truth without saying so.
    north : ``magnetic`` or ``true``: which north the attitude refers to.
    p_n, v_n : (n, 3) position [m] and velocity [m/s] in NED, or None.
    moving : (n,) which samples count in a metric over motion, or None.
    accuracy : one line on how good it is, for reports.
    """

    t: Array
    q_nb: Array | None = None
    kind: str = "simulated"
    north: str = "magnetic"
    p_n: Array | None = None
    v_n: Array | None = None
    moving: BoolArray | None = None
    accuracy: str = ""

    def __post_init__(self) -> None:
        check_time(self.t, "truth")
        for name, width in (("q_nb", 4), ("p_n", 3), ("v_n", 3)):
            value = getattr(self, name)
            if value is not None and value.shape != (len(self.t), width):
                raise InputError(
                    f"truth {name}", got=f"shape {value.shape}", expected=f"shape ({len(self.t)}, {width})"
                )


@dataclass(frozen=True)
class Log:
    """Named streams of one recording in SI units, body FRD.

    Parameters
    ----------
    streams : by sensor name; each has its own times.
    source : file name or what made it.
    conventions : what the source used and what was converted, one line each.
    origin_ns : the log's start on its own clock [ns].
    truth : reference attitude or position, or None.
    estimate : the recorder's own estimate (an autopilot's attitude); not a truth.
    skipped : what was left out and why, one line each.
    info : figures and settings worth showing: firmware, declination_deg, latitude_deg, longitude_deg, year ...
    """

    streams: Mapping[str, Stream]
    source: str
    conventions: tuple[str, ...] = ()
    origin_ns: int = 0
    truth: Truth | None = None
    estimate: Truth | None = None
    skipped: tuple[str, ...] = ()
    info: Mapping[str, str | float] = field(default_factory=dict)

    def stream(self, name: str) -> Stream:
        """Return a stream by name, or raise ``InputError`` listing those present."""
        try:
            return self.streams[name]
        except KeyError:
            raise InputError(
                f"no stream {name!r}",
                place=self.source,
                got=f"streams {', '.join(self.streams) or 'none'}",
                expected=f"a stream named {name!r}",
            ) from None

    def between(self, start: float, stop: float) -> Log:
        """Return the recording cut to ``start <= t <= stop`` [s]; the truth is kept whole."""
        cut = {name: stream.between(start, stop) for name, stream in self.streams.items()}
        return replace(self, streams=cut)


@dataclass(frozen=True)
class Innovations:
    """What one sensor's readings told a filter, before they were used.

    ``t`` (n,) s; ``z`` (n, m) measured minus predicted in the sensor's unit; ``s`` (n, m) their predicted variances,
    row after row as they were fused (NaN for constant-gain filters); ``nis`` (n,) = sum z^2 / s;
    ``weight`` (n,) what a reading counted for: 1 in full, 0 refused, NaN missing; ``margin`` (n,) of existence of an
    H-infinity filter, not above zero where it does not exist; NaN of other filters.
    """

    t: Array
    z: Array
    s: Array
    nis: Array
    weight: Array
    margin: Array | None = None

    @property
    def used(self) -> BoolArray:
        """Which readings (n,) moved the estimate."""
        used: BoolArray = self.weight > 0
        return used


@dataclass(frozen=True)
class Run:
    """What an estimator said on one recording.

    Parameters
    ----------
    estimator, model : their names.
    t : (n,) times of the inputs [s].
    state : state blocks by name, each (n, size); ``q_nb`` is Hamilton, w first.
    sd : standard deviations by block, each (n, error_size), rad for rotations.
    innovations : by sensor.
    events : restarts, gaps and missing samples, in words.
    settings : everything needed to repeat the run.
    """

    estimator: str
    model: str
    t: Array
    state: Mapping[str, Array]
    sd: Mapping[str, Array]
    innovations: Mapping[str, Innovations]
    events: tuple[str, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Score:
    """Numbers from a Run and a Truth: ``values`` by name (unit in the name), over ``samples`` samples."""

    estimator: str
    reference: str
    values: Mapping[str, float]
    samples: int
    notes: tuple[str, ...] = ()
