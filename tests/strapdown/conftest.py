"""A flight round the Earth in closed form, its sensors derived in inertial axes by CasADi: no navigation equation."""

from math import radians
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from robustnav.earth import EARTH_RATE, ECCENTRICITY_SQUARED, FLATTENING, GRAVITY_EQUATOR, SEMI_MAJOR
from robustnav.strapdown import ImuSamples, Navigation

NODES, WEIGHTS = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)]), np.array([5, 8, 5]) / 18


def _about(axis, angle):
    c, s = ca.cos(angle), ca.sin(angle)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }[axis]
    return ca.vertcat(*[ca.horzcat(*row) for row in rows])


def _flight(start_deg):
    t = ca.SX.sym("t")
    latitude = radians(start_deg) + 3e-5 * t + 2e-5 * ca.sin(0.21 * t)
    longitude = 0.3 + 2e-5 * t + 4e-5 * ca.cos(0.15 * t)
    height = 500 + 20 * ca.sin(0.3 * t) + 2 * t
    roll, pitch, yaw = 0.5 * ca.sin(0.9 * t), 0.3 * ca.sin(0.7 * t + 1), 1 + 0.2 * t + 0.4 * ca.sin(0.4 * t)
    s = ca.sin(latitude)
    transverse = SEMI_MAJOR / ca.sqrt(1 - ECCENTRICITY_SQUARED * s**2)
    r_e = ca.vertcat(
        (transverse + height) * ca.cos(latitude) * ca.cos(longitude),
        (transverse + height) * ca.cos(latitude) * ca.sin(longitude),
        (transverse * (1 - ECCENTRICITY_SQUARED) + height) * s,
    )
    C_en = _about("z", longitude) @ _about("y", -latitude - ca.pi / 2)
    C_nb = _about("z", yaw) @ _about("y", pitch) @ _about("x", roll)
    C_ie, spin = _about("z", EARTH_RATE * t), ca.vertcat(0, 0, EARTH_RATE)
    r_i, C_ib = C_ie @ r_e, C_ie @ C_en @ C_nb
    # gravity of a plumb line is gravitation and the centrifugal pull; only gravitation acts in inertial axes
    m = EARTH_RATE**2 * SEMI_MAJOR**2 * SEMI_MAJOR * (1 - FLATTENING) / 3.986004418e14
    surface = GRAVITY_EQUATOR * (1 + 0.00193185265241 * s**2) / ca.sqrt(1 - ECCENTRICITY_SQUARED * s**2)
    ratio = height / SEMI_MAJOR
    g = surface * (1 - 2 * (1 + FLATTENING + m - 2 * FLATTENING * s**2) * ratio + 3 * ratio**2)
    gravitation_i = C_ie @ C_en @ ca.vertcat(0, 0, g) + ca.cross(spin, ca.cross(spin, r_i))
    acceleration_i = ca.jacobian(ca.jacobian(r_i, t), t)
    force_b = C_ib.T @ (acceleration_i - gravitation_i)
    W = C_ib.T @ ca.reshape(ca.jacobian(ca.reshape(C_ib, 9, 1), t), 3, 3)
    rate_b = ca.vertcat(W[2, 1], W[0, 2], W[1, 0])
    v_n = C_en.T @ ca.jacobian(r_e, t)
    sensors = ca.Function("sensors", [t], [rate_b, force_b])
    state = ca.Function("state", [t], [ca.vertcat(roll, pitch, yaw), v_n, ca.vertcat(latitude, longitude, height)])
    return sensors, state


@pytest.fixture(scope="session")
def flight():
    """Make, for a latitude [deg], duration [s] and rate [Hz], exact samples and the true path at the samples' ends."""
    from robustnav.frames import quat_from_euler

    def make(start_deg, duration, rate_hz):
        sensors, state = _flight(start_deg)
        n, dt = round(duration * rate_hz), 1 / rate_hz
        nodes = ((np.arange(n)[:, None] + NODES) * dt).reshape(1, -1)
        angle, velocity = (
            dt * (np.array(values).T.reshape(n, 3, 3) * WEIGHTS[:, None]).sum(axis=1) for values in sensors(nodes)
        )
        euler, v_n, position = (np.array(values).T for values in state(np.arange(n + 1)[None, :] * dt))
        path = Navigation(quat_from_euler(euler), v_n, *position.T)
        return SimpleNamespace(
            samples=ImuSamples(angle, velocity, dt), start=Navigation.from_rows(path.rows()[0]), path=path
        )

    return make
