"""``benchmark``: accuracy on public recordings and speed, beside the peers that are installed."""

from __future__ import annotations

from pathlib import Path

from cyclopts import App

from robustnav.cli.options import KIT, Flag, Kit, split
from robustnav.cli.show import note, progress, say_json, say_table

benchmark = App(name="benchmark", help="Accuracy and speed beside the peers that are installed.")


@benchmark.command
def broad(
    folder: Path,
    *,
    estimators: str | None = None,
    kit: Kit = KIT,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Score estimators on the BROAD trials in a folder with the benchmark's own metric.

    Parameters
    ----------
    folder
        Folder with the trials' .mat files.
    estimators
        Names with commas; default: h2, mekf and every peer installed.
    kit
        What recorded them.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    from robustnav.benchmark import broad as bench
    from robustnav.run.recorded import Sensors

    names = split(estimators) if estimators else bench.default_estimators()
    trials = bench.trial_files(folder)
    with progress("BROAD", len(trials) * len(names), quiet=quiet) as step:
        results = bench.benchmark_broad(folder, names, sensors=Sensors(kit.imu, kit.magnetometer), progress=step)
    if json:
        say_json(results)
        return
    say_table("RMSE by trial, degrees", bench.trial_rows(results))
    say_table("Mean RMSE over trials, degrees", bench.group_rows(results))
    if missing := results.get("missing_peers"):
        note(f"peers not installed: {', '.join(missing)}")


@benchmark.command
def speed(*, seconds: float = 1.0, json: Flag = False, quiet: Flag = False) -> None:
    """Time every estimator and every installed peer side by side, on one thread.

    Parameters
    ----------
    seconds
        Time spent on each row.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    from robustnav.benchmark import speed as bench

    with progress("timing", bench.steps_of(), quiet=quiet) as step:
        results = bench.benchmark_speed(seconds=seconds, progress=step)
    if json:
        say_json(results)
        return
    for title, rows in bench.tables(results):
        say_table(title, rows)


@benchmark.command
def mcu(
    *,
    cores: str = "m0+,m3,m4f,m7,m33",
    filters: str | None = None,
    peer_source: list[Path] | None = None,
    json: Flag = False,
    quiet: Flag = False,
) -> None:
    """Count what exported filters cost on Cortex-M cores under an emulator, beside peers compiled from their source.

    Parameters
    ----------
    cores
        Names with commas: m0+, m3, m4f, m7, m33.
    filters
        Names with commas; default: all.
    peer_source
        Folder with a peer's own sources: x-io Fusion or VQF; may be given twice.
    json
        Print one JSON document.
    quiet
        No progress bar.
    """
    import robustnav.benchmark.mcu as bench

    wanted, sources = bench.plan(split(filters) if filters else None, split(cores)), peer_source or []
    with progress("counting", bench.steps_of(wanted, sources), quiet=quiet) as step:
        results = bench.benchmark_mcu(wanted, peer_sources=sources, progress=step)
    if json:
        say_json(results)
        return
    say_table("Instructions an update (mean, most), bytes of flash, RAM (state and stack); -O2", bench.shown(results))
    note(results["about"])
