"""Tracks drawn from the white-acceleration model itself, so that a filter with its numbers must be consistent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.sim.batch import run_numbers
from robustnav.sim.ranging_draws import RangingDraws
from robustnav.sim.trajectory import Vector, check_vector


@dataclass(frozen=True)
class RandomTracks:
    """Positions ``p_n`` [m] and velocities ``v_n`` [m/s], both (runs, n, 3), at ``t`` (n,) [s]; no attitude."""

    t: Array
    p_n: Array
    v_n: Array
    q_nb: None = None


@dataclass(frozen=True)
class WhiteAcceleration:
    """Motion driven by white acceleration, p' = v, v' = w, from a random start; all figures for north, east, down.

    Parameters
    ----------
    p_mean, v_mean : mean of the start [m], [m/s].
    p_sd, v_sd : its standard deviations [m], [m/s]; 0 starts at the mean.
    acceleration_density : two-sided density of w [m/s^2/sqrt(Hz)], the square root of q [m^2/s^3].

    Raises
    ------
    InputError : a figure that is not three finite numbers, a negative standard deviation or density.
    """

    p_mean: Vector
    v_mean: Vector
    p_sd: Vector
    v_sd: Vector
    acceleration_density: Vector

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            check_vector(value, f"white acceleration, {name}")
            if not name.endswith("mean") and min(value) < 0:
                raise InputError(f"white acceleration, {name}", got=str(value), expected="numbers >= 0")

    def draw(self, t: Array, *, runs: int | range, seed: int) -> RandomTracks:
        """Return tracks at ``t`` (n,) [s], which begin at ``t[0]``; runs and seed as in ``simulate_ranging``.

        Exact for uneven and repeated times: each step draws from Q = q [dt^3/3, dt^2/2; dt^2/2, dt].  The same seed
        at other times is another track.

        Raises
        ------
        InputError : no time, times that decrease, no runs, a negative seed or run number.
        """
        t = np.asarray(t, float)
        if not len(t) or not (np.diff(t) >= 0).all():
            raise InputError("white acceleration, t", got=f"{len(t)} times", expected="times that never decrease")
        draws = RangingDraws(seed, run_numbers(runs, seed))
        start = draws.normal("track_start", (2, 3))
        p = np.asarray(self.p_mean) + np.asarray(self.p_sd) * start[:, 0]
        v = np.asarray(self.v_mean) + np.asarray(self.v_sd) * start[:, 1]
        dt = np.diff(t)[:, None]
        noise = np.asarray(self.acceleration_density) * draws.normal("track_noise", (2, len(dt), 3))
        steps_v = np.sqrt(dt) * noise[:, 0]
        # Q = [dt/2; 1] q dt [dt/2; 1]' + [dt^3/12, 0; 0, 0] q
        steps_p = dt / 2 * steps_v + np.sqrt(dt**3 / 12) * noise[:, 1]
        v_n = _sums(v, steps_v)
        return RandomTracks(t, _sums(p, steps_p + v_n[:, :-1] * dt), v_n)


def _sums(start: Array, steps: Array) -> Array:
    """Return start (runs, 3) and its sums with ``steps`` (runs, n - 1, 3), together (runs, n, 3)."""
    return np.cumsum(np.concatenate([start[:, None], steps], axis=1), axis=1)
