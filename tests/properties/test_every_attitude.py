"""The quaternion filters hold at every attitude; the published Euler form does not, and this says where.

The sensors are those of a vibrating multicopter, whose gains are large enough to show it within minutes.  The figures
printed here (``pytest -s``) stand in docs/models.md, section 3.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from robustnav.evaluate.attitude import attitude_errors
from robustnav.frames import euler_from_quat, quat_from_euler
from robustnav.run import EKF, H2, UKF, Start, run
from robustnav.sim.trajectory import full_roll_and_pitch, motion_from_attitude, steady_turn
from robustnav.units import DEG, DPS

RUNS = 2


@dataclass(frozen=True)
class Standing:
    """Level and still at one heading [rad]."""

    heading: float
    duration: float = 200.0

    def sample(self):
        t = np.arange(self.duration * 100 + 1) / 100
        return motion_from_attitude(t, np.tile(quat_from_euler(np.array([0, 0, self.heading])), (len(t), 1)))


MOTIONS = {
    "roll and loop": full_roll_and_pitch(10.0),
    "turn": steady_turn(20 * DPS, 600.0),
    "south": Standing(180 * DEG),
}
QUATERNION = {
    "mekf": lambda s: EKF(s.model),
    "ukf": lambda s: UKF(s.model),
    "h2": lambda s: H2(s.model, 100.0),
    "h2 steady": lambda s: H2(s.model, 100.0, start_sd="steady"),
}


@pytest.fixture(scope="module")
def simulated(setting):
    return {name: setting(motion, RUNS, vibrating=True) for name, motion in MOTIONS.items()}


def rms_deg(one, make, parts=5):
    """RMS of the whole attitude error [deg] over the runs, by fifths of the time; started at the truth."""
    estimator, q_nb = make(one), one.batch.q_nb[0]
    block = {"q_nb": q_nb} if estimator.model.rotation else {"euler": euler_from_quat(q_nb)}
    start = Start.at(estimator.model, gyro_bias=0.0, **block)
    logs = [one.batch.log(k) for k in one.batch.runs]
    total = np.array([attitude_errors(run(estimator, log, start), log.truth).total / DEG for log in logs])
    return [float(np.sqrt(np.mean(part**2))) for part in np.array_split(total, parts, axis=1)]


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("make", QUATERNION.values(), ids=QUATERNION)
def test_quaternion_filters_hold_everywhere(simulated, motion, make):
    assert rms_deg(simulated[motion], make, parts=1)[0] < 0.5


@pytest.mark.parametrize(("motion", "least"), [("turn", 60), ("south", 150)])
def test_one_gain_in_body_axes_loses_its_heading(simulated, motion, least):
    """Beyond +-90 deg of yaw the gain designed at north pushes the heading the wrong way: the error grows."""
    error = rms_deg(simulated[motion], lambda s: H2(s.euler, 100.0, start_sd="steady"))
    print(f"\n{motion}: h2-euler {np.round(error, 1)} deg")
    assert error[4] > least and error[4] > error[2] > error[0]


def test_the_euler_ekf_follows_the_turn_but_not_the_loop(simulated):
    """It linearises at every step, so no heading is special; pitch +-90 deg still is."""
    turn = rms_deg(simulated["turn"], lambda s: EKF(s.euler), parts=1)[0]
    loop = {n: rms_deg(simulated["roll and loop"], make)[4] for n, make in EULER.items()}
    print(f"\nturn: ekf-euler {turn:.2f} deg; end of the loop: {loop}")
    assert turn < 0.5
    assert loop["h2-euler"] > 2 * loop["mekf"]


EULER = {
    "mekf": QUATERNION["mekf"],
    "ekf-euler": lambda s: EKF(s.euler),
    "h2-euler": lambda s: H2(s.euler, 100.0, start_sd="steady"),
}
