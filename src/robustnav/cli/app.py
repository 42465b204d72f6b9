"""The command ``robustnav``: its verbs, exit codes and the way errors are shown.

Exit codes: 0 done, 2 bad input or usage, 3 an estimator or design that fails its own checks, 130 interrupted.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App

from robustnav import __version__
from robustnav.cli import (
    alignment,
    benchmarks,
    designs,
    exports,
    moving,
    ranging,
    ranging_survey,
    recordings,
    studies,
    uwb_benchmarks,
)
from robustnav.cli.show import complain
from robustnav.errors import RobustnavError

app = App(
    name="robustnav",
    help="Robust state estimators for small drones and inertial navigation.",
    version=__version__,
    result_action="return_value",
)
simulate = App(name="simulate", help="Simulate a unit on a vehicle that turns, on a carrier to align, or in motion.")
simulate.default(studies.simulate)
simulate.command(alignment.simulate_alignment, name="alignment")
simulate.command(moving.simulate_moving, name="moving")
studies.demo.command(moving.moving)
app.command(studies.demo)
app.command(recordings.doctor)
app.command(simulate)
app.command(ranging.calibrate)
app.command(ranging_survey.survey)
app.command(ranging.gdop)
app.command(designs.design)
app.command(recordings.run)
app.command(alignment.align)
app.command(recordings.compare)
app.command(benchmarks.benchmark)
for one in uwb_benchmarks.COMMANDS:
    benchmarks.benchmark.command(one)
benchmarks.benchmark.command(moving.benchmark_moving, name="moving")
app.command(recordings.report)
app.command(exports.export)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    try:
        code = app(sys.argv[1:] if arguments is None else list(arguments))
    except RobustnavError as error:
        return complain(error)
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return code if isinstance(code, int) else 0
