"""Which wind a window of the record speaks for: the lines with the most evidence, and what noise is about them."""

from __future__ import annotations

from dataclasses import replace

from robustnav.alignment.lines import Spectrum, Window, alone, given, search
from robustnav.alignment.setting import AROUND, BANK, LINED, Wind

RESOLVED = 12.0  # s, a window in which lines are just told apart
POSSIBLE = 4.0  # nats less than the best noise about lines


def identify(window: Window) -> list[Wind]:
    """Return the lines found, in the noises about them that may be, the likeliest first; none without lines."""
    found = _lines(window)
    if not found.omega.size:
        return []
    evidence = _evidence(window, found)
    least = max(evidence.values()) - POSSIBLE
    kept = sorted((i for i, value in evidence.items() if value >= least), key=lambda i: -evidence[i])
    return [_as_wind(found, _remainder(window) if i == 0 else BANK[i]) for i in kept[:LINED]]


def likeliest(window: Window) -> Wind:
    """Return the wind with the most evidence, of the bank's where there are no lines."""
    found = identify(window)
    return found[0] if found else max(BANK, key=lambda wind: alone(window, wind.markov_sd, wind.markov_time))


def _lines(window: Window) -> Spectrum:
    """Start at the likeliest noise without lines, then try less of it."""
    values = [alone(window, wind.markov_sd, wind.markov_time) for wind in AROUND]
    level = max(range(len(AROUND)), key=lambda i: values[i])
    kept = search(window, AROUND[level].markov_sd, AROUND[level].markov_time, values[level])
    for wind in AROUND[level - 1 :: -1] if level else ():
        found = search(window, wind.markov_sd, wind.markov_time, kept.evidence, kept)
        if not found.evidence > kept.evidence:
            break
        kept = found
    return kept


def _evidence(window: Window, found: Spectrum) -> dict[int, float]:
    """Return by place in the bank the evidence of the lines in that noise.

    Of one correlation time winds grow, and pass their best: the rest are left out.
    """
    out: dict[int, float] = {}
    top, past, time = -float("inf"), False, 0.0
    for i, wind in enumerate(BANK):
        past = past and wind.markov_time <= time
        time = wind.markov_time
        if past:
            continue
        out[i] = given(window, wind.markov_sd, wind.markov_time, found)
        top = max(top, out[i])
        past = i > 0 and out[i] < top - 2 * POSSIBLE and out[i] < out.get(i - 1, -float("inf"))
    return out


def _remainder(window: Window) -> Wind:
    """Return what a line not yet told from its neighbour leaves: less, the longer the window."""
    return Wind(0.05 * min(RESOLVED / window.span, 1.0) ** 3, 2.0)


def _as_wind(found: Spectrum, around: Wind) -> Wind:
    sd = (min(3.0 * width, 0.4 * omega) for omega, width in zip(found.omega, found.omega_sd, strict=True))
    return replace(around, omega=tuple(found.omega.tolist()), omega_sd=tuple(float(one) for one in sd))
