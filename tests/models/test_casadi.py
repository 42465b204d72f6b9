"""The attitude models written a second time with CasADi, whose derivatives are not ours.

State, rates and sensors are typed again from the definitions: quaternion kinematics q' = q (0, omega) / 2 and the
rotation matrix as a product of quaternions, or the three Euler rotations.  The error's rate is differentiated on the
manifold, from the error as a quotient of two states.
"""

import casadi as ca
import numpy as np
import pytest

from robustnav.engine import CompiledModel
from robustnav.model import NumericModel
from robustnav.models import AttitudeNoise, attitude, attitude_euler
from robustnav.units import STANDARD_GRAVITY

NOISE = AttitudeNoise(2e-3, 1e-4, 0.05, 4e-7, 3e-3)
FIELD, DIP_DEG = 4.8e-5, 60.0
GRAVITY_N = ca.DM([0, 0, -STANDARD_GRAVITY])
FIELD_N = FIELD * ca.DM([np.cos(np.radians(DIP_DEG)), 0, np.sin(np.radians(DIP_DEG))])
DT = 0.01
q, bias, gyro, e = ca.SX.sym("q", 4), ca.SX.sym("bias", 3), ca.SX.sym("gyro", 3), ca.SX.sym("e", 6)
w, euler, dt = ca.SX.sym("w", 9), ca.SX.sym("euler", 3), ca.SX.sym("dt")


def times(a, b):
    av, bv = a[1:], b[1:]
    return ca.vertcat(a[0] * b[0] - ca.dot(av, bv), a[0] * bv + b[0] * av + ca.cross(av, bv))


def conjugate(a):
    return ca.vertcat(a[0], -a[1:])


def into_body(a, v_n):
    return times(times(conjugate(a), ca.vertcat(0, v_n)), a)[1:]


def into_navigation(a, v_b):
    return times(times(a, ca.vertcat(0, v_b)), conjugate(a))[1:]


def turned(a, small):
    moved = times(ca.vertcat(1, small / 2), a)
    return moved / ca.norm_2(moved)


def whole_turn(phi):
    angle = ca.norm_2(phi)
    return ca.vertcat(ca.cos(angle / 2), ca.sin(angle / 2) * phi / angle)


class Quaternion:
    """q_nb and bias; error in navigation axes."""

    def __init__(self):
        self.model = attitude(NOISE, field=FIELD, dip_deg=DIP_DEG)
        rate = gyro - bias
        q_true, bias_true = turned(q, e[:3]), bias + e[3:]
        rate_true = gyro - bias_true - w[:3] - ca.norm_2(gyro - bias_true) * w[6:9]
        part = times(q_true, conjugate(q))
        flow = times(q_true, ca.vertcat(0, rate_true)) / 2
        back = times(q, ca.vertcat(0, rate)) / 2
        part_rate = times(flow, conjugate(q)) + times(q_true, conjugate(back))
        theta_rate = 2 * (part_rate[1:] * part[0] - part[1:] * part_rate[0]) / part[0] ** 2
        e_rate = ca.vertcat(theta_rate, w[3:6])
        still = [e, w], [ca.DM.zeros(6), ca.DM.zeros(9)]
        A, G = (ca.substitute([ca.jacobian(e_rate, s)], *still)[0] for s in (e, w))
        self.A, self.G = ca.Function("A", [q, bias, gyro], [A]), ca.Function("G", [q, bias, gyro], [G])
        self.f = ca.Function("f", [q, bias, gyro, dt], [ca.vertcat(times(q, whole_turn(rate * dt)), bias)])
        self.h, self.H = [], []
        for v in (GRAVITY_N, FIELD_N):
            self.h.append(ca.Function("h", [q, bias], [into_body(q, v)]))
            predicted = into_navigation(q, into_body(q_true, v))  # what a reading at x [+] e shows in navigation axes
            H = ca.substitute([ca.jacobian(predicted, e)], *still)[0]
            self.H.append(ca.Function("H", [q, bias], [H]))

    def arguments(self, x):
        return x[:4], x[4:]


