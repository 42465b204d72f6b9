"""``demo moving``, ``benchmark moving`` and ``simulate moving``: attitude of carriers that move, from satellites."""

from __future__ import annotations

from pathlib import Path

from robustnav.cli.options import Flag
from robustnav.cli.show import note, progress, say, say_json, say_table


def moving(
    *,
    out: Path = Path("out/moving"),
    seeds: int = 100,
    seed: int = 1,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Run the study of moving carriers: a drone and a car with a satellite receiver, from any heading and tilt.

    Parameters
    ----------
    out
        Folder for report.html and results.json.
    seeds
        Independent runs a scenario.
    seed
        Fixes every random number.
    json
        Print results.json instead of tables.
    quiet
        No progress bar.
    """
    from robustnav.studies.goals import goal_rows
    from robustnav.studies.moving import error_rows, found_rows, goals, moving_study, results, steps_of
    from robustnav.studies.moving_report import write_study

    with progress("moving carriers", steps_of(seeds), quiet=quiet) as step:
        study = moving_study(seeds, seed, step)
    page = write_study(study, out, f"robustnav demo moving --seeds {seeds} --seed {seed}")
    if json:
        say_json(results(study))
        note(f"report: {page}")
        return
    say_table("When the heading was found", found_rows(study))
    say_table(f"Errors over {seeds} seeds, root mean square", error_rows(study))
    say_table("Goals", goal_rows(goals(study)))
    say(f"\nreport: {page}")


def benchmark_moving(folder: Path, *, json: Flag = False) -> None:
    """Align PX4-ECL's two recorded flights in motion, beside the heading of their compass.

    Parameters
    ----------
    folder
        Folder with ekf_gsf_reset.csv and iris_gps.csv.
    json
        Print one JSON document.
    """
    from robustnav.studies.moving_recordings import moving_recordings

    rows = moving_recordings(folder)
    if json:
        say_json({"benchmark": "moving", "flights": rows})
        return
    say_table("Heading found in motion, beside the compass", rows)
    note("nis: of a velocity's component in the air, expected 1; neighbours: their largest correlation, expected 0")
