"""Position and velocity of a tag from ultra-wideband ranges, in a plane or in space."""

from __future__ import annotations

from typing import Any

from robustnav.errors import InputError
from robustnav.model import Equations, Model, Noise, Sensor, Symbols, Vector

_FRAMES = {2: ("north", "east"), 3: ("north", "east", "down")}


def uwb(
    *,
    range_sd: float,
    acceleration_density: float,
    vertical_density: float | None = None,
    dimensions: int = 3,
    driven: bool = False,
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
    tag_down : where the tag is on the down axis [m], in a plane.
    time_offset : how late the stamps of ranges and differences are [s]: they tell of where the tag was then.
    height_sd, position_sd : of those sensors [m].

    Raises
    ------
    InputError : dimensions other than 2 or 3, or a number out of range.
    """
    if dimensions not in _FRAMES:
        raise InputError("dimensions", got=str(dimensions), expected="2 or 3")
    n = dimensions
    anchor, first, second = (Vector(f"p_{which}", "m") for which in ("anchor", "first", "second"))
    sensors = [
        Sensor("range", "m", range_sd, 1, known=(anchor,)),
        Sensor("tdoa", "m", range_sd * 2**0.5, 1, known=(first, second)),
        Sensor("position", "m", position_sd, n),
    ]
    noises = [Noise("acceleration", "m/s^2/sqrt(Hz)", acceleration_density, 2)]
    parameters = {"time_offset": time_offset}
    if n == 3:
        sensors.append(Sensor("height", "m", height_sd, 1))
        vertical = acceleration_density if vertical_density is None else vertical_density
        noises.append(Noise("vertical_acceleration", "m/s^2/sqrt(Hz)", vertical, 1))
    else:
        parameters["tag_down"] = tag_down
    equations = (_space, _driven_space) if n == 3 else (_plane, _driven_plane)
    return Model(
        name=f"uwb_{n}d" + ("_driven" if driven else ""),
        state=(Vector("p_n", "m", n), Vector("v_n", "m/s", n)),
        inputs=(Vector("accel_n", "m/s^2", n),) if driven else (),
        noises=tuple(noises),
        sensors=tuple(sensors),
        parameters=parameters,
        equations=equations[driven],
        start_sd={"p_n": 1.0, "v_n": 1.0},
        shipped=equations[driven],
    )


def _space(s: Symbols) -> Equations:
    rates = {"p_n": s.v_n, "v_n": _stacked(s.acceleration, s.vertical_acceleration)}
    return Equations(rates, {**_ranging(s, list(s.p_n - s.time_offset * s.v_n)), "height": -s.p_n[2]})


def _plane(s: Symbols) -> Equations:
    return Equations({"p_n": s.v_n, "v_n": s.acceleration}, _ranging(s, _in_plane(s)))


def _driven_space(s: Symbols) -> Equations:
    plain = _space(s)
    return Equations({"p_n": s.v_n, "v_n": plain.rates["v_n"] + s.accel_n}, plain.sensors)


def _driven_plane(s: Symbols) -> Equations:
    return Equations({"p_n": s.v_n, "v_n": s.acceleration + s.accel_n}, _ranging(s, _in_plane(s)))


def _in_plane(s: Symbols) -> list[Any]:
    return [*(s.p_n - s.time_offset * s.v_n), s.tag_down]


def _ranging(s: Symbols, tag: list[Any]) -> dict[str, Any]:
    """Return what ranging sensors read of a tag at three coordinates."""
    return {
        "range": distance(tag, s.p_anchor),
        "tdoa": distance(tag, s.p_second) - distance(tag, s.p_first),
        "position": s.p_n,
    }


def distance(a: Any, b: Any) -> Any:
    """Return the distance of two points given as three expressions each."""
    import sympy as sp

    return sp.sqrt(sum((x - y) ** 2 for x, y in zip(a, b, strict=True)))


def _stacked(*parts: Any) -> Any:
    import sympy as sp

    return sp.Matrix([e for part in parts for e in part])
