"""Verbs that need no recording: ``demo`` and ``simulate``."""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter
from typing import Literal

from cyclopts import App

from robustnav.cli.options import Flag
from robustnav.cli.show import note, progress, say, say_json, say_table
from robustnav.errors import InputError

demo = App(name="demo", help="Rebuild a published study and write its page.")
Motion = Literal["case-one", "case-two", "steady-turn", "full-roll"]


@demo.command
def attitude(
    *,
    out: Path = Path("out/attitude"),
    seeds: int = 200,
    seed: int = 1,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Run the attitude study: extended H2 filter, EKF, quaternion H2 and MEKF on the two published cases.

    Parameters
    ----------
    out
        Folder for report.html and results.json.
    seeds
        Independent runs a case.
    seed
        Fixes every random number.
    json
        Print results.json instead of tables.
    quiet
        No progress bar.
    """
    from robustnav.studies.attitude import attitude_study, results, rms_rows, steps_of
    from robustnav.studies.attitude_report import write_study

    with progress("attitude study", steps_of(seeds), quiet=quiet) as step:
        study = attitude_study(seeds, seed, step)
    page = write_study(study, out, f"robustnav demo attitude --seeds {seeds} --seed {seed}")
    if json:
        say_json(results(study))
        note(f"report: {page}")
        return
    for case, protocols in study.cases.items():
        for protocol in protocols:
            say_table(f"Case {case}, protocol {protocol}, RMS over {seeds} seeds", rms_rows(study, case, protocol))
    turns = [{"manoeuvre": k} | {f"{n}_rms_deg": v for n, v in row.items()} for k, row in study.turns.items()]
    say_table("RMS of the total attitude error", turns)
    say(f"\nreport: {page}")


@demo.command
def uwb(
    *,
    out: Path = Path("out/uwb"),
    seeds: int = 500,
    seed: int = 1,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Run the ranging study: a quadcopter among anchors, filters beside their bound, outliers, outages, doubt.

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
    from robustnav.studies.uwb import COLOURED, OWN, doubt_rows, goals, results, rows_of, steps_of, uwb_study
    from robustnav.studies.uwb_report import write_study

    with progress("ranging study", steps_of(seeds), quiet=quiet) as step:
        study = uwb_study(seeds, seed, step)
    page = write_study(study, out, f"robustnav demo uwb --seeds {seeds} --seed {seed}")
    if json:
        say_json(results(study))
        note(f"report: {page}")
        return
    tables = {OWN: study.own.figures, COLOURED: study.coloured.figures}
    for name, figures in (tables | {k: v.figures for k, v in study.scenarios.items()}).items():
        say_table(f"{name[0].upper()}{name[1:]}", rows_of(figures))
    say_table("Layouts that leave doubt", doubt_rows(study))
    say_table("Goals", goal_rows(goals(study)))
    say(f"\nreport: {page}")


@demo.command
def alignment(
    *,
    out: Path = Path("out/alignment"),
    seeds: int = 100,
    seed: int = 0,
    only: list[str] | None = None,
    case: list[str] | None = None,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Run the alignment study: the published filters on a swaying carrier in the wind, their weight, and ours.

    Parameters
    ----------
    out
        Folder for report.html and results.json.
    seeds
        Independent runs a scenario and wind.
    seed
        The first of them.
    only
        A method to run, such as align or hinf; repeat it for more. All of them without.
    case
        A case to run, such as s-10-10-60 or h-10-10-60-gusts; repeat it for more. All of them without.
    json
        Print results.json instead of tables.
    quiet
        No progress bar.
    """
    from robustnav.studies.alignment import Selection, alignment_study, rows_of
    from robustnav.studies.alignment_report import bound_rows, goal_rows, results, wind_rows, write_study

    selection = Selection(tuple(case or ()), tuple(only or ()))
    began = perf_counter()
    with progress("alignment study", selection.steps(seeds), quiet=quiet) as step:
        study = alignment_study(seeds, seed, step, selection)
    note(f"{perf_counter() - began:.1f} s{_peak_memory()}")
    chosen = [f" --only {name}" for name in only or ()] + [f" --case {name}" for name in case or ()]
    command = f"robustnav demo alignment --seeds {seeds} --seed {seed}{''.join(chosen)}"
    page = write_study(study, out, command)
    if json:
        say_json(results(study))
        note(f"report: {page}")
        return
    for name, figures in study.cases.items():
        say_table(f"{name}, median / 95 % over {seeds} seeds", rows_of(figures.figures))
    for title, rows in (("Bounds", bound_rows(study)), ("Single winds", wind_rows(study)), ("Goals", goal_rows(study))):
        if rows:
            say_table(title, rows)
    say(f"\nreport: {page}")


def _peak_memory() -> str:
    """Return the most memory this process has held, as words; nothing where the system does not say."""
    try:
        import resource
    except ImportError:
        return ""
    unit = 1 if sys.platform == "darwin" else 1024  # bytes of ru_maxrss
    return f", peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6:.0f} MB"


@demo.command
def gyrocompass(
    *,
    out: Path = Path("out/gyrocompass"),
    seeds: int = 60,
    seed: int = 0,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Run the gyrocompass study: north on a base at rest, and a compass where the gyros cannot find it.

    Parameters
    ----------
    out
        Folder for report.html and results.json.
    seeds
        Independent runs a case.
    seed
        The first of them.
    json
        Print results.json instead of tables.
    quiet
        No progress bar.
    """
    from robustnav.studies.gyrocompass import afloat_rows, gyrocompass_study, results, standing_rows, steps_of
    from robustnav.studies.gyrocompass_report import write_study

    with progress("gyrocompass study", steps_of(seeds), quiet=quiet) as step:
        study = gyrocompass_study(seeds, seed, step)
    page = write_study(study, out, f"robustnav demo gyrocompass --seeds {seeds} --seed {seed}")
    if json:
        say_json(results(study))
        note(f"report: {page}")
        return
    say_table(f"At rest, {seeds} seeds a row", standing_rows(study))
    say_table(f"A boat in the wind, after a minute, {seeds} seeds a row", afloat_rows(study))
    say(f"\nreport: {page}")


def simulate(
    *,
    motion: Motion = "case-one",
    imu: str = "mpu9250",
    magnetometer: str = "ak8963",
    runs: int = 1,
    seed: int = 1,
    errors: Literal["noise", "all", "none"] = "noise",
    out: Path = Path("out/simulated"),
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Simulate IMU and magnetometer along a motion and write one table a run, with its truth.

    Parameters
    ----------
    motion
        Which motion.
    imu
        Data-sheet preset of gyro and accelerometer, or a TOML file.
    magnetometer
        Data-sheet preset of the magnetometer, or a TOML file.
    runs
        Number of runs.
    seed
        Fixes every random number.
    errors
        Which sensor errors: white noise and gyro bias walk, all that the data sheet states (uncalibrated), or none.
    out
        Folder for run_0000.csv, run_0001.csv, ...
    json
        Print what was written as JSON.
    quiet
        No progress bar.
    """
    from dataclasses import replace

    from robustnav import datasheet
    from robustnav.logs.table_write import write_table
    from robustnav.sim import attitude_cases, sensor_errors, trajectory
    from robustnav.sim.batch import Sensors
    from robustnav.sim.batch import simulate as simulate_batch
    from robustnav.units import DPS

    motions: dict[str, trajectory.Trajectory] = {
        "case-one": trajectory.case_one(),
        "case-two": trajectory.case_two(),
        "steady-turn": trajectory.steady_turn(20 * DPS, 60.0, 100.0),
        "full-roll": trajectory.full_roll_and_pitch(10.0, 100.0),
    }
    switches = {
        "noise": sensor_errors.STUDY_ERRORS,
        "all": sensor_errors.ALL_ERRORS,
        "none": sensor_errors.NO_ERRORS,
    }
    if runs < 1:
        raise InputError("runs", got=str(runs), expected="1 or more")
    unit = datasheet.imu(imu)
    if unit.gyro.random_walk is None and errors != "none":
        walk = attitude_cases.BIAS_WALK_DPS_RTS
        note(f"{imu} states no gyro bias walk: {walk:g} deg/s per root second is taken, as in the study")
        unit = replace(unit, gyro=replace(unit.gyro, random_walk=walk * DPS))
    carried = Sensors(unit, datasheet.magnetometer(magnetometer), switches[errors])
    chosen = motions[motion]
    written: list[str] = []
    with progress("simulating", runs, quiet=quiet) as step:
        for i in range(runs):
            batch = simulate_batch(chosen, carried, attitude_cases.environment(), runs=range(i, i + 1), seed=seed)
            path = out / f"run_{i:04d}.csv"
            write_table(batch.log(i), path)
            written.append(str(path))
            step()
    if json:
        say_json({"motion": motion, "imu": imu, "magnetometer": magnetometer, "seed": seed, "files": written})
    else:
        say(f"{runs} run{'s' if runs > 1 else ''} of {motion} with {imu} and {magnetometer}: {written[0]} ...")
        say(f"next: robustnav run {written[0]} --estimator h2")
