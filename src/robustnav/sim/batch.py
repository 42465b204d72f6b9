"""Many runs of one motion through one set of sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.datasheet.sensors import Imu, Magnetometer, SensorSpec
from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.records import Log, Stream, Truth
from robustnav.sim.imu import true_gyro, true_specific_force
from robustnav.sim.magnetometer import every, true_field
from robustnav.sim.sensor_errors import Draws, ErrorSwitches, Sampled, active, corrupt
from robustnav.sim.trajectory import Motion, Trajectory


@dataclass(frozen=True)
class Environment:
    """The place: gravity [m/s^2], magnetic field (3,) in NED [T], and the north that ``n`` refers to.

    Raises
    ------
    InputError : gravity is not positive, the field is not three finite numbers, or magnetic-north axes with a field
        that points east or west.
    """

    gravity: float
    field_n: tuple[float, float, float]
    north: str = "magnetic"

    def __post_init__(self) -> None:
        if not 0 < self.gravity < np.inf:
            raise InputError("gravity", got=f"{self.gravity}", expected="a positive number of m/s^2")
        if np.shape(self.field_n) != (3,) or not np.all(np.isfinite(self.field_n)) or not np.any(self.field_n):
            raise InputError("magnetic field", got=str(self.field_n), expected="three finite numbers, not all zero [T]")
        if self.north not in ("magnetic", "true"):
            raise InputError("north", got=repr(self.north), expected="'magnetic' or 'true'")
        if self.north == "magnetic" and self.field_n[1] != 0:
            raise InputError(
                "magnetic field in magnetic-north axes",
                got=f"{self.field_n[1]} T east",
                expected="no east component",
                do="say north='true', or turn the field by the declination",
            )


@dataclass(frozen=True)
class Sensors:
    """What is carried: IMU, magnetometer or None, its rate [Hz] or None for the IMU's, and the errors simulated."""

    imu: Imu
    magnetometer: Magnetometer | None
    errors: ErrorSwitches
    magnetometer_rate_hz: float | None = None


@dataclass(frozen=True)
class Batch:
    """Simulated runs of one motion.

    Parameters
    ----------
    runs : numbers of the runs, in the order of the first axis below.
    t, q_nb : (n,) [s] and (n, 4), the truth, the same in every run.
    gyro, accel : (runs, n, 3) readings [rad/s], [m/s^2].
    gyro_bias : (runs, n, 3) true gyro bias [rad/s].
    t_mag, mag : (m,) [s] and (runs, m, 3) [T]; m = 0 without a magnetometer.
    conventions : what was simulated, one line a sensor.
    north : which north the truth refers to.
    """

    runs: range
    t: Array
    q_nb: Array
    gyro: Array
    accel: Array
    gyro_bias: Array
    t_mag: Array
    mag: Array
    conventions: tuple[str, ...]
    north: str

    def log(self, run: int) -> Log:
        """Return one run as a recording with its truth.

        Raises
        ------
        InputError : ``run`` is not among ``runs``.
        """
        if run not in self.runs:
            raise InputError("run of a batch", got=f"{run}", expected=f"{self.runs[0]} to {self.runs[-1]}")
        row = self.runs.index(run)
        streams = {
            "gyro": Stream("gyro", self.t, self.gyro[row], "rad/s"),
            "accel": Stream("accel", self.t, self.accel[row], "m/s^2"),
        }
        if len(self.t_mag):
            streams["mag"] = Stream("mag", self.t_mag, self.mag[row], "T")
        truth = Truth(self.t, self.q_nb, kind="simulated", north=self.north, accuracy="exact")
        return Log(streams, f"simulation, run {run}", self.conventions, truth=truth)


def simulate(
    trajectory: Trajectory, sensors: Sensors, environment: Environment, *, runs: int | range, seed: int
) -> Batch:
    """Simulate sensors along a motion.

    Parameters
    ----------
    trajectory : the motion; the IMU samples at its rate.
    sensors, environment : what is carried, and where.
    runs : how many, numbered from 0, or the numbers themselves.  Run i is the same however many are drawn, so a large
        study can be simulated in parts: ``range(0, 100)``, ``range(100, 200)`` ...
    seed : not negative; together with the run number it fixes every random number.

    Raises
    ------
    InputError : no runs, a negative seed or run number, a magnetometer rate that does not divide the motion's rate, or
        white noise wanted from a sensor without a noise figure.
    """
    numbers = run_numbers(runs, seed)
    motion = trajectory.sample()

    def read(name: str, spec: SensorSpec, true: Array, rate_hz: float) -> tuple[Array, Array]:
        return corrupt(true, Sampled(spec, sensors.errors, rate_hz, Draws(seed, numbers, name)))

    gyro, gyro_bias = read("gyro", sensors.imu.gyro, true_gyro(motion), motion.rate_hz)
    force = true_specific_force(motion, environment.gravity)
    accel, _ = read("accel", sensors.imu.accel, force, motion.rate_hz)
    t_mag, mag = np.zeros(0), np.zeros((len(numbers), 0, 3))
    if sensors.magnetometer is not None:
        stride = _stride(sensors, motion)
        t_mag, field = motion.t[::stride], true_field(motion.q_nb[::stride], np.asarray(environment.field_n))
        mag, _ = read("mag", sensors.magnetometer.field, field, motion.rate_hz / stride)
    conventions = _conventions(sensors, motion)
    return Batch(numbers, motion.t, motion.q_nb, gyro, accel, gyro_bias, t_mag, mag, conventions, environment.north)


def run_numbers(runs: int | range, seed: int) -> range:
    """Return the numbers of ``runs``, or raise ``InputError`` for no run, a negative number or a negative seed."""
    numbers = runs if isinstance(runs, range) else range(runs)
    if not numbers or min(numbers) < 0:
        raise InputError("runs", got=str(runs), expected="at least one run, numbered from 0 up")
    if seed < 0:
        raise InputError("seed", got=f"{seed}", expected="a whole number, not negative")
    return numbers


def _stride(sensors: Sensors, motion: Motion) -> int:
    return 1 if sensors.magnetometer_rate_hz is None else every(motion, sensors.magnetometer_rate_hz)


def _conventions(sensors: Sensors, motion: Motion) -> tuple[str, ...]:
    imu, magnetometer = sensors.imu, sensors.magnetometer
    rows = [("gyro", imu.name, imu.gyro, "mean rate over the interval that ends at t")]
    rows += [("accel", imu.name, imu.accel, "specific force at t")]
    if magnetometer is not None:
        rows += [("mag", magnetometer.name, magnetometer.field, "field at t")]
    return tuple(
        f"{sensor} of {name}: {what}; errors: {', '.join(_applied(spec, sensors.errors)) or 'none'}"
        for sensor, name, spec, what in rows
    )


def _applied(spec: SensorSpec, errors: ErrorSwitches) -> list[str]:
    return ["white_noise"] * errors.white_noise + list(active(spec, errors))
