"""A running compiled filter: whole recordings with the interpreter lock released, or one sample at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robustnav.engine import _kernel
from robustnav.engine.compiled import CompiledModel
from robustnav.errors import InputError
from robustnav.filter.steps import pack, unpack
from robustnav.filter.ukf import Spread
from robustnav.filter.weighting import KINDS as RULES
from robustnav.filter.weighting import Rule
from robustnav.frames import Array
from robustnav.records import BoolArray

KINDS = {"ekf": 0, "fixed": 1, "ukf": 2, "hinf": 3}


@dataclass(frozen=True)
class FilterSetup:
    """What a filter is started with, whatever runs it.

    Parameters
    ----------
    kind : ``ekf``, ``fixed`` (constant gain), ``ukf`` or ``hinf`` (unscented with an H-infinity bound).
    x : start state (nx,).
    P : start covariance (ne, ne); None for a constant gain.
    rules : what readings count for, by sensor.
    spread : of the unscented points.
    longest_step : a longer prediction is made in equal parts [s].
    bound : gamma and the rows (l, ne) it bounds, of ``hinf``.
    times, gains : of a constant gain: starts of the sets (s,) [s] and gains (s, 2^k - 1, ne, rows).
    """

    kind: str
    x: Array
    P: Array | None
    rules: tuple[Rule, ...]
    spread: Spread = field(default_factory=Spread)
    times: Array | None = None
    gains: Array | None = None
    longest_step: float = float("inf")
    bound: tuple[float, Array] | None = None

    @property
    def unscented(self) -> bool:
        """Whether readings are fused whole, in the sensor's own axes."""
        return self.kind in ("ukf", "hinf")


@dataclass(frozen=True)
class SensorData:
    """Readings of one sensor: times ``t`` (n,) [s] and readings ``z`` (n, width)."""

    t: Array
    z: Array


@dataclass(frozen=True)
class SensorSeen:
    """What the readings said: ``nu``, ``s`` (n, rows), ``nis``, ``weight`` (n,); NaN where a reading was missing.

    ``margin`` (n,) of existence of an H-infinity filter after the instant of the reading; NaN of other filters.
    """

    nu: Array
    s: Array
    nis: Array
    weight: Array
    margin: Array

    @property
    def used(self) -> BoolArray:
        """Which readings (n,) moved the estimate."""
        used: BoolArray = self.weight > 0
        return used

    @classmethod
    def empty(cls, n: int, rows: int) -> SensorSeen:
        """Return room for ``n`` readings, all missing."""
        return cls(*(np.full((n, rows), np.nan) for _ in range(2)), *(np.full(n, np.nan) for _ in range(3)))


@dataclass(frozen=True)
class Output:
    """A filter's output at the input times: states (n, nx), packed covariances (n, ne (ne + 1) / 2) or None."""

    x: Array
    P: Array | None
    seen: tuple[SensorSeen | None, ...]


class KernelFilter:
    """A filter in the C kernel.

    ``update(input, *readings, dt)`` moves it by ``dt`` seconds and fuses the readings of that instant (None: no
    reading); it returns nothing, read ``state`` and ``covariance`` when they are needed.
    """

    def __init__(self, model: CompiledModel, setup: FilterSetup) -> None:
        self.model, self.setup = model, setup
        P = None if setup.P is None else np.ascontiguousarray(pack(setup.P))
        spread = (setup.spread.alpha, setup.spread.beta, setup.spread.kappa)
        self._filter = _kernel.Filter(
            model.handle,
            KINDS[setup.kind],
            np.ascontiguousarray(setup.x, float),
            P,
            model.parameters,
            model.intensities,
            model.model.variances,
            tuple(RULES[type(rule)] for rule in setup.rules),
            np.array([rule.limit for rule in setup.rules], float),
            spread,
            setup.longest_step,
            None if setup.times is None else np.ascontiguousarray(setup.times, float),
            None if setup.gains is None else np.ascontiguousarray(setup.gains, float),
            0.0 if setup.bound is None else float(setup.bound[0]),
            None if setup.bound is None else np.ascontiguousarray(setup.bound[1], float),
        )
        self.update: Callable[..., None] = self._filter.update
        n = model.model.error_size
        self._x, self._P = np.empty(model.model.state_size), np.empty(n * (n + 1) // 2)

    @property
    def backend(self) -> str:
        """``c`` in double, ``float`` in float."""
        return "c" if self.model.real == "double" else "float"

    @property
    def state(self) -> Array:
        """The state now (nx,), a copy."""
        self._filter.store(self._x, None)
        return self._x.copy()

    @property
    def covariance(self) -> Array:
        """The covariance now (ne, ne); zero for a constant gain, whose covariance its design knows."""
        self._filter.store(self._x, self._P)
        return unpack(self._P)

    def snapshot(self) -> tuple[Array, Array, float, float]:
        """Return everything the filter remembers: state, packed covariance, time [s], time since its start [s]."""
        time, elapsed = self._filter.store(self._x, self._P)
        return self._x.copy(), self._P.copy(), time, elapsed

    def restore(self, snapshot: tuple[Array, Array, float, float]) -> None:
        """Put a ``snapshot`` back; the filter then continues exactly as it did from there."""
        self._filter.load(*snapshot)

    def run(
        self,
        t: Array,
        u: Array,
        sensors: Sequence[SensorData | None],
        *,
        covariance: bool = True,
        innovations: bool = True,
    ) -> Output:
        """Run over input times ``t`` (n,) and inputs ``u`` (n, nu), fusing every reading at its own time.

        An input row with a NaN counts as absent: the next one covers its time.  Memory: inputs and outputs only.
        """
        n, ne = len(t), self.model.model.error_size
        x = np.empty((n, self.model.model.state_size))
        P = np.empty((n, ne * (ne + 1) // 2)) if covariance and self.setup.kind != "fixed" else None
        seen: list[SensorSeen | None] = []
        arguments: list[Any] = []
        sizes = [s.size for s in self.model.model.sensors]
        for data, rows in zip(sensors, sizes if self.setup.unscented else self.model.rows, strict=True):
            if data is None:
                seen.append(None)
                arguments.append(None)
                continue
            kept = SensorSeen.empty(len(data.t), rows) if innovations else None
            seen.append(kept)
            outputs = (kept.nu, kept.s, kept.nis, kept.weight, kept.margin) if kept else (None,) * 5
            arguments.append((np.ascontiguousarray(data.t), np.ascontiguousarray(data.z, float), *outputs))
        u = np.ascontiguousarray(u, float)
        if u.shape != (n, self.model.model.input_size):
            raise InputError("filter input", got=f"shape {u.shape}", expected=f"({n}, {self.model.model.input_size})")
        self._filter.run(np.ascontiguousarray(t, float), u, tuple(arguments), x, None, P)
        return Output(x, P, tuple(seen))
