"""What the wind was: a description of the reference velocity of a base at rest, after the alignment."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from robustnav.alignment.bank import FIRST_TIME
from robustnav.alignment.identify import likeliest
from robustnav.alignment.level import missing, odd_limit, oddness
from robustnav.alignment.lines import MOST_SAMPLES, POLY, Window
from robustnav.alignment.setting import AlignSetup
from robustnav.frames import Array
from robustnav.records import BoolArray

LONGEST = 60.0  # s looked at, the last ones
LEAST_MARKOV, LEAST_GUSTS = 0.05, 0.01  # m/s, share: below nothing is said of them
FREE_SD, STILL_SD = 3.0, 1e-4  # m/s: the mean is free, nothing else of the record drifts


@dataclass(frozen=True)
class Disturbance:
    """What disturbed a reference velocity, north and east [m/s].

    ``span`` [s] looked at; ``mean`` (2,); lines with ``line_period`` (k,) [s] and ``line_amplitude`` (k, 2), the
    longest first; the rest as a Gauss-Markov process of ``markov_sd`` and ``markov_time`` [s]; ``gust_share`` of
    readings.
    """

    span: float
    mean: Array
    line_period: Array
    line_amplitude: Array
    markov_sd: float
    markov_time: float
    gust_share: float

    @property
    def words(self) -> str:
        """The same in words."""
        north, east = np.round(self.mean, 2) + 0.0
        said = [f"Mean {north:.2f} m/s north, {east:.2f} m/s east"]
        lines = zip(self.line_period, np.hypot(*self.line_amplitude.T), strict=True)
        named = ", ".join(f"{period:.3g} s ({size:.2f} m/s)" for period, size in lines)
        said.append(f"lines with periods of {named}" if named else "no lines")
        if self.markov_sd >= LEAST_MARKOV:
            said.append(f"wanders by about {self.markov_sd:.2g} m/s within {self.markov_time:g} s")
        if self.gust_share > LEAST_GUSTS:
            said.append(f"{100 * self.gust_share:.1f} % of the readings stand out as gusts")
        return f"{'; '.join(said)}. Found in the last {self.span:.0f} s."


def disturbance_of(reference: Array, setup: AlignSetup) -> Disturbance | None:
    """Return what disturbed the reference velocity (n, 2) [m/s], NaN where missing, in its last minute.

    None where less than twelve seconds of readings are there: too little to tell a wind from another.
    """
    z = reference[-round(LONGEST / setup.period) :]
    there = ~missing(z)
    if there.sum() * setup.period < FIRST_TIME:
        return None
    odd = oddness(z)
    use = there & (odd <= odd_limit(odd, setup.reference_sd))
    window = _window(z, use, setup)
    wind = likeliest(window)
    mean, amplitude = _fitted(z, use, np.array(wind.omega), setup.period)
    order = np.argsort(wind.omega)
    return Disturbance(
        span=len(z) * setup.period,
        mean=mean,
        line_period=2 * pi / np.array(wind.omega)[order],
        line_amplitude=amplitude[order],
        markov_sd=wind.markov_sd,
        markov_time=wind.markov_time,
        gust_share=1 - float(use.sum() / there.sum()),
    )


def _window(z: Array, use: BoolArray, setup: AlignSetup) -> Window:
    """Average the readings that count into as many rows as the search for lines takes."""
    group = -(-len(z) // MOST_SAMPLES)
    n = len(z) // group
    kept = np.where(use[:, None], z, 0.0)[-n * group :].reshape(n, group, 2)
    count = use[-n * group :].reshape(n, group).sum(axis=1)
    mean = kept.sum(axis=1) / np.maximum(count, 1)[:, None]
    poly_sd = np.full(POLY, STILL_SD)
    poly_sd[0] = FREE_SD
    return Window(mean, count / group, group * setup.period, setup.reference_sd / np.sqrt(group), poly_sd)


def _fitted(z: Array, use: BoolArray, omega: Array, period: float) -> tuple[Array, Array]:
    """Return mean (2,) and amplitudes (k, 2) of lines, by least squares."""
    phase = np.outer(period * np.arange(len(z)), omega)
    columns = np.hstack([np.ones((len(z), 1)), np.cos(phase), np.sin(phase)])
    found = np.linalg.lstsq(columns[use], z[use], rcond=None)[0]
    k = len(omega)
    return found[0], np.hypot(found[1 : 1 + k], found[1 + k :])
