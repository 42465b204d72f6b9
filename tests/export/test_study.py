"""The exported float filters in the attitude study's cases: as accurate as the double filters in Python."""

import numpy as np
import pytest

from robustnav.frames import rotation_error
from robustnav.run.ensemble import run_ensemble
from robustnav.sim.trajectory import case_one, case_two
from robustnav.studies.attitude_runs import readings, simulated, start_errors, starts
from robustnav.studies.attitude_setting import lineup

SEEDS = 4


def flown(filter_, batch, start, i):
    """Return the attitudes (n, 4) of an exported filter over the i-th run of a batch."""
    assert filter_.call("reset", start.x[:4], start.x[4:]) == 0
    dt = np.diff(batch.t, prepend=batch.t[0])
    q = np.empty((len(batch.t), 4))
    for k, step in enumerate(dt):
        assert filter_.call("update", float(step), batch.gyro[i, k], batch.accel[i, k], batch.mag[i, k]) == 0
        q[k] = filter_.state[:4]
    return q


@pytest.mark.parametrize("protocol", ["warm", "cold"])
@pytest.mark.parametrize("case", ["I", "II"])
def test_rms_within_two_per_cent_of_python(case, protocol, loaded):
    trajectory = {"I": case_one, "II": case_two}[case]()
    batch = simulated(trajectory, SEEDS, seed=11)
    line = lineup(protocol, 100.0)
    estimator = line.estimators["h2"]
    begin = starts(estimator.model, batch, line.told, start_errors(line.drawn, SEEDS, 11))
    python = run_ensemble(estimator, readings(batch), begin).x[..., :4]
    c = loaded("nine_cold" if protocol == "cold" else "nine")
    exported = np.array([flown(c, batch, begin[i], i) for i in range(SEEDS)])
    rms = [np.sqrt(np.mean(rotation_error(q, np.broadcast_to(batch.q_nb, q.shape)) ** 2)) for q in (exported, python)]
    assert rms[0] == pytest.approx(rms[1], rel=0.02)
    apart = np.sqrt(np.mean(rotation_error(exported, python) ** 2))
    assert apart < 0.05 * rms[1]  # of which the RMS feels a thousandth
