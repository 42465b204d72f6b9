"""The same running filter in NumPy: the specification of the kernel's time loop, and the way without a compiler."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from robustnav.engine.filters import FilterSetup, Output, SensorData, SensorSeen
from robustnav.errors import EstimatorError, InputError
from robustnav.filter import ekf, fixed_gain, hinf, ukf
from robustnav.filter.steps import Seen, pack, unpack
from robustnav.frames import Array
from robustnav.model.functions import ModelFunctions

MOST_PARTS = 10_000  # of one prediction


class ReferenceFilter:
    """A filter over any ``ModelFunctions``, step by step in NumPy; the same calls as ``KernelFilter``."""

    backend = "numpy"

    def __init__(self, model: ModelFunctions, setup: FilterSetup) -> None:
        self.model, self.setup = model, setup
        self._x = np.array(setup.x, float)
        n = model.model.error_size
        self._P = np.zeros((n, n)) if setup.P is None else np.array(setup.P, float)
        self._time, self._elapsed = float("nan"), 0.0

    @property
    def state(self) -> Array:
        """The state now (nx,), a copy."""
        return self._x.copy()

    @property
    def covariance(self) -> Array:
        """The covariance now (ne, ne); zero for a constant gain."""
        return self._P.copy()

    def snapshot(self) -> tuple[Array, Array, float, float]:
        """Return everything the filter remembers, as ``KernelFilter.snapshot``."""
        return self._x.copy(), pack(self._P), self._time, self._elapsed

    def restore(self, snapshot: tuple[Array, Array, float, float]) -> None:
        """Put a ``snapshot`` back."""
        self._x, self._P = snapshot[0].copy(), unpack(snapshot[1])
        self._time, self._elapsed = snapshot[2], snapshot[3]

    def update(self, *arguments: object) -> None:
        """Move by ``dt`` seconds and fuse readings: ``update(input, *readings, dt)``, None for no reading."""
        *values, dt = arguments
        if len(values) != 1 + len(self.model.model.sensors) or not isinstance(dt, float | int) or not 0 <= dt < 1e9:
            raise InputError("update", got=f"{len(values)} arrays and dt = {dt}", expected="input, readings, dt >= 0")
        readings = {j: np.asarray(z, float) for j, z in enumerate(values[1:]) if z is not None}
        for j, z in readings.items():
            size = self.model.model.sensors[j].width
            if z.shape != (size,):
                raise InputError(self.model.model.sensors[j].name, got=f"shape {z.shape}", expected=f"{size} numbers")
        if dt > 0:
            u = np.asarray(values[0], float)
            if u.shape != (self.model.model.input_size,) or not np.isfinite(u).all():
                raise InputError("filter input", got=str(values[0]), expected="finite numbers")
            self._predict(u, float(dt))
        self._correct({j: z for j, z in readings.items() if np.isfinite(z).all()})

    def run(
        self,
        t: Array,
        u: Array,
        sensors: Sequence[SensorData | None],
        *,
        covariance: bool = True,
        innovations: bool = True,
    ) -> Output:
        """Run over a recording; arguments and result as ``KernelFilter.run``."""
        x_out, P_out = [], []
        rows = [s.size for s in self.model.model.sensors]
        if not self.setup.unscented:
            rows = list(self.model.rows)
        seen = [SensorSeen.empty(len(d.t), m) if d else None for d, m in zip(sensors, rows, strict=True)]
        following = [0] * len(sensors)
        for now, value in zip(t, u, strict=True):
            if np.isfinite(value).all():
                self._advance(float(now), value, sensors, following, seen)
            x_out.append(self._x.copy())
            P_out.append(pack(self._P))
        P = np.array(P_out) if covariance and self.setup.kind != "fixed" else None
        return Output(np.array(x_out), P, tuple(seen) if innovations else (None,) * len(sensors))

    def _advance(
        self,
        now: float,
        u: Array,
        sensors: Sequence[SensorData | None],
        following: list[int],
        seen: Sequence[SensorSeen | None],
    ) -> None:
        """Fuse what was read up to ``now``, each reading at its own time, and end at ``now``."""
        if np.isnan(self._time):
            self._time = now
        while True:
            waiting = [d.t[k] for d, k in zip(sensors, following, strict=True) if d and k < len(d.t)]
            at = float(min([*waiting, now]))
            early = at < self._time
            if at > self._time:
                self._predict(u, at - self._time)
                self._time = at
            readings, rows = {}, {}
            for j, data in enumerate(sensors):
                if data and following[j] < len(data.t) and data.t[following[j]] == at:
                    rows[j] = following[j]
                    following[j] += 1
                    if not early and np.isfinite(data.z[rows[j]]).all():
                        readings[j] = data.z[rows[j]]
            for j, one in self._correct(readings).items():
                kept = seen[j]
                if kept is not None:
                    kept.nu[rows[j]], kept.s[rows[j]] = one.nu, one.s
                    kept.nis[rows[j]], kept.weight[rows[j]] = one.nis, one.weight
                    kept.margin[rows[j]] = one.margin
            if at == now and not rows:
                return

    def _predict(self, u: Array, dt: float) -> None:
        self._elapsed += dt
        self._time += dt
        parts = min(max(1, ceil(dt / self.setup.longest_step)), MOST_PARTS)
        for _ in range(parts):
            self._step(u, dt / parts)

    def _step(self, u: Array, dt: float) -> None:
        if self.setup.kind == "fixed":
            self._x = self.model.propagate(self._x, u, dt)
        elif self.setup.unscented:
            try:
                self._x, self._P = ukf.predict(self.model, (self._x, self._P), u, dt, self.setup.spread)
            except EstimatorError:
                self._P[0, 0] = np.nan  # a covariance that lost definiteness stays visible, as in the kernel
        else:
            self._x, self._P = ekf.predict(self.model, self._x, self._P, u, dt)

    def _correct(self, readings: dict[int, Array]) -> dict[int, Seen]:
        if not readings:
            return {}
        setup = self.setup
        if setup.kind == "fixed":
            if setup.times is None or setup.gains is None:
                raise InputError("constant-gain filter", got="no gains", expected="a gain table")
            chosen = int(np.searchsorted(setup.times, self._elapsed, side="right")) - 1
            mask = sum(1 << j for j in readings)
            self._x, out = fixed_gain.correct(self.model, self._x, setup.gains[chosen, mask - 1], readings)
            return out
        out = {}
        for j, z in readings.items():
            belief, rule = (self._x, self._P), setup.rules[j]
            if setup.unscented:
                try:
                    self._x, self._P, out[j] = ukf.update(self.model, j, belief, z, setup.spread, rule)
                except EstimatorError:
                    none = np.full(self.model.model.sensors[j].size, np.nan)
                    out[j] = Seen(none, none, float("nan"), 0.0)
            else:
                self._x, self._P, out[j] = ekf.update(self.model, j, belief, z, rule)
        if setup.bound is not None and any(one.used for one in out.values()):
            gamma, L = setup.bound
            self._P, margin = hinf.enlarge(self._P, L, gamma)
            out = {j: replace(one, margin=margin) for j, one in out.items()}
        return out
