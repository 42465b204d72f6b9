"""The covariance is honest: errors and innovations over many runs lie in their chi-square bands."""

from types import SimpleNamespace

import numpy as np
import pytest

from robustnav.engine import CompiledModel, SensorData
from robustnav.evaluate import consistency, nees
from robustnav.run import EKF, H2, UKF, covariance_of, stream
from robustnav.sim.trajectory import SineAttitude
from robustnav.units import DEG

RUNS = 300
START_SD = {"q_nb": 1 * DEG, "gyro_bias": 0.1 * DEG}
MOVING = SineAttitude((40 * DEG, 30 * DEG, 60 * DEG), (0.9, 1.3, 0.5), (0.3, 1.0, 0.0), 12.0, 50.0)
AT_REST = SineAttitude((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), 12.0, 50.0)
# A constant gain knows no turn: what it claims of its start-up holds at rest; under way it claims 4 % too little
# of the gyro bias, which turns with the body while the gain takes it for fixed, and the truth of the attitude.
CASES = {
    "mekf": (MOVING, lambda s: EKF(s.model)),
    "ukf": (MOVING, lambda s: UKF(s.model)),
    "h2, steady, at rest": (AT_REST, lambda s: H2(s.model, s.rate_hz, start_sd="steady")),
    "h2, steady, moving": (MOVING, lambda s: H2(s.model, s.rate_hz, start_sd="steady")),
    "h2, starting at rest": (AT_REST, lambda s: H2(s.model, s.rate_hz, start_sd=START_SD, sets=200)),
}


@pytest.fixture(scope="module")
def simulated(setting):
    return {motion: setting(motion, RUNS) for motion in (MOVING, AT_REST)}


@pytest.fixture(scope="module", params=CASES)
def runs(request, simulated, drawn_start):
    """Errors and covariances (runs, steps, ...) at every tenth step, NIS of both sensors."""
    motion, make = CASES[request.param]
    one = simulated[motion]
    estimator, batch, difference = make(one), one.batch, CompiledModel(one.model).difference
    P = estimator.table.covariance[-1] if "steady" in request.param else None
    errors, covariances, nis = [], [], []
    for k in batch.runs:
        readings = [SensorData(batch.t, batch.accel[k]), SensorData(batch.t_mag, batch.mag[k])]
        out = stream(estimator, drawn_start(one.model, batch, k, P)).run(batch.t, batch.gyro[k], readings)
        truth = np.hstack([batch.q_nb, batch.gyro_bias[k]])
        errors.append([difference(truth[i], out.x[i]) for i in range(0, len(batch.t), 10)])
        covariances.append(covariance_of(estimator, batch.t, batch.gyro[k], out)[::10])
        nis.append([seen.nis[::10] for seen in out.seen])
    return SimpleNamespace(kind=request.param, e=np.array(errors), P=np.array(covariances), nis=np.array(nis))


def honest(test):
    return test.low < test.mean < test.high and test.inside > 0.85


PARTS = {"whole error": slice(0, 6), "attitude": slice(0, 3), "gyro bias": slice(3, 6)}


@pytest.mark.parametrize("part", PARTS)
def test_errors_are_what_the_covariance_says(runs, part):
    rows = PARTS[part]
    e, P = runs.e[..., rows], runs.P[..., rows, rows]
    test = consistency(nees(e, P), rows.stop - rows.start)
    if runs.kind == "h2, steady, moving" and part != "attitude":
        assert test.dof < test.mean < 1.1 * test.dof, test
        return
    assert honest(test), test
    too_small = consistency(nees(e, 0.85 * P), rows.stop - rows.start)
    assert not honest(too_small), "the test must see a covariance 15 % too small"


def test_innovations_are_what_the_filter_predicts(runs):
    for j, rows in enumerate((3, 3) if runs.kind == "ukf" else (2, 3)):
        if runs.kind.startswith("h2"):
            assert np.isnan(runs.nis[:, j]).all()  # a constant gain predicts none
            continue
        test = consistency(runs.nis[:, j], rows)
        assert honest(test), (j, test)
        assert not honest(consistency(runs.nis[:, j] / 0.85, rows))
