"""``align``: initial alignment of a recording or of a simulated carrier; ``simulate alignment`` writes one to align."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from robustnav.cli.alignment_case import STAGES, recorded, scenario_of, simulated
from robustnav.cli.alignment_moving import recorded_in_motion
from robustnav.cli.alignment_options import (
    CARRIER,
    PART,
    REFERENCE,
    SATELLITES,
    SIMULATED,
    Carrier,
    Part,
    Reference,
    Satellites,
    Simulated,
)
from robustnav.cli.options import Flag
from robustnav.cli.show import note, progress, say, say_json, say_settings, say_table
from robustnav.errors import InputError
from robustnav.units import DEG_PER_HOUR, MILLI_G

Options = tuple[Carrier, Reference, Satellites, Part]

if TYPE_CHECKING:
    from robustnav.report.alignment_course import Aligned


def align(
    recording: Path | None = None,
    /,
    *,
    carrier: Carrier = CARRIER,
    reference: Reference = REFERENCE,
    satellites: Satellites = SATELLITES,
    part: Part = PART,
    simulated: Simulated = SIMULATED,
    out: Path | None = None,
    json: Flag = False,
    quiet: Flag = False,
) -> int:
    """Find attitude and biases of a unit on a swaying base or in motion, from any heading and tilt.

    Exits 3 when it never aligned, in motion when its heading was never found, or when it is far off a truth.

    Parameters
    ----------
    recording
        PX4 .ulg, BROAD .mat or .csv with gyro and accelerometer, and a reference velocity north and east, or with
        --reference gnss streams gnss_velocity or gnss_position.
    carrier
        Where and what.
    reference
        What holds it down.
    satellites
        With --reference gnss: the receiver.
    part
        Which part.
    simulated
        A simulated carrier instead.
    out
        Folder for report.html, results.json and alignment.csv.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    from robustnav.report.alignment_course import judge
    from robustnav.report.alignment_report import document, write_alignment

    given = carrier, reference, satellites, part
    with progress("aligning", STAGES, quiet=quiet) as step:
        if recording is None:
            done = _simulated(simulated, _words(given), step)
        else:
            done = _recorded(recording, given, simulated, step)
    level, _, _ = judge(done)
    if out is not None:
        note(f"report: {write_alignment(done, out)}")
    if json:
        say_json(document(done))
    else:
        _say(done)
        if out is None:
            note(f"next: {done.command} --out out/align, for a page with figures and the attitude over time")
    return 3 if level == "error" else 0


def simulate_alignment(
    *, simulated: Simulated = SIMULATED, out: Path = Path("out/alignment.csv"), json: Flag = False
) -> None:
    """Simulate a unit on a swaying carrier and a reference velocity in the wind, and write one table with its truth.

    Parameters
    ----------
    simulated
        What is simulated.
    out
        The table.
    json
        Print what was written as JSON.
    """
    from robustnav.logs.table_write import write_table
    from robustnav.sim.alignment_log import alignment_log

    scenario = scenario_of(simulated)
    write_table(alignment_log(scenario, simulated.seed), out)
    if json:
        say_json({"scenario": scenario.name, "seed": simulated.seed, "file": str(out)})
        return
    say(f"{scenario.name}, seed {simulated.seed}: {scenario.duration:g} s at {scenario.imu_rate_hz:g} Hz: {out}")
    grade = f"{scenario.gyro.white_sd / DEG_PER_HOUR:g}deg/h,{scenario.accel.white_sd / MILLI_G:g}mg"
    note(f"next: robustnav align {shlex.quote(str(out))} --grade {grade}")


def _simulated(given: Simulated, told: list[str], step: Callable[[], None]) -> Aligned:
    if given.scenario is None:
        raise InputError(
            "what to align",
            got="neither a recording nor a scenario",
            expected="one of them",
            do="robustnav align RECORDING --latitude DEG --imu NAME, or robustnav align --scenario s-10-10-60",
        )
    if told:
        raise InputError(
            f"option {told[0]}", got="a scenario", expected="--wind and --seed: a scenario states the rest"
        )
    done = simulated(given, step)
    return replace(done, command=shlex.join(["robustnav", "align", *_told(given, SIMULATED)]))


def _recorded(path: Path, options: Options, given: Simulated, step: Callable[[], None]) -> Aligned:
    if given != SIMULATED:
        raise InputError(f"option {_told(given, SIMULATED)[0]}", got="a recording", expected="no recording beside it")
    carrier, reference, satellites, part = options
    if reference.reference == "gnss":
        done = recorded_in_motion(path, options, step)
    elif satellites != SATELLITES:
        option = _told(satellites, SATELLITES)[0]
        raise InputError(f"option {option}", got=f"--reference {reference.reference}", expected="--reference gnss")
    else:
        done = recorded(path, carrier, reference, part, step)
    return replace(done, command=shlex.join(["robustnav", "align", str(path), *_words(options)]))


def _words(options: Options) -> list[str]:
    """Return the options that are not as by default, as they are written."""
    defaults = CARRIER, REFERENCE, SATELLITES, PART
    return [word for one, default in zip(options, defaults, strict=True) for word in _told(one, default)]


def _told(given: object, default: object) -> list[str]:
    """Return the options of a group that are not as by default, as they are written."""
    words = []
    for name, value in vars(given).items():
        if value != getattr(default, name):
            words += [f"--{name.replace('_', '-')}"] + ([] if value is True else [str(value)])
    return words


def _say(done: Aligned) -> None:
    from robustnav.report.alignment_course import angle_rows, bias_rows, judge, truth_row

    _, text, reasons = judge(done)
    say(f"{done.source}: {text}")
    for reason in reasons:
        say(f"  {reason}")
    say_table("Attitude at the end, and what it is within with 95 %", angle_rows(done))
    say_table("Biases at the end", bias_rows(done))
    if done.wind_words:
        say(f"\nWind\n  {done.wind_words}")
    if done.against is not None:
        say_table("Errors against the truth: at the end, and rms over the last quarter", [truth_row(done)])
    for event in done.events:
        note(event)
    say("\nSettings")
    say_settings(done.settings)
