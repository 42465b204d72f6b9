"""The setting of the study of moving carriers: units, receivers, scenarios, and what the filters are told of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt

from robustnav import datasheet
from robustnav.datasheet.sensors import Imu, SensorSpec
from robustnav.models.inertial import InertialNoise
from robustnav.run.moving_setting import GnssAiding, InertialUnit
from robustnav.sim.moving import MovingKit, Receiver
from robustnav.sim.sensor_errors import ErrorSwitches
from robustnav.units import DEG, DEG_PER_HOUR, DPS, MILLI_G

RATE_HZ = 100.0
DURATION = 60.0  # s
LATITUDE = 47.0 * DEG
TIMES = (5.0, 10.0, 20.0, 30.0, 50.0)  # s at which errors and covariances are judged
SECONDS = tuple(float(t) for t in range(1, 60))  # at which they are drawn, TIMES among them
VELOCITY_SD, POSITION_SD = 0.1, 1.5
COMPASS_SD = 10.0 * DEG
ERRORS = ErrorSwitches(white_noise=True, random_walk=True, turn_on_bias=True)


@dataclass(frozen=True)
class Grade:
    """An inertial unit as it is simulated and as the filter is told of it."""

    imu: Imu
    unit: InertialUnit


def mems() -> Grade:
    """Return an MPU-9250 with its data sheet's noise, biases as a calibration leaves them: 0.3 deg/s and 0.15 m/s^2."""
    walks, biases = (1e-4 * DPS, 1e-4), (0.3 * DEG, 0.15)
    spec = datasheet.imu("mpu9250")
    gyro, accel = (
        replace(one, turn_on_bias_sd=bias, random_walk=walk)
        for one, bias, walk in zip((spec.gyro, spec.accel), biases, walks, strict=True)
    )
    unit = InertialUnit.from_datasheet(
        "mpu9250",
        gyro_bias_density=walks[0],
        accel_bias_density=walks[1],
        gyro_bias_sd=biases[0],
        accel_bias_sd=biases[1],
    )
    return Grade(replace(spec, gyro=gyro, accel=accel), unit)


def tactical() -> Grade:
    """Return a tactical unit: gyros of 0.5 deg/h and 0.05 deg per root hour, accelerometers of 1 mg."""
    noise = InertialNoise(0.05 * DEG / 60, 3e-4, 2e-9, 1e-6)
    unit = InertialUnit(noise, 0.5 * DEG_PER_HOUR, MILLI_G)
    gyro = SensorSpec(
        density=sqrt(2) * noise.gyro_density, random_walk=noise.gyro_bias_density, turn_on_bias_sd=unit.gyro_bias_sd
    )
    accel = SensorSpec(
        density=sqrt(2) * noise.accel_density, random_walk=noise.accel_bias_density, turn_on_bias_sd=unit.accel_bias_sd
    )
    return Grade(Imu("tactical", gyro, accel, "figures of no particular unit"), unit)


@dataclass(frozen=True)
class MovingScenario:
    """A carrier by its ``way``, its unit's ``grade``, its ``receiver`` and what of it is used."""

    way: str
    grade: Grade
    receiver: Receiver
    aiding: GnssAiding
    compass: bool = False

    @property
    def kit(self) -> MovingKit:
        """What is carried."""
        return MovingKit(self.grade.imu, ERRORS, self.receiver, COMPASS_SD if self.compass else None)


def scenarios() -> dict[str, MovingScenario]:
    """Return the scenarios by name."""
    good = Receiver(velocity_sd=VELOCITY_SD, position_sd=POSITION_SD)
    bad = replace(good, outages=((15.0, 25.0),), outlier_share=0.1)
    arm = replace(good, lever_b=(0.3, -0.2, -0.5), delay=0.12)
    both, velocity = GnssAiding(VELOCITY_SD, POSITION_SD), GnssAiding(VELOCITY_SD)
    position = GnssAiding(position_sd=POSITION_SD)
    out = {
        f"{way}, {name}": MovingScenario(way, grade, good, both)
        for name, grade in (("MEMS", mems()), ("tactical", tactical()))
        for way in ("drone", "car")
    }
    small = mems()
    return out | {
        "drone, velocity only": MovingScenario("drone", small, good, velocity),
        "car, velocity only": MovingScenario("car", small, good, velocity),
        "drone, position only": MovingScenario("drone", small, good, position),
        "car, position only": MovingScenario("car", small, good, position),
        "drone, 10 % outliers, 10 s outage": MovingScenario("drone", small, bad, both),
        "car, compass 10 deg": MovingScenario("car", small, good, replace(both, heading_sd=COMPASS_SD), compass=True),
        "car, lever arm, 0.12 s late": MovingScenario(
            "car", small, arm, replace(both, lever_b=arm.lever_b, delay=arm.delay)
        ),
    }
