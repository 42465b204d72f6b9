"""What stays the same while filters follow a recording."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import SensorSeen
from robustnav.frames import Array
from robustnav.records import Log, Stream
from robustnav.run.estimators import EKF, UKF
from robustnav.run.feed import Feed


@dataclass(frozen=True)
class Task:
    """An estimator, a recording and what it feeds to the filter.

    ``news``, by the sensors that judge between filters, is what share of each reading is news; ``backend`` is what
    runs.
    """

    estimator: EKF | UKF
    log: Log
    feed: Feed
    news: dict[int, Array]
    backend: str

    def nothing_said(self) -> list[SensorSeen | None]:
        """Return room for what each sensor's readings say."""
        model = self.estimator.model
        rows = [s.size for s in model.sensors] if self.estimator.name == "ukf" else functions_of(model).rows
        return [SensorSeen.empty(len(d.t), m) if d else None for d, m in zip(self.feed.sensors, rows, strict=True)]

    def with_silent(self) -> Log:
        """Return the log with an empty stream for each sensor it does not have, where none of them is owed."""
        sensors = self.estimator.model.sensors
        none = {s.name: Stream(s.name, np.zeros(0), np.zeros((0, s.width)), s.unit, "n") for s in sensors}
        return replace(self.log, streams={**none, **self.log.streams})
