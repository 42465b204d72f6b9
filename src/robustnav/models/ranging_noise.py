"""How radios err and how carriers move: named numbers for models of ranges."""

from __future__ import annotations

from dataclasses import dataclass

from robustnav.errors import InputError
from robustnav.model.blocks import Model
from robustnav.models.uwb import RangeBias, uwb


@dataclass(frozen=True)
class Radio:
    """Errors of calibrated ranges: white ``range_sd`` [m] and ``bias``; ``white_sd`` [m] where white noise is all."""

    range_sd: float
    bias: RangeBias
    white_sd: float


@dataclass(frozen=True)
class Carrier:
    """Acceleration of a carrier as white noise, level and vertical [m/s^2/sqrt(Hz)], and its typical speed [m/s]."""

    acceleration_density: float
    vertical_density: float
    speed: float


RADIOS = {
    # white noise and the curve of biases as measured on static and moving Decawave modules, docs/ranging.md, section 3
    "dw1000": Radio(0.1, RangeBias(sd=0.04, time=60.0, scale_sd=0.004), 0.15),
}
CARRIERS = {
    "cart": Carrier(0.55, 1e-3, 1.0),  # wheels on a yard at walking pace
    "walker": Carrier(0.55, 0.3, 1.0),
    "drone": Carrier(1.0, 1.0, 3.0),
}


def radio_named(name: str) -> Radio:
    """Return a radio by name, or raise ``InputError`` listing those known."""
    if name not in RADIOS:
        raise InputError(f"radio {name!r}", expected=f"one of {', '.join(RADIOS)}")
    return RADIOS[name]


def carrier_named(name: str) -> Carrier:
    """Return a carrier by name, or raise ``InputError`` listing those known."""
    if name not in CARRIERS:
        raise InputError(f"carrier {name!r}", expected=f"one of {', '.join(CARRIERS)}")
    return CARRIERS[name]


def uwb_of(
    radio: Radio,
    carrier: Carrier,
    *,
    bias: bool = True,
    tag_down: float | None = None,
    time_offset: float = 0.0,
) -> Model:
    """Return the model of a radio on a carrier.

    Parameters
    ----------
    radio, carrier : their numbers.
    bias : estimate a bias of each anchor; else white noise stands for it.
    tag_down : known place on the down axis [m]: a model in the plane; None: in space.
    time_offset : how late the stamps are [s].
    """
    return uwb(
        range_sd=radio.range_sd if bias else radio.white_sd,
        acceleration_density=carrier.acceleration_density,
        vertical_density=carrier.vertical_density,
        dimensions=3 if tag_down is None else 2,
        speed=carrier.speed,
        bias=radio.bias if bias else None,
        tag_down=0.0 if tag_down is None else tag_down,
        time_offset=time_offset,
    )
