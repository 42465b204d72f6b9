"""Where the filter of a moving carrier starts: tilt, velocity and place from a window, whatever the manoeuvre.

Seen from the body's axes at the window's end, gyro and accelerometer tell the integrals s(t) and x(t) of the specific
force; satellite readings then say, with g gravity and t counted back from the end,

    v(t) = v_end + g t + C s(t),     p(t) = p_end + v_end t + g t^2 / 2 + C x(t)

which is linear in the end's velocity and place and in m = C u, where u is the direction of s over the window: the
velocity and position integration formulae of Wu and Pan (2013), for one direction.  The rest of C is a turn about m,
near the vertical, that no short window tells: for each heading that is tried it turns what of s and x is not along u,
before place, velocity and m are fitted again.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from robustnav.filter.weighting import StudentT
from robustnav.frames import Array, matrix_from_quat, quat_from_matrix, quat_from_rotvec, rotate, skew
from robustnav.model.blocks import Model
from robustnav.records import IntArray
from robustnav.run.inertial_start import correlated, turned_to_last
from robustnav.run.loop import Start
from robustnav.run.moving_setting import GnssAiding, MovingStart
from robustnav.run.task import Task

_PASSES = 4  # of the reweighted fit
_FEW = 3  # readings that a window needs
_HERE = 0.01  # m, how well a carrier without positions knows that it starts at the origin
_NONE = 1e-9  # sine of an angle that is none
SENSORS = ("velocity", "position")


@dataclass(frozen=True)
class Rows:
    """Readings of a window: ``A`` (k, 3) what each says of place, velocity and m, ``Y`` (k, 3) its numbers by axis.

    ``aside`` (k, 3) is what of the integrated force is not along u, in body axes; ``variances`` (k,) are of the
    sensors, ``spread`` (k,) what ``aside`` adds to them, unturned.
    """

    A: Array
    Y: Array
    aside: Array
    variances: Array
    spread: Array


@dataclass(frozen=True)
class Fit:
    """What readings say at a window's end, on each axis alike.

    ``place``, ``velocity`` and ``up_n`` (3,) [m], [m/s], [1] with covariance ``cov`` (3, 3) of the three on an axis;
    ``agreed`` what the readings counted for on average, 1 where they fit.
    """

    place: Array
    velocity: Array
    up_n: Array
    cov: Array
    agreed: float


@dataclass(frozen=True)
class Window:
    """What a window tells before any heading is tried: ``fit`` of its ``rows``.

    ``up_b`` (3,) is the direction in body axes that is ``up_n`` in navigation axes, ``force`` [m/s^2] the mean specific
    force along it, ``seconds`` the window's length.
    """

    rows: Rows
    fit: Fit
    up_b: Array
    force: float
    seconds: float


def window_at(task: Task, row: int, settings: MovingStart) -> Window | None:
    """Return what the shortest window that ends at a row tells of tilt well enough, or None."""
    seconds, begin = settings.window, task.feed.t[0]
    while seconds <= settings.patience:
        found = _window(task, row, seconds)
        if found is not None and np.sqrt(found.fit.cov[2, 2]) <= settings.tilt_sd:
            return found
        if task.feed.t[row] - seconds <= begin:
            return None
        seconds *= 2
    return None


def moving_starts(task: Task, window: Window, aiding: GnssAiding, headings: int) -> list[Start]:
    """Return a start for each heading, with the errors it has in common with the others."""
    m = window.fit.up_n / np.linalg.norm(window.fit.up_n)
    straight, spacing = _shortest_turn(window.up_b, m), 2 * np.pi / headings
    turns = [matrix_from_quat(quat_from_rotvec(k * spacing * m)) for k in range(headings)]
    return [_start(task, window, aiding, turn @ straight, spacing / 2) for turn in turns]


def _start(task: Task, window: Window, aiding: GnssAiding, C_nb: Array, heading_sd: float) -> Start:
    """Return a start near an attitude.

    It errs with ``up_n``, across it; with the biases, by which the direction was told wrong; and about it by the sd of
    the heading.
    """
    model = task.estimator.model
    part = model.error_slices
    turn, velocity, place = part["q_nb"], part["v_n"], part["p_n"]
    rows = window.rows
    lasting = rows.spread * len(rows.A) / 3  # it is smooth, so it does not average out over the readings
    fit = _solved(rows.A, rows.Y - rows.aside @ C_nb.T, rows.variances + np.sin(heading_sd) ** 2 * lasting)
    m = fit.up_n / np.linalg.norm(fit.up_n)
    C_nb = _shortest_turn(C_nb @ window.up_b, m) @ C_nb
    lever_n = C_nb @ np.asarray(aiding.lever_b)
    blocks = {"q_nb": quat_from_matrix(C_nb), "v_n": fit.velocity, "p_n": fit.place - lever_n}
    x = model.nominal_state()
    for name, value in blocks.items():
        x[model.state_slices[name]] = value
    Z, across = model.start_covariance(), skew(m)
    for a, first in ((place, 0), (velocity, 1)):
        for b, second in ((place, 0), (velocity, 1)):
            Z[a, b] = fit.cov[first, second] * np.eye(3)
        Z[turn, a] = fit.cov[2, first] * across
        Z[a, turn] = Z[turn, a].T
    Z[turn, turn] = fit.cov[2, 2] * across @ across.T + heading_sd**2 * np.outer(m, m)
    Z = _with_drift(model, Z, -window.seconds / 2 * across @ across.T @ C_nb)
    return Start(x, correlated(model, Z, across @ C_nb / window.force, lever_n))


def _with_drift(model: Model, Z: Array, drift: Array) -> Array:
    """Return a covariance with what the gyro's bias turned within the window, ``drift`` (3, 3) [s] times the bias."""
    M = np.eye(len(Z))
    M[model.error_slices["q_nb"], model.error_slices["gyro_bias"]] = drift
    out: Array = M @ Z @ M.T
    return out