class Euler:
    """Roll, pitch, yaw and bias; error by difference."""

    def __init__(self):
        self.model = attitude_euler(NOISE, field=FIELD, dip_deg=DIP_DEG)
        x, u = ca.vertcat(euler, bias), gyro - bias - w[:3]
        roll, pitch = euler[0], euler[1]
        # body rate of roll', pitch', yaw' in their own axes; solved, not typed from a table
        axes = ca.horzcat(
            ca.DM([1, 0, 0]),
            ca.vertcat(0, ca.cos(roll), -ca.sin(roll)),
            ca.vertcat(-ca.sin(pitch), ca.sin(roll) * ca.cos(pitch), ca.cos(roll) * ca.cos(pitch)),
        )
        rate = ca.vertcat(ca.solve(axes, u), w[3:6])
        none = [w], [ca.DM.zeros(9)]
        A, G, mean = ca.substitute([ca.jacobian(rate, x), ca.jacobian(rate, w[:6]), rate], *none)
        self.A, self.G = ca.Function("A", [euler, bias, gyro], [A]), ca.Function("G", [euler, bias, gyro], [G])
        slope = ca.Function("slope", [x, gyro], [mean])
        step = x + dt * slope(x + dt / 2 * slope(x, gyro), gyro)
        self.f = ca.Function("f", [euler, bias, gyro, dt], [step])
        self.F = ca.Function("F", [euler, bias, gyro, dt], [ca.jacobian(step, x)])
        self.h, self.H = [], []
        for v in (GRAVITY_N, FIELD_N):
            body = about(0, roll) @ about(1, pitch) @ about(2, euler[2]) @ v
            self.h.append(ca.Function("h", [euler, bias], [body]))
            self.H.append(ca.Function("H", [euler, bias], [ca.jacobian(body, x)]))

    def arguments(self, x):
        return x[:3], x[3:]


def about(axis, angle):
    """Coordinates in axes turned by an angle about one of them."""
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    C = ca.SX.eye(3)
    C[i, i] = C[j, j] = ca.cos(angle)
    C[i, j], C[j, i] = ca.sin(angle), -ca.sin(angle)
    return C


def points(kind):
    rng = np.random.default_rng(11)
    for k in range(6):
        first = rng.normal(size=4) if kind is Quaternion else rng.uniform([-3, -1.2, -3], [3, 1.2, 3])
        if k < 2:  # identity, and next to it
            first = np.r_[1.0, np.full(3, 5e-9 * k)] if kind is Quaternion else np.full(3, 1e-8 * k)
        first = first / np.linalg.norm(first) if kind is Quaternion else first
        yield np.r_[first, 0.02 * rng.normal(size=3)], rng.normal(size=3)


@pytest.fixture(scope="module", params=[Quaternion, Euler])
def oracle(request):
    return request.param()


@pytest.fixture(params=[NumericModel, CompiledModel])
def functions(request, oracle):
    return request.param(oracle.model)


def close(ours, theirs, scale=None):
    ours, theirs = np.asarray(ours), np.asarray(theirs).reshape(np.shape(ours))
    scale = np.abs(theirs).max() if scale is None else scale
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * scale)


def test_sensors(oracle, functions):
    for x, _ in points(type(oracle)):
        for j in range(2):
            close(functions.measure(j, x), oracle.h[j](*oracle.arguments(x)))


def test_sensor_jacobians(oracle, functions):
    for x, _ in points(type(oracle)):
        for j in range(2):
            H = np.asarray(oracle.H[j](*oracle.arguments(x)))
            if isinstance(oracle, Quaternion):
                H = H[np.abs(H).max(axis=1) > 1e-9 * np.abs(H).max()]  # gravity: two rows
            close(functions.jacobian(j, x), H)


def test_step(oracle, functions):
    for x, u in points(type(oracle)):
        close(functions.propagate(x, u, DT), oracle.f(*oracle.arguments(x), u, DT))


def test_error_growth(oracle):
    numeric = NumericModel(oracle.model)
    for x, u in points(type(oracle)):
        A, G = numeric.error_rate(x, u)
        close(A, oracle.A(*oracle.arguments(x), u))
        theirs = np.asarray(oracle.G(*oracle.arguments(x), u))
        # our G leaves isotropic attitude noise unturned; what enters the covariance is G Qc G', noise by noise
        for k in range(0, G.shape[1], 3):
            close(G[:, k : k + 3] @ G[:, k : k + 3].T, theirs[:, k : k + 3] @ theirs[:, k : k + 3].T)


def test_transition_and_noise(oracle, functions):
    """F and Q from CasADi's A and G at the half-way state, or its derivative of the whole step."""
    Qc = np.diag(np.repeat(oracle.model.intensities, 3))
    for x, u in points(type(oracle)):
        F, Q = functions.transition(x, u, DT)
        if isinstance(oracle, Quaternion):
            middle = np.asarray(oracle.f(*oracle.arguments(x), u, DT / 2)).ravel()
            A, G = (np.asarray(f(*oracle.arguments(middle), u)) for f in (oracle.A, oracle.G))
            close(F, np.eye(6) + DT * A)
            close(Q, DT * G @ Qc @ G.T)
        else:
            close(F, oracle.F(*oracle.arguments(x), u, DT))
