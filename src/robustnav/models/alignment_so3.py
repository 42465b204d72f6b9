"""Initial alignment against a velocity reference: attitude error on SO(3), and oscillators for the lines of a wind.

The covariance is carried along with every correction of attitude (``Rotation(transported=True)``): without that a
filter that corrects by many degrees believes it has measured heading (docs/alignment.md, section 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, Rotation, Sensor, Symbols, Vector
from robustnav.models.alignment import INCREMENTS, AlignmentNoise, alignment_noises, increment, specific
from robustnav.units import DEG

MOST_LINES = 6
LINE_SD = 0.5  # m/s, of each of a line's amplitudes at the start
LINE_DENSITY = 3e-5  # m/s/sqrt(s): an amplitude forgets itself over hours


def alignment_so3(
    noise: AlignmentNoise,
    *,
    gravity: float,
    earth_rate_north: float,
    earth_rate_down: float,
    lines: Sequence[float] = (),
    line_density: float = LINE_DENSITY,
) -> Model:
    """Return attitude, velocity and biases of a unit on a swaying base, and the wind's lines: 12 errors and 4 a line.

    State ``q_nb``, ``v_n``, ``gyro_bias``, ``accel_bias`` and, with lines, ``wind``: of each line cosine and sine
    north, cosine and sine east [m/s].  Inputs are pre-integrated increments; the sensor ``velocity`` is base, wind and
    noise.  Frequencies that cover a band serve where those of the wind are not known.

    Parameters
    ----------
    noise : of the unit and the reference.
    gravity : normal gravity [m/s^2].
    earth_rate_north, earth_rate_down : of the Earth at the latitude [rad/s].
    lines : frequencies [rad/s] of the wind's lines, up to six.
    line_density : random walk of a line's amplitudes [m/s/sqrt(s)].

    Raises
    ------
    InputError : more lines than six, or a frequency that is not positive.
    """
    count = len(lines)
    if count > MOST_LINES or not all(omega > 0 for omega in lines):
        raise InputError(
            "lines of a wind", got=str(tuple(lines)), expected=f"up to {MOST_LINES} frequencies above zero"
        )
    unit = (
        Rotation("q_nb", error="n", transported=True),
        Vector("v_n", "m/s"),
        Vector("gyro_bias", "rad/s", frame="b"),
        Vector("accel_bias", "m/s^2", frame="b"),
    )
    walk = Noise("wind_noise", "m/s/sqrt(s)", line_density, 4 * count)
    equations = _EQUATIONS[count]
    return Model(
        name=f"alignment_so3_{count}" if count else "alignment_so3",
        state=(*unit, Vector("wind", "m/s", 4 * count)) if count else unit,
        inputs=INCREMENTS,
        noises=(*alignment_noises(noise), walk) if count else alignment_noises(noise),
        sensors=(Sensor("velocity", "m/s", noise.velocity_sd),),
        parameters={
            "gravity": gravity,
            "earth_rate_north": earth_rate_north,
            "earth_rate_down": earth_rate_down,
            **{f"line_{k}": float(omega) for k, omega in enumerate(lines)},
        },
        equations=equations,
        nominal={
            "turn": (1.0, 0.0, 0.0, 0.0),
            "velocity_increment": (0.0, 0.0, -0.1 * gravity),
            "turn_by_bias": (0.1, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1),
        },
        start_sd={
            "q_nb": 0.5,
            "v_n": 3.0,
            "gyro_bias": 0.01 * DEG,
            "accel_bias": 1e-3,
            **({"wind": LINE_SD} if count else {}),
        },
        shipped=equations if count in (0, 3) else None,
    )


def _equations(s: Symbols, *, lines: int) -> Equations:
    import sympy as sp

    from robustnav.model.derive import matrix, quat_product

    a = sp.Matrix(matrix(list(s.q_nb))) * specific(s)
    earth_rate_n = sp.Matrix([s.earth_rate_north, 0, s.earth_rate_down])
    J = sp.Matrix(3, 3, list(s.turn_by_bias))
    turn = quat_product(increment(-J * s.gyro_bias), list(s.turn))
    # white noise of equal size on every axis is the same in navigation axes, where it needs no turning
    frame = quat_product(increment(s.gyro_noise), increment(-earth_rate_n * s.dt))
    coriolis = s.dt * earth_rate_n.cross(a / 2 + 2 * s.v_n)
    steps = {
        "q_nb": quat_product(quat_product(frame, list(s.q_nb)), turn),
        "v_n": s.v_n + a + sp.Matrix([0, 0, s.gravity]) * s.dt - coriolis + s.accel_noise,
        "gyro_bias": s.gyro_bias + s.gyro_bias_noise,
        "accel_bias": s.accel_bias + s.accel_bias_noise,
    }
    seen = s.v_n
    if lines:
        turned = []
        for k in range(lines):
            phase = getattr(s, f"line_{k}") * s.dt
            c, b = sp.cos(phase), sp.sin(phase)
            for at in (4 * k, 4 * k + 2):
                turned += [c * s.wind[at] + b * s.wind[at + 1], c * s.wind[at + 1] - b * s.wind[at]]
        steps["wind"] = sp.Matrix(turned) + s.wind_noise
        north, east = (sum(s.wind[4 * k + at] for k in range(lines)) for at in (0, 2))
        seen = s.v_n + sp.Matrix([north, east, 0])
    return Equations(steps=steps, sensors={"velocity": seen})


_EQUATIONS = [partial(_equations, lines=count) for count in range(MOST_LINES + 1)]
