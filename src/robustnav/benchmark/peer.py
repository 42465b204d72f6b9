"""What a peer library is to the benchmarks: an attitude from nine axes, made a ``Run`` like our own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from types import ModuleType

from robustnav.benchmark.nine_axes import NineAxes, nine_axes
from robustnav.errors import MissingExtra
from robustnav.frames import Array
from robustnav.records import Log, Run


def load(module: str) -> ModuleType | None:
    """Return an optional module, or None where it is not installed or does not load."""
    try:
        return import_module(module)
    except ImportError:
        return None


def require(module: str) -> ModuleType:
    """Return an optional module.

    Raises
    ------
    MissingExtra : it is not installed.
    """
    found = load(module)
    if found is None:
        raise MissingExtra(module, "peers")
    return found


def version_of(module: str) -> str:
    """Return the installed version of a package, ``unknown`` where its metadata is missing."""
    try:
        return version(module)
    except PackageNotFoundError:
        return "unknown"


@dataclass(frozen=True)
class Peer:
    """An attitude estimator of another library.

    Parameters
    ----------
    name : as the user names it.
    module : what must be installed.
    attitude : from the loaded module and nine axes to ``q_nb`` (n, 4), body FRD to magnetic NED.
    settings : what was set, in words a reader can repeat.
    smoother : True where an estimate also uses later readings.
    """

    name: str
    module: str
    attitude: Callable[[ModuleType, NineAxes], Array]
    settings: Mapping[str, object] = field(default_factory=dict)
    smoother: bool = False

    def run(self, log: Log) -> Run:
        """Return the attitude over a log; sensors on other stamps than the gyro hold their latest reading.

        Raises
        ------
        MissingExtra : the library is not installed.
        InputError : as ``nine_axes``.
        """
        module, axes = require(self.module), nine_axes(log)
        settings = {"library": f"{self.module} {version_of(self.module)}", **self.settings, "north": "magnetic"}
        state = {"q_nb": self.attitude(module, axes)}
        return Run(self.name, self.module, axes.t, state, sd={}, innovations={}, settings=settings)