@dataclass(frozen=True)
class _Force:
    """Specific force in the body axes at ``end`` [s], integrated from there back to times ``t`` (m,), zero at the end.

    ``told`` (m, 3) is once for velocities and twice for positions, by sensor; ``up_b`` (3,) its direction.  ``turns``
    (m, 4) take the body axes of those times to those of the end.
    """

    end: float
    t: Array
    told: dict[str, Array]
    up_b: Array
    turns: Array


def _window(task: Task, row: int, seconds: float) -> Window | None:
    feed = task.feed
    rows = np.flatnonzero(feed.whole[: row + 1] & (feed.t[: row + 1] >= feed.t[row] - seconds))
    force = _integrated(task, rows) if len(rows) >= _FEW else None
    if force is None:
        return None
    parts = [_rows(task, name, force) for name in SENSORS]
    if sum(len(one.A) for one in parts) < _FEW:
        return None
    if not len(parts[SENSORS.index("position")].A):  # place is then counted from the start
        zero = np.zeros((1, 3))
        parts.append(Rows(np.eye(3)[:1], zero, zero, np.array([_HERE**2]), np.zeros(1)))
    whole = Rows(*(np.concatenate([getattr(one, field.name) for one in parts]) for field in fields(Rows)))
    if np.linalg.matrix_rank(whole.A) < 3:
        return None
    fit = _solved(whole.A, whole.Y, whole.variances + whole.spread)
    span = -float(force.t[0])
    return Window(whole, fit, force.up_b, float(np.linalg.norm(force.told["velocity"][0])) / span, span)


def _integrated(task: Task, rows: IntArray) -> _Force | None:
    """Return the force integrated over whole rows, or None where it sums up to nothing."""
    end = float(task.feed.t[rows[-1]])
    t = task.feed.t[rows] - end
    step = np.diff(t)[:, None]
    turned, turns = turned_to_last(task, rows)
    rise = turned[1:] * step
    s = np.vstack([-np.cumsum(rise[::-1], axis=0)[::-1], np.zeros(3)])
    x = np.vstack([-np.cumsum(((s[1:] + s[:-1]) / 2 * step)[::-1], axis=0)[::-1], np.zeros(3)])
    total = float(np.linalg.norm(s[0]))
    return _Force(end, t, {"velocity": s, "position": x}, s[0] / -total, turns) if total > 0 else None


def _rows(task: Task, name: str, force: _Force) -> Rows:
    """Return a sensor's readings within a window."""
    model = task.estimator.model
    j = model.sensor_index(name)
    data = task.feed.sensors[j]
    if data is None:
        return Rows(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    inside = (data.t > force.end + force.t[0]) & (data.t <= force.end) & np.isfinite(data.z).all(axis=1)
    at, z = data.t[inside] - force.end, data.z[inside, :3]
    along = np.array([np.interp(at, force.t, one) for one in force.told[name].T]).T
    along += _arm(name, force.turns[np.searchsorted(force.t, at)], data.z[inside, 3:])
    up = along @ force.up_b
    one, zero = np.ones_like(at), np.zeros_like(at)
    A = np.stack([one, at, up] if name == "position" else [zero, one, up], axis=1)
    fallen = at**2 / 2 if name == "position" else at
    gravity_n = np.array([0.0, 0.0, model.parameters["gravity"]])
    aside = along - np.outer(up, force.up_b)
    spread = np.full(len(at), np.sum(aside**2) / max(len(at), 1) / 2)
    return Rows(A, z - np.outer(fallen, gravity_n), aside, np.full(len(at), model.sensors[j].sd ** 2), spread)


def _arm(name: str, turns: Array, known: Array) -> Array:
    """Return what the antenna's arm adds to readings, in the end's body axes; to places, what the arm has turned."""
    lever_b = known[:, :3]
    if name == "position":
        return rotate(turns, lever_b) - lever_b
    return rotate(turns, np.cross(known[:, 3:], lever_b))


def _solved(A: Array, Y: Array, variances: Array) -> Fit:
    """Fit place, velocity and up (rows of (3, 3)) to readings by Student-t weights."""
    weights, rule = np.ones(len(A)), StudentT()
    for _ in range(_PASSES):
        scaled = A * (weights / variances)[:, None]
        cov = np.asarray(np.linalg.inv(A.T @ scaled), float)
        found = cov @ scaled.T @ Y
        squares = np.sum((Y - A @ found) ** 2, axis=1) / variances
        weights = np.array([rule.weight(float(r), 3) for r in squares])
    return Fit(found[0], found[1], found[2], cov, float(weights.mean()))


def _shortest_turn(a: Array, b: Array) -> Array:
    """Return the rotation (3, 3) that takes unit vector ``a`` to ``b`` (3,) by the shortest way."""
    axis = np.cross(a, b)
    sine = float(np.linalg.norm(axis))
    if sine < _NONE:  # any axis across serves a half turn
        axis, sine = np.cross(a, np.eye(3)[np.argmin(np.abs(a))]), 0.0
    angle = np.arctan2(sine, float(a @ b))
    out: Array = matrix_from_quat(quat_from_rotvec(angle * axis / np.linalg.norm(axis)))
    return out
