"""What a model is made of: state blocks, inputs, noises, sensors and the equations that join them.

A model is data.  Names, sizes and numbers live here as plain Python, so built-in models need no symbolic library at
run time; the equations are a function of symbols, called only when a model is differentiated or turned into C.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array


@dataclass(frozen=True)
class Vector:
    """A block of plain numbers: a gyro bias, a position, an input.

    ``frame="b"`` says that the block is a vector in body axes; a constant-gain filter on a model whose attitude
    error is kept in navigation axes then rotates its corrections with the attitude.
    """

    name: str
    unit: str
    size: int = 3
    frame: str = ""

    @property
    def error_size(self) -> int:
        """Numbers in the error: as many as in the block."""
        return self.size


@dataclass(frozen=True)
class Rotation:
    """A unit quaternion ``q_nb``, Hamilton, w first; its error is a small rotation vector [rad].

    ``error="n"``: C_true = Exp(e) C_est, error in navigation axes (right-invariant);
    ``error="b"``: C_true = C_est Exp(e), error in body axes.
    ``transported``: an extended Kalman filter turns the covariance with each correction of attitude, which matters
    where corrections are of many degrees.
    """

    name: str
    error: str = "n"
    unit: str = "1"
    transported: bool = False

    size = 4
    error_size = 3
    frame = ""

    def __post_init__(self) -> None:
        if self.error not in ("n", "b"):
            raise InputError(f"rotation {self.name!r}", got=f"error={self.error!r}", expected="'n' or 'b'")


Block = Vector | Rotation


@dataclass(frozen=True)
class Noise:
    """White noise that drives the state: ``density`` in ``unit``, two-sided.

    Its integral has variance density^2 t.  A data sheet's one-sided density N is density = N / sqrt(2).
    """

    name: str
    unit: str
    density: float
    size: int = 3


@dataclass(frozen=True)
class Sensor:
    """A sensor's reading: ``size`` numbers in ``unit`` with white noise ``sd`` a sample.

    ``wraps`` marks an angle [rad] whose residual is taken into [-pi, pi).  ``known`` vectors travel with every reading,
    behind its numbers: where the anchor of a range stands, where the tag sits on the body.
    """

    name: str
    unit: str
    sd: float
    size: int = 3
    wraps: bool = False
    known: tuple[Vector, ...] = ()

    @property
    def width(self) -> int:
        """Numbers in a reading with what travels with it."""
        return self.size + sum(k.size for k in self.known)


@dataclass(frozen=True)
class Equations:
    """A model's equations over the symbols it was given.

    rates : by state block: its derivative, or for a Rotation its body rate [rad/s] (3,).
    steps : instead of rates, by state block: its value after ``s.dt`` seconds, a unit quaternion for a Rotation, for
        inputs that are increments.  A noise symbol enters as a rate would: it adds ``dt * density**2`` of variance.
    sensors : by sensor name: what it reads, h(x).
    directions : by sensor name: the navigation vector v_n a three-axis body sensor sees, y_b = C_bn v_n.  Such
        sensors are compared in navigation axes when the attitude error is kept there.
    """

    rates: Mapping[str, Any] = field(default_factory=dict)
    sensors: Mapping[str, Any] = field(default_factory=dict)
    directions: Mapping[str, Any] = field(default_factory=dict)
    steps: Mapping[str, Any] = field(default_factory=dict)


class Symbols:
    """The symbols of a model by block name: a column matrix each, or a scalar for parameters."""

    def __init__(self, entries: Mapping[str, Any]) -> None:
        self._entries = dict(entries)

    def __getattr__(self, name: str) -> Any:
        try:
            return self._entries[name]
        except KeyError:
            raise AttributeError(f"no symbol {name!r}; the model has {', '.join(self._entries)}") from None


@dataclass(frozen=True)
class Model:
    """State blocks, inputs, noises, sensors, parameters and the equations that join them.

    Parameters
    ----------
    name : identifier; prefixes every C function of the model.
    state, inputs, noises, sensors : in the order in which arrays hold them.
    parameters : named numbers the equations may use (gravity, a reference field, ...), with their values.
    equations : function from Symbols to Equations, using SymPy.
    nominal : by block name, the state and input at which constant gains are designed.
    start_sd : by block name, the standard deviations of a start error, in the order of the error; scalars spread.
    shipped : the equations whose C ships with the package, in the built-in models.

    Raises
    ------
    InputError : a name is no identifier or appears twice, a number is missing or out of range.
    """

    name: str
    state: tuple[Block, ...]
    inputs: tuple[Vector, ...]
    noises: tuple[Noise, ...]
    sensors: tuple[Sensor, ...]
    equations: Callable[[Symbols], Equations]
    parameters: Mapping[str, float] = field(default_factory=dict)
    nominal: Mapping[str, ArrayLike] = field(default_factory=dict)
    start_sd: Mapping[str, ArrayLike] = field(default_factory=dict)
    shipped: Callable[[Symbols], Equations] | None = None

    def __post_init__(self) -> None:
        names = [self.name, *self.block_names]
        for name in names:
            if not name.isidentifier():
                raise InputError(f"model {self.name!r}", got=f"name {name!r}", expected="a Python identifier")
        doubled = sorted({n for n in names[1:] if names[1:].count(n) > 1})
        if doubled:
            raise InputError(f"model {self.name!r}", got=f"{', '.join(doubled)} twice", expected="different names")
        if sum(isinstance(b, Rotation) for b in self.state) > 1:
            raise InputError(f"model {self.name!r}", got="two rotations", expected="at most one Rotation block")
        self._check_sizes()
        self._check_numbers()

    def _check_sizes(self) -> None:
        if not self.state:
            raise InputError(f"model {self.name!r}", got="no state", expected="at least one block")
        for part in self._parts:
            if part.size < 1:
                raise InputError(
                    f"{part.name!r} of model {self.name!r}", got=f"size {part.size}", expected="at least 1"
                )
            if part in self.state and part.frame == "b" and part.size != 3:
                raise InputError(f"body vector {part.name!r}", got=f"size {part.size}", expected="three numbers")
        known = [k for s in self.sensors for k in s.known]
        unknown = sorted(set(self.nominal) - {b.name for b in (*self.state, *self.inputs, *known)})
        if unknown:
            raise InputError(
                f"nominal of model {self.name!r}",
                got=", ".join(unknown),
                expected="names of state blocks, inputs and known vectors",
            )

    def _check_numbers(self) -> None:
        for name, value in self.parameters.items():
            if not np.isfinite(value):
                raise InputError(
                    f"parameter {name!r} of model {self.name!r}", got=str(value), expected="a finite number"
                )
        for noise in self.noises:
            if not (np.isfinite(noise.density) and noise.density >= 0):
                raise InputError(
                    f"noise {noise.name!r} of model {self.name!r}",
                    got=f"density {noise.density}",
                    expected=f"a finite density >= 0 in {noise.unit}",
                )
        for sensor in self.sensors:
            if not (np.isfinite(sensor.sd) and sensor.sd > 0):
                raise InputError(
                    f"sensor {sensor.name!r} of model {self.name!r}",
                    got=f"sd {sensor.sd}",
                    expected=f"a finite standard deviation > 0 in {sensor.unit}",
                )

    @property
    def prebuilt(self) -> bool:
        """Whether the C that ships with the package is this model's: its equations are those it was made from."""
        return self.shipped is self.equations

    @property
    def block_names(self) -> list[str]:
        """Names of state blocks, inputs, noises, sensors, what travels with their readings, and parameters."""
        return [p.name for p in self._parts] + list(self.parameters)

    @property
    def _parts(self) -> Sequence[Any]:
        known = [k for s in self.sensors for k in s.known]
        return (*self.state, *self.inputs, *self.noises, *self.sensors, *known)

    @property
    def state_size(self) -> int:
        """Numbers in the state (a quaternion counts four)."""
        return sum(b.size for b in self.state)

    @property
    def error_size(self) -> int:
        """Numbers in the error (a quaternion counts three)."""
        return sum(b.error_size for b in self.state)

    @property
    def input_size(self) -> int:
        """Numbers in one input sample."""
        return sum(b.size for b in self.inputs)

    @property
    def rotation(self) -> Rotation | None:
        """The attitude block, or None."""
        return next((b for b in self.state if isinstance(b, Rotation)), None)

    @property
    def state_slices(self) -> dict[str, slice]:
        """Where each block lies in the state array."""
        return _slices([(b.name, b.size) for b in self.state])

    @property
    def error_slices(self) -> dict[str, slice]:
        """Where each block lies in the error array."""
        return _slices([(b.name, b.error_size) for b in self.state])

    @property
    def intensities(self) -> Array:
        """Noise intensities density^2, one per noise block (k,)."""
        return np.array([n.density**2 for n in self.noises])

    @property
    def variances(self) -> Array:
        """Sensor variances sd^2, one per sensor (k,)."""
        return np.array([s.sd**2 for s in self.sensors])

    @property
    def parameter_values(self) -> Array:
        """Parameter values (k,) in their order."""
        return np.array(list(self.parameters.values()), float)

    def sensor_index(self, name: str) -> int:
        """Return the position of a sensor, or raise ``InputError`` listing those the model has."""
        names = [s.name for s in self.sensors]
        if name not in names:
            raise InputError(f"sensor {name!r}", place=f"model {self.name!r}", expected=f"one of {', '.join(names)}")
        return names.index(name)

    def nominal_state(self) -> Array:
        """Return the state (nx,) constant gains are designed at: ``nominal``, zero and identity where not given."""
        parts = []
        for block in self.state:
            default = [1.0, 0.0, 0.0, 0.0] if isinstance(block, Rotation) else np.zeros(block.size)
            parts.append(np.broadcast_to(np.asarray(self.nominal.get(block.name, default), float), block.size))
        return np.concatenate(parts)

    def nominal_input(self) -> Array:
        """Return the input (nu,) constant gains are designed at."""
        parts = [np.broadcast_to(np.asarray(self.nominal.get(b.name, 0.0), float), b.size) for b in self.inputs]
        return np.concatenate(parts) if parts else np.zeros(0)

    def nominal_known(self, sensor: int) -> Array:
        """Return what travels with a reading at the nominal point; ``InputError`` if ``nominal`` does not say."""
        parts = [np.zeros(0)]
        for block in self.sensors[sensor].known:
            if block.name not in self.nominal:
                raise InputError(
                    f"nominal of model {self.name!r}", got=f"no {block.name!r}", expected="the geometry to design for"
                )
            parts.append(np.broadcast_to(np.asarray(self.nominal[block.name], float), block.size))
        return np.concatenate(parts)

    def start_covariance(self, sd: Mapping[str, ArrayLike] | None = None) -> Array:
        """Return the diagonal start covariance (ne, ne) of ``sd`` by block, ``start_sd`` where not given."""
        wanted = {**self.start_sd, **(sd or {})}
        unknown = sorted(set(wanted) - {b.name for b in self.state})
        if unknown:
            raise InputError("start_sd", got=", ".join(unknown), expected=", ".join(b.name for b in self.state))
        parts = []
        for block in self.state:
            if block.name not in wanted:
                raise InputError(
                    f"start_sd of model {self.name!r}",
                    expected=f"a standard deviation for {block.name!r} in {block.unit}",
                    do=f"pass start_sd={{{block.name!r}: ...}}",
                )
            parts.append(np.broadcast_to(np.asarray(wanted[block.name], float), block.error_size))
        return np.diag(np.concatenate(parts) ** 2)

    def with_numbers(
        self,
        density: Mapping[str, float] | None = None,
        sd: Mapping[str, float] | None = None,
        parameters: Mapping[str, float] | None = None,
    ) -> Model:
        """Return the model with some noise densities, sensor standard deviations or parameters replaced, by name."""
        density, sd, parameters = dict(density or {}), dict(sd or {}), dict(parameters or {})
        noises = tuple(replace(n, density=float(density.pop(n.name, n.density))) for n in self.noises)
        sensors = tuple(replace(s, sd=float(sd.pop(s.name, s.sd))) for s in self.sensors)
        values = {k: float(parameters.pop(k, v)) for k, v in self.parameters.items()}
        left = [*density, *sd, *parameters]
        if left:
            raise InputError(
                f"model {self.name!r}", got=", ".join(left), expected=f"names among {', '.join(self.block_names)}"
            )
        return replace(self, noises=noises, sensors=sensors, parameters=values)


def _slices(sizes: Sequence[tuple[str, int]]) -> dict[str, slice]:
    out, start = {}, 0
    for name, size in sizes:
        out[name] = slice(start, start + size)
        start += size
    return out
