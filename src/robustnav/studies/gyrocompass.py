"""The gyrocompass study: north by the Earth's rotation on a base at rest, and by a compass where the gyros cannot.

First, velocity zero: ``align`` beside coarse gyrocompassing and beside what is possible.  Then a boat in the wind with
a compass, with gyros that find north and gyros that do not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.evaluate.consistency import chi_square_band
from robustnav.studies.gyrocompass_runs import (
    GRADES,
    TREMBLE,
    Said,
    in_wind,
    scenario_of,
    setup_of,
    standing,
    still_bound,
    velocity_bound,
    with_compass,
)
from robustnav.units import DEG

Progress = Callable[[], None]
LEAST_SEEDS = 2
STANDING = ("0.01 deg/h", "0.1 deg/h", "1 deg/h")
STANDING_BASES = ("still", "engine")
TIMES = (60.0, 200.0)  # s
AFLOAT = ("3 deg/s", "0.5 deg/s", "0.01 deg/h")
WINDS = ("none", "lines", "markov")
AFLOAT_TIME = 60.0  # s


@dataclass(frozen=True)
class Standing:
    """Heading of a base at rest over all runs [deg]: rms of error, median claimed, NEES, and what else is possible.

    ``peer_rms_deg`` is coarse gyrocompassing; ``velocity_bound_deg`` holds for any base whose velocity is zero,
    ``still_bound_deg`` for one that is known not to turn either.
    """

    grade: str
    base: str
    seconds: float
    rms_deg: float
    claimed_deg: float
    heading_nees: float
    tilt_nees: float
    peer_rms_deg: float
    velocity_bound_deg: float
    still_bound_deg: float


@dataclass(frozen=True)
class Afloat:
    """Heading and tilt of a boat in the wind over all runs [deg], with a compass or without.

    Of tilt both rms and claim are of its size, about two axes.
    """

    grade: str
    wind: str
    compass: bool
    rms_deg: float
    claimed_deg: float
    heading_nees: float
    tilt_rms_deg: float
    tilt_claimed_deg: float
    tilt_nees: float
    observable_share: float


@dataclass(frozen=True)
class GyrocompassStudy:
    """All numbers of the study."""

    seeds: int
    seed: int
    standing: list[Standing]
    afloat: list[Afloat]


def steps_of(seeds: int) -> int:
    """Return how often ``progress`` will be called."""
    return seeds * (len(STANDING) * len(STANDING_BASES) + len(AFLOAT) * len(WINDS))


def gyrocompass_study(seeds: int = 60, seed: int = 0, progress: Progress = lambda: None) -> GyrocompassStudy:
    """Run the study.

    Parameters
    ----------
    seeds : runs of each case, at least 2.
    seed : the first of them.
    progress : called after every run.

    Raises
    ------
    InputError : too few seeds, or a negative seed.
    """
    if seeds < LEAST_SEEDS:
        raise InputError("gyrocompass study, seeds", got=f"{seeds}", expected=f"at least {LEAST_SEEDS}")
    numbers = range(seed, seed + seeds)
    at_rest = [
        row for grade in STANDING for base in STANDING_BASES for row in _standing(grade, base, numbers, progress)
    ]
    afloat = [row for grade in AFLOAT for wind in WINDS for row in _afloat(grade, wind, numbers, progress)]
    return GyrocompassStudy(seeds, seed, at_rest, afloat)


def results(study: GyrocompassStudy) -> dict[str, object]:
    """Return the study as plain numbers, with the bands in which 95 % of consistent means lie."""
    return {
        "study": "gyrocompass",
        "seeds": study.seeds,
        "seed": study.seed,
        "heading_nees_band": chi_square_band(1, study.seeds),
        "tilt_nees_band": chi_square_band(2, study.seeds),
        "standing": [asdict(row) for row in study.standing],
        "afloat": [asdict(row) for row in study.afloat],
    }


def outside_bands(study: GyrocompassStudy) -> list[str]:
    """Return in words the cases whose mean NEES is above the 95 % band: they claim too much.

    Of a heading that is not observable nothing is claimed.
    """
    highest = {"heading": chi_square_band(1, study.seeds)[1], "tilt": chi_square_band(2, study.seeds)[1]}
    named: list[tuple[str, Standing | Afloat, bool]] = [
        (f"{row.grade}, {row.base}, {row.seconds:.0f} s", row, True) for row in study.standing
    ]
    for one in study.afloat:
        case = f"{one.grade}, {one.wind}, {'compass' if one.compass else 'no compass'}"
        named.append((case, one, one.observable_share == 1.0))
    words = []
    for case, row, known in named:
        for name, value in (("heading", row.heading_nees if known else 0.0), ("tilt", row.tilt_nees)):
            if value > highest[name]:
                words.append(f"{case}: NEES of {name} {value:.2f}, band up to {highest[name]:.2f}")
    return words


def standing_rows(study: GyrocompassStudy) -> list[dict[str, object]]:
    """Return a row a case of the base at rest."""
    return [
        {
            "gyros": row.grade,
            "base": row.base,
            "after, s": f"{row.seconds:.0f}",
            "align, deg": f"{row.rms_deg:.3f}",
            "claimed, deg": f"{row.claimed_deg:.3f}",
            "NEES heading (1)": f"{row.heading_nees:.2f}",
            "NEES tilt (2)": f"{row.tilt_nees:.2f}",
            "coarse, deg": f"{row.peer_rms_deg:.3f}",
            "bound, velocity zero": f"{row.velocity_bound_deg:.3f}",
            "bound, nothing turns": f"{row.still_bound_deg:.3f}",
        }
        for row in study.standing
    ]


def afloat_rows(study: GyrocompassStudy) -> list[dict[str, object]]:
    """Return a row a case of the boat in the wind."""
    return [
        {
            "gyros": row.grade,
            "wind": row.wind,
            "compass": "yes" if row.compass else "no",
            "heading, deg": f"{row.rms_deg:.2f}",
            "claimed, deg": f"{row.claimed_deg:.2f}",
            "NEES heading (1)": f"{row.heading_nees:.2f}",
            "tilt, deg": f"{row.tilt_rms_deg:.3f}",
            "tilt claimed, deg": f"{row.tilt_claimed_deg:.3f}",
            "NEES tilt (2)": f"{row.tilt_nees:.2f}",
            "observable, %": f"{100 * row.observable_share:.0f}",
        }
        for row in study.afloat
    ]


def _standing(name: str, base: str, seeds: Sequence[int], progress: Progress) -> list[Standing]:
    grade = GRADES[name]
    setup, scenario = setup_of(grade, TREMBLE), scenario_of(grade, base, "none", TIMES[-1])
    runs = []
    for seed in seeds:
        runs.append(standing(scenario, seed, setup, TIMES))
        progress()
    out = []
    for k, seconds in enumerate(TIMES):
        told = [run[k] for run in runs]
        out.append(
            Standing(
                grade=name,
                base=base,
                seconds=seconds,
                rms_deg=_rms([one.heading for one in told]),
                claimed_deg=float(np.median([one.heading_sd for one in told])) / DEG,
                heading_nees=_heading_nees(told),
                tilt_nees=_tilt_nees(told),
                peer_rms_deg=_rms([one.peer for one in told]),
                velocity_bound_deg=velocity_bound(setup, seconds) / DEG,
                still_bound_deg=still_bound(setup, seconds) / DEG,
            )
        )
    return out


def _afloat(name: str, wind: str, seeds: Sequence[int], progress: Progress) -> list[Afloat]:
    scenario = scenario_of(GRADES[name], "boat", wind, AFLOAT_TIME)
    bare = setup_of(GRADES[name], scenario.velocity_sd)
    told: dict[bool, list[Said]] = {False: [], True: []}
    for seed in seeds:
        for compass, runs in told.items():
            runs.append(in_wind(scenario, seed, with_compass(bare) if compass else bare))
        progress()
    return [
        Afloat(
            grade=name,
            wind=wind,
            compass=compass,
            rms_deg=_rms([one.heading for one in runs]),
            claimed_deg=float(np.median([one.heading_sd for one in runs])) / DEG,
            heading_nees=_heading_nees(runs),
            tilt_rms_deg=_rms([float(np.linalg.norm(one.tilt)) for one in runs]),
            tilt_claimed_deg=float(np.sqrt(2 * np.median([one.tilt_var for one in runs]))) / DEG,
            tilt_nees=_tilt_nees(runs),
            observable_share=float(np.mean([one.observable for one in runs])),
        )
        for compass, runs in told.items()
    ]


def _rms(angles: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(angles)))) / DEG


def _heading_nees(runs: list[Said]) -> float:
    return float(np.mean([(one.heading / one.heading_sd) ** 2 for one in runs]))


def _tilt_nees(runs: list[Said]) -> float:
    return float(np.mean([one.tilt @ one.tilt / one.tilt_var for one in runs]))
