"""``run`` on ranges: follow a tag among anchors and say how it went."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from robustnav.cli.options import Flag
from robustnav.cli.show import note, say, say_json, say_settings, say_table
from robustnav.errors import InputError

if TYPE_CHECKING:
    from robustnav.records import Run

Weighting = Literal["student", "huber", "gate"]


@Parameter(name="*")
@dataclass(frozen=True)
class Ranging:
    """Ranges instead of an inertial recording."""

    anchors: Path | None = None
    """Survey of the anchors (TOML): LOG is then a table of ranges, t_s, anchor, distance_m."""
    calibration: Path | None = None
    """What `calibrate uwb` wrote, applied to the ranges first."""
    radio: str = "dw1000"
    """Radio preset: dw1000."""
    carrier: str = "drone"
    """How the tag moves: drone, walker or cart."""
    height: float | None = None
    """Known height of the tag [m], up."""
    plane: Flag = False
    """With --height: estimate two coordinates only."""
    time_offset: float = 0.0
    """How late the stamps of the ranges are [s]."""
    outliers: Weighting = "student"
    """What ranges far off count for."""
    white: Flag = False
    """White noise only: estimate no bias of each anchor."""
    smooth: Annotated[bool, Parameter(negative="")] = False
    """Smooth over the whole recording."""


RANGING = Ranging()


def run_ranges(log: Path, given: Ranging, *, backend: str, out: Path | None, json: bool) -> int:
    """Follow the tag of a range table and print the outcome; the arguments are those of ``run``."""
    result = _tracked(log, given, backend)
    if out is not None:
        from robustnav.report.run_table import write_run

        note(f"table: {write_run(result, out / 'estimate.csv')}")
    if json:
        say_json(_document(result))
        return 0
    from robustnav.report.verdict import innovation_rows

    last = ", ".join(f"{v:.2f}" for v in result.state["p_n"][-1])
    doubt = ", ".join(f"{v:.2f}" for v in result.sd["p_n"][-1])
    say(f"{result.estimator} on {log}: {len(result.t)} positions from {result.t[0]:.2f} to {result.t[-1]:.2f} s")
    say(f"last at ({last}) m, sd ({doubt}) m, in the survey's axes with z down")
    say_table("Innovations", innovation_rows(result.innovations))
    for event in result.events:
        say(f"  {event}")
    say("\nSettings")
    say_settings(result.settings)
    if out is None:
        note("next: --out out/run writes every position with its standard deviation")
    return 0


def _tracked(log: Path, given: Ranging, backend: str) -> Run:
    from robustnav.calibrate import read_calibration
    from robustnav.filter.weighting import Gate, Huber, Rule, StudentT
    from robustnav.logs.uwb_table import read_uwb_table
    from robustnav.models import carrier_named, radio_named, uwb_of
    from robustnav.run.acquisition import Acquisition
    from robustnav.run.tracking import ranging_ekf, track

    if given.anchors is None:
        raise InputError("ranges", expected="a survey of the anchors", do="--anchors anchors.toml")
    if given.plane and given.height is None:
        raise InputError("--plane", got="no --height", expected="the height the tag moves at", do="--height METRES")
    ranges = read_uwb_table(log, given.anchors).ranges
    if given.calibration is not None:
        ranges = read_calibration(given.calibration).apply(ranges)
    carrier = carrier_named(given.carrier)
    down = -given.height if given.plane and given.height is not None else None
    model = uwb_of(
        radio_named(given.radio), carrier, bias=not given.white, tag_down=down, time_offset=given.time_offset
    )
    rules: dict[str, Rule] = {"student": StudentT(), "huber": Huber(), "gate": Gate.probability(0.997)}
    return track(
        ranging_ekf(model, rules[given.outliers]),
        ranges,
        height=None if given.plane else given.height,
        acquisition=Acquisition(speed=carrier.speed),
        smooth=given.smooth,
        backend=backend,
    )


def _document(result: Run) -> dict[str, object]:
    from robustnav.report.verdict import innovation_rows

    return {
        "estimator": result.estimator,
        "model": result.model,
        "samples": len(result.t),
        "start_s": result.t[0],
        "innovations": innovation_rows(result.innovations),
        "events": result.events,
        "settings": result.settings,
        "final": {name: values[-1] for name, values in result.state.items()},
        "final_sd": {name: values[-1] for name, values in result.sd.items()},
    }
