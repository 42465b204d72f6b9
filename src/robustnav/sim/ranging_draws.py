"""Random numbers of simulated ranging: a stream for every run and effect, so that no effect disturbs another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.frames import Array

RANGING = 100  # keeps these streams apart from those of ``sim.sensor_errors``, numbered by sensor from 0

# The place numbers the random stream: append, do not reorder.
EFFECTS = (
    "white",
    "line",
    "colour",
    "nlos",
    "nlos_excess",
    "outlier",
    "outlier_size",
    "dropout",
    "clock",
    "clock_walk",
    "track_start",
    "track_noise",
)


@dataclass(frozen=True)
class RangingDraws:
    """Random numbers of ``runs``: those of run i depend on the seed, the effect and i, on nothing else.

    The stream of an effect is ``default_rng(SeedSequence(seed, spawn_key=(i, RANGING, place in EFFECTS)))``.
    """

    seed: int
    runs: range

    def normal(self, effect: str, shape: tuple[int, ...]) -> Array:
        """Return standard normal numbers (runs, *shape)."""
        return np.stack([generator.standard_normal(shape) for generator in self._generators(effect)])

    def uniform(self, effect: str, shape: tuple[int, ...]) -> Array:
        """Return uniform numbers (runs, *shape) from 0 to below 1."""
        return np.stack([generator.random(shape) for generator in self._generators(effect)])

    def exponential(self, effect: str, shape: tuple[int, ...]) -> Array:
        """Return exponential numbers (runs, *shape) of mean 1."""
        return np.stack([generator.standard_exponential(shape) for generator in self._generators(effect)])

    def _generators(self, effect: str) -> list[np.random.Generator]:
        place = EFFECTS.index(effect)
        keys = [(run, RANGING, place) for run in self.runs]
        return [np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=key)) for key in keys]
