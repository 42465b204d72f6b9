"""A simulated alignment as a recording: what the unit and the reference report, and the truth."""

from __future__ import annotations

import numpy as np

from robustnav.records import Log, Stream
from robustnav.sim.alignment import Preintegrate, simulate_alignment, simulate_unit
from robustnav.sim.alignment_scenario import Scenario
from robustnav.strapdown.preintegration import preintegrate
from robustnav.units import DEG


def alignment_log(scenario: Scenario, seed: int, preintegrate: Preintegrate = preintegrate) -> Log:
    """Return one run of ``simulate_alignment`` as it would be recorded; arguments and errors as there.

    ``gyro`` and ``accel`` are means over the sample before each stamp, ``velocity`` is the reference in the wind.
    """
    run, samples = simulate_alignment(scenario, seed, preintegrate), simulate_unit(scenario, seed).samples
    t = np.arange(1, len(samples) + 1) / scenario.imu_rate_hz
    streams = (
        Stream("gyro", t, samples.angle / samples.dt, "rad/s"),
        Stream("accel", t, samples.velocity / samples.dt, "m/s^2"),
        run.velocity,
    )
    return Log(
        {stream.name: stream for stream in streams},
        source=f"{scenario.name}, seed {seed}",
        conventions=("gyro and accel: means over the sample before each stamp",),
        truth=run.truth,
        info={"latitude_deg": scenario.latitude / DEG, "height_m": scenario.height},
    )
