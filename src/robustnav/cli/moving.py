"""``demo moving``, ``benchmark moving`` and ``simulate moving``: attitude of carriers that move, from satellites."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Literal

from robustnav.cli.options import Flag
from robustnav.cli.show import note, progress, say, say_json, say_table
from robustnav.units import DEG

Case = Literal["car", "drone"]


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


def simulate_moving(
    *, case: Case = "car", seed: int = 1, duration: float = 60.0, out: Path = Path("out/moving.csv"), json: Flag = False
) -> None:
    """Simulate a car or a drone in motion with a MEMS unit and a satellite receiver; write a table with its truth.

    Parameters
    ----------
    case
        What moves.
    seed
        Fixes its way and every random number.
    duration
        How long [s].
    out
        The table.
    json
        Print what was written as JSON.
    """
    from robustnav.logs.table_write import write_table
    from robustnav.sim import moving as sim
    from robustnav.sim.moving_ways import way
    from robustnav.studies.moving_setting import LATITUDE, POSITION_SD, RATE_HZ, VELOCITY_SD, scenarios

    chosen = scenarios()[f"{case}, MEMS"]
    states = way(chosen.way, seed, duration, RATE_HZ)
    write_table(sim.simulate_moving(states, chosen.kit, latitude=LATITUDE, seed=seed), out)
    if json:
        say_json({"case": case, "seed": seed, "duration_s": duration, "file": str(out)})
        return
    say(f"{case}, seed {seed}: {duration:g} s at {RATE_HZ:g} Hz: {out}")
    unit = chosen.grade.unit
    left = f"--gyro-bias-sd {unit.gyro_bias_sd / DEG:g} --accel-bias-sd {unit.accel_bias_sd:g}"
    receiver = f"--velocity-sd {VELOCITY_SD:g} --position-sd {POSITION_SD:g}"
    note(f"next: robustnav align {shlex.quote(str(out))} --reference gnss --imu mpu9250 {left} {receiver}")
