"""Position and velocity of a tag from ultra-wideband ranges, in a plane or in space."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, Sensor, Symbols, Vector

BIAS_SLOTS = 8  # anchors whose bias is estimated; the model that ships does not change with their number
_FRAMES = {2: ("north", "east"), 3: ("north", "east", "down")}


@dataclass(frozen=True)
class RangeBias:
    """What is left of range errors after calibration and does not average out.

    ``sd`` [m] of each anchor's bias, a first-order Gauss-Markov process of time constant ``time`` [s]; ``scale_sd`` of
    a common constant error of scale.  Antennas, mounting and multipath make such biases; modelled as white noise they
    make a filter believe in centimetres where it errs by decimetres (docs/ranging.md, section 3).
    """

    sd: float
    time: float
    scale_sd: float

    def __post_init__(self) -> None:
        for name, value in (("sd", self.sd), ("time", self.time), ("scale_sd", self.scale_sd)):
            if not 0 < value < float("inf"):
                raise InputError(f"range bias {name}", got=str(value), expected="a finite number above zero")


def uwb(
    *,
    range_sd: float,
    acceleration_density: float,
    vertical_density: float | None = None,
    dimensions: int = 3,
    driven: bool = False,
    speed: float | None = None,
    bias: RangeBias | None = None,
    tag_down: float = 0.0,
    time_offset: float = 0.0,
    height_sd: float = 0.1,
    position_sd: float = 0.1,
) -> Model:
    """Return the model of a tag among anchors: state ``p_n`` [m] and ``v_n`` [m/s], acceleration as white noise.

    Axes are those the anchors are surveyed in, z down.  Sensors: ``range`` (metres; the anchor's position travels with
    each reading), ``tdoa`` (distance to a second anchor minus that to a first; both travel), ``position`` and, in
    space, ``height`` (metres up).  Each is fused at its own time (docs/ranging.md, section 1).

    Parameters
    ----------
    range_sd : of a calibrated range, white [m]; a difference of two has sqrt(2) of it.
    acceleration_density : horizontal acceleration as white noise, two-sided [m/s^2/sqrt(Hz)]; the published discrete
        noise sigma_a at steps dt is sigma_a sqrt(dt).
    vertical_density : the same for the vertical; None: as the horizontal one.  A vehicle on a floor needs little.
    dimensions : 3, or 2 for a tag at the known height ``tag_down``.
    driven : take the acceleration as the input ``accel_n`` [m/s^2]; the noise is then that of the input.
    speed : size of each horizontal component of the velocity in the long run [m/s]: it forgets itself at the rate that
        leaves it this sd, so that a silence does not carry the tag away.  None: it wanders without bound, as published.
    bias : estimate a bias of each of up to eight anchors and an error of scale: state ``range_bias`` [m] and
        ``range_scale``; which anchor it is travels with each reading, see ``Ranges.stream``.  None: white noise only.
    tag_down : where the tag is on the down axis [m], in a plane.
    time_offset : how late the stamps of ranges and differences are [s]: they tell of where the tag was then.
    height_sd, position_sd : of those sensors [m].

    Raises
    ------
    InputError : dimensions other than 2 or 3, ``driven`` with ``bias`` or ``speed``, or a number out of range.
    """
    if dimensions not in _FRAMES:
        raise InputError("dimensions", got=str(dimensions), expected="2 or 3")
    if driven and (bias is not None or speed is not None):
        raise InputError("uwb model", got="driven with bias or speed", expected="one of them")
    if speed is not None and not (speed > 0 and acceleration_density > 0):
        raise InputError("speed", got=f"{speed} m/s", expected="above zero, with an acceleration above zero")
    n = dimensions
    vertical = acceleration_density if vertical_density is None else vertical_density
    noises = [Noise("acceleration", "m/s^2/sqrt(Hz)", acceleration_density, 2)]
    noises += [Noise("vertical_acceleration", "m/s^2/sqrt(Hz)", vertical, 1)] if n == 3 else []
    damping = 0.0 if speed is None else acceleration_density**2 / (2 * speed**2)  # of white noise into variance speed^2
    parameters = (
        {"time_offset": time_offset}
        | ({} if driven else {"velocity_damping": damping})
        | ({"tag_down": tag_down} if n == 2 else {})
    )
    flatter = min(1.0, vertical / acceleration_density) if acceleration_density > 0 else 1.0
    start_sd: dict[str, ArrayLike] = {"p_n": 1.0, "v_n": (1.0, 1.0, flatter)[:n]}
    state = [Vector("p_n", "m", n), Vector("v_n", "m/s", n)]
    if bias is not None:
        state += [Vector("range_bias", "m", BIAS_SLOTS), Vector("range_scale", "1", 1)]
        noises.append(Noise("range_bias_noise", "m/s/sqrt(Hz)", bias.sd * (2 / bias.time) ** 0.5, BIAS_SLOTS))
        parameters["bias_time"] = bias.time
        start_sd |= {"range_bias": bias.sd, "range_scale": bias.scale_sd}
    return Model(
        name=f"uwb_{n}d" + ("_driven" if driven else "") + ("_biased" if bias else ""),
        state=tuple(state),
        inputs=(Vector("accel_n", "m/s^2", n),) if driven else (),
        noises=tuple(noises),
        sensors=_sensors(n, range_sd, position_sd, height_sd, biased=bias is not None),
        parameters=parameters,
        equations=_EQUATIONS[n, driven, bias is not None],
        start_sd=start_sd,
        shipped=_EQUATIONS[n, driven, bias is not None],
    )


def _sensors(n: int, range_sd: float, position_sd: float, height_sd: float, *, biased: bool) -> tuple[Sensor, ...]:
    anchor, first, second = (Vector(f"p_{which}", "m") for which in ("anchor", "first", "second"))
    own, both = ((Vector(f"{name}_slot", "1", BIAS_SLOTS),) if biased else () for name in ("range", "tdoa"))
    out = (
        Sensor("range", "m", range_sd, 1, known=(anchor, *own)),
        Sensor("tdoa", "m", range_sd * 2**0.5, 1, known=(first, second, *both)),
        Sensor("position", "m", position_sd, n),
    )
    return (*out, Sensor("height", "m", height_sd, 1)) if n == 3 else out


def _equations(s: Symbols, *, dimensions: int, driven: bool, biased: bool) -> Equations:
    tag = s.p_n - s.time_offset * s.v_n
    at = [*tag] if dimensions == 3 else [*tag, s.tag_down]
    acceleration = _stacked(s.acceleration, s.vertical_acceleration) if dimensions == 3 else s.acceleration
    rates = {"p_n": s.v_n, "v_n": acceleration + (s.accel_n if driven else -s.velocity_damping * s.v_n)}
    one = distance(at, s.p_anchor)
    two = distance(at, s.p_second) - distance(at, s.p_first)
    if biased:
        rates |= {"range_bias": s.range_bias_noise - s.range_bias / s.bias_time, "range_scale": [0]}
        one = one * (1 + s.range_scale[0]) + s.range_bias.dot(s.range_slot)
        two = two * (1 + s.range_scale[0]) + s.range_bias.dot(s.tdoa_slot)
    sensors = {"range": one, "tdoa": two, "position": s.p_n} | ({"height": -s.p_n[2]} if dimensions == 3 else {})
    return Equations(rates, sensors)


_EQUATIONS = {
    (n, driven, biased): partial(_equations, dimensions=n, driven=driven, biased=biased)
    for n in (2, 3)
    for driven, biased in ((False, False), (True, False), (False, True))
}


def distance(a: Any, b: Any) -> Any:
    """Return the distance of two points given as three expressions each."""
    import sympy as sp

    return sp.sqrt(sum((x - y) ** 2 for x, y in zip(a, b, strict=True)))


def _stacked(*parts: Any) -> Any:
    import sympy as sp

    return sp.Matrix([e for part in parts for e in part])
