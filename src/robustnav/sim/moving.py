"""A carrier that moves with an inertial unit and a satellite receiver, on a rotating Earth, from anywhere on its way.

The inertial unit gives means over its intervals, as units that integrate do.  The navigation axes stand on the Earth,
so its gyros feel the Earth's rate and its accelerometers the Coriolis acceleration; gravity is the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees

import numpy as np

from robustnav.datasheet.sensors import Imu
from robustnav.earth import earth_rate_n, normal_gravity
from robustnav.errors import InputError
from robustnav.frames import Array, euler_from_quat, quat_conjugate, quat_from_rotvec, quat_multiply, rotate, wrap_angle
from robustnav.records import Log, Stream
from robustnav.sim.ranging_path import States
from robustnav.sim.sensor_errors import Draws, ErrorSwitches, Sampled, corrupt
from robustnav.sim.trajectory import motion_from_attitude

_FAR = 30.0  # size of an outlier in standard deviations


@dataclass(frozen=True)
class Receiver:
    """A satellite receiver.

    Parameters
    ----------
    rate_hz : of its readings [Hz].
    velocity_sd, position_sd : white, on each axis [m/s], [m].
    lever_b : (3,) from the inertial unit to the antenna [m].
    delay : how late its stamps are [s].
    outages : begins and ends [s] between which there is no reading.
    outlier_share : of the readings, velocity and position each, that are off by 30 standard deviations and more.

    Raises
    ------
    InputError : a number out of its range.
    """

    rate_hz: float = 5.0
    velocity_sd: float = 0.1
    position_sd: float = 1.5
    lever_b: tuple[float, float, float] = (0.0, 0.0, 0.0)
    delay: float = 0.0
    outages: tuple[tuple[float, float], ...] = ()
    outlier_share: float = 0.0

    def __post_init__(self) -> None:
        positive = (self.rate_hz, self.velocity_sd, self.position_sd)
        if not (all(0 < v < np.inf for v in positive) and 0 <= self.outlier_share < 1 and np.isfinite(self.delay)):
            got = f"{positive}, outlier share {self.outlier_share}, delay {self.delay}"
            raise InputError("receiver", got=got, expected="positive numbers, a share below one, a finite delay")


@dataclass(frozen=True)
class MovingKit:
    """What is carried: an inertial unit with the errors simulated, a receiver, and a compass wrong by ``compass_sd``.

    The compass errs by one constant of that size [rad]; None: there is none.
    """

    imu: Imu
    errors: ErrorSwitches
    receiver: Receiver
    compass_sd: float | None = None


def simulate_moving(states: States, kit: MovingKit, *, latitude: float, seed: int) -> Log:
    """Return a recording with streams ``gyro``, ``accel``, ``gnss_velocity``, ``gnss_position`` and its truth.

    Parameters
    ----------
    states : the way, evenly sampled at the rate of the inertial unit; see ``moving_ways``.
    kit : what is carried.
    latitude : geodetic [rad], in ``info`` as ``latitude_deg``.
    seed : fixes every random number.

    Raises
    ------
    InputError : times that are not even, or white noise wanted of a unit without a noise figure.
    """
    gyro, accel = true_increments(states, latitude)
    rate_hz = (len(states.t) - 1) / float(states.t[-1] - states.t[0])

    def read(name: str, true: Array) -> Array:
        sensor = Sampled(getattr(kit.imu, name), kit.errors, rate_hz, Draws(seed, range(1), name))
        readings: Array = corrupt(true, sensor)[0][0]
        return readings

    rng = np.random.default_rng([seed, 7])
    streams = [
        Stream("gyro", states.t, read("gyro", gyro), "rad/s"),
        Stream("accel", states.t, read("accel", accel), "m/s^2"),
        *_gnss(states, kit.receiver, rng),
    ]
    if kit.compass_sd is not None:
        yaw = euler_from_quat(states.q_nb)[::10, 2:] + rng.normal(0, kit.compass_sd)
        streams.append(Stream("heading", states.t[::10], wrap_angle(yaw), "rad", "n"))
    said = "gyro and accel: means over the interval that ends at t", "n: axes on the Earth, true north"
    info = {"latitude_deg": degrees(latitude)}
    return Log({s.name: s for s in streams}, f"simulation, seed {seed}", said, truth=states.truth("true"), info=info)


def true_increments(states: States, latitude: float) -> tuple[Array, Array]:
    """Return mean body rate (n, 3) [rad/s] and mean specific force (n, 3) [m/s^2] over the intervals that end at t.

    Row 0, with no interval before it, repeats row 1.
    """
    motion = motion_from_attitude(states.t, states.q_nb)
    dt = np.diff(states.t)[:, None]
    middle = quat_multiply(states.q_nb[:-1], quat_from_rotvec(motion.omega_b[1:] * dt / 2))
    rate_n = earth_rate_n(latitude)
    v_n = (states.v_n[1:] + states.v_n[:-1]) / 2
    force_n = np.diff(states.v_n, axis=0) / dt - [0.0, 0.0, normal_gravity(latitude)] + 2 * np.cross(rate_n, v_n)
    accel = rotate(quat_conjugate(middle), force_n)
    gyro = motion.omega_b[1:] + rotate(quat_conjugate(middle), rate_n)
    return np.vstack([gyro[:1], gyro]), np.vstack([accel[:1], accel])


def _gnss(states: States, receiver: Receiver, rng: np.random.Generator) -> list[Stream]:
    t = np.arange(states.t[0] + 0.5 / receiver.rate_hz, states.t[-1], 1 / receiver.rate_hz)
    k = np.searchsorted(states.t, t)
    lever_b = np.asarray(receiver.lever_b)
    true = {
        "velocity": states.v_n[k] + rotate(states.q_nb[k], np.cross(states.omega_b[k], lever_b)),
        "position": states.p_n[k] + rotate(states.q_nb[k], lever_b),
    }
    heard = np.ones(len(t), bool)
    for begin, end in receiver.outages:
        heard &= (t < begin) | (t > end)
    out = []
    for name, unit in (("velocity", "m/s"), ("position", "m")):
        sd = getattr(receiver, f"{name}_sd")
        values = true[name] + rng.normal(0, sd, true[name].shape)
        wrong = rng.random(len(t)) < receiver.outlier_share
        values[wrong] += sd * _FAR * rng.standard_normal((int(wrong.sum()), 3))
        out.append(Stream(f"gnss_{name}", states.t[k][heard] + receiver.delay, values[heard], unit, "n"))
    return out
