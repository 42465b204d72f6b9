"""Estimators as users name them: a model with the way its errors are weighted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from robustnav.engine.backends import functions_of
from robustnav.engine.filters import FilterSetup
from robustnav.errors import InputError
from robustnav.filter.ekf import EVERYTHING
from robustnav.filter.ukf import Spread
from robustnav.filter.weighting import Rule
from robustnav.frames import Array
from robustnav.model.blocks import Model

if TYPE_CHECKING:
    from robustnav.design.certificates import Certificate
    from robustnav.design.schedule import GainTable, Turning


def _form(model: Model) -> str:
    return "-euler" if model.name == "attitude_euler" else ""


def _rules(model: Model, outliers: Mapping[str, Rule]) -> tuple[Rule, ...]:
    for name in outliers:
        model.sensor_index(name)
    return tuple(outliers.get(s.name, EVERYTHING) for s in model.sensors)


@dataclass(frozen=True)
class EKF:
    """Extended Kalman filter; on a model with a quaternion it is the multiplicative EKF.

    Parameters
    ----------
    model : the model, with its noise.
    outliers : by sensor name, what a reading far off counts for: ``Gate``, ``Huber`` or ``StudentT``; absent: as any.
    longest_step : a longer prediction is made in equal parts [s]; a pause of the input otherwise is one step.
    """

    model: Model
    outliers: Mapping[str, Rule] = field(default_factory=dict)
    longest_step: float = float("inf")

    def __post_init__(self) -> None:
        if not self.longest_step > 0:
            raise InputError("longest_step", got=str(self.longest_step), expected="seconds above zero")

    @property
    def name(self) -> str:
        """``mekf`` on quaternion models, else ``ekf``, with ``-euler`` on the published model."""
        return "mekf" if self.model.rotation else "ekf" + _form(self.model)

    def setup(self, x: Array, P: Array) -> FilterSetup:
        """Return what a filter is started with: state (nx,) and covariance (ne, ne)."""
        return FilterSetup("ekf", x, P, _rules(self.model, self.outliers), longest_step=self.longest_step)


@dataclass(frozen=True)
class UKF:
    """Unscented Kalman filter over any model; parameters as ``EKF``, and the ``spread`` of its points."""

    model: Model
    spread: Spread = field(default_factory=Spread)
    outliers: Mapping[str, Rule] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """``ukf``."""
        return "ukf"

    def setup(self, x: Array, P: Array) -> FilterSetup:
        """Return what a filter is started with."""
        return FilterSetup("ukf", x, P, _rules(self.model, self.outliers), self.spread)


@dataclass(frozen=True)
class HInfinity:
    """Unscented filter with an H-infinity bound: the error energy stays below gamma^2 times that of all disturbances.

    Time and measurement update are the unscented filter's; after each instant the covariance is enlarged where the
    bound asks for it, and the condition for such a filter to exist is checked.  Its margin stands beside every
    innovation; where it is not above zero the covariance is the Kalman filter's, and the run says so.  As gamma grows
    the filter becomes the UKF.

    Parameters
    ----------
    model : the model, with its noise.
    gamma : the bound; see ``smallest_gamma``.
    tolerances : by block name, the error that counts as one in the bounded norm; None bounds every number of the
        error in its own unit, as the publication does.
    spread, outliers : as of ``UKF`` and ``EKF``.
    """

    model: Model
    gamma: float
    tolerances: Mapping[str, float] | None = None
    spread: Spread = field(default_factory=Spread)
    outliers: Mapping[str, Rule] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.gamma) and self.gamma > 0):
            raise InputError("gamma", got=str(self.gamma), expected="a finite bound above zero")
        for name, value in (self.tolerances or {}).items():
            if name not in self.model.error_slices or not value > 0:
                blocks = ", ".join(self.model.error_slices)
                raise InputError(f"tolerance of {name!r}", got=str(value), expected=f"above zero, one of {blocks}")

    @property
    def name(self) -> str:
        """``ut-hinf``."""
        return "ut-hinf"

    @property
    def bounded(self) -> Array:
        """The rows L (l, ne) that are bounded."""
        scales = np.full(self.model.error_size, 1.0 if self.tolerances is None else np.nan)
        for name, value in (self.tolerances or {}).items():
            scales[self.model.error_slices[name]] = 1.0 / value
        rows: Array = np.diag(np.nan_to_num(scales))[np.isfinite(scales)]
        return rows

    def setup(self, x: Array, P: Array) -> FilterSetup:
        """Return what a filter is started with."""
        rules = _rules(self.model, self.outliers)
        return FilterSetup("hinf", x, P, rules, self.spread, bound=(self.gamma, self.bounded))


class H2:
    """Constant-gain filter: the H2-optimal gain at the model's nominal point, with its certificate.

    On ``attitude`` one gain serves every attitude and its start-up schedule converges like the MEKF; on
    ``attitude_euler`` it is the published extended H2 filter.

    Parameters
    ----------
    model : the model, with its noise.
    rate_hz : rate of the inputs [Hz].
    sensor_rates_hz : by sensor name, its rate where it is slower than the inputs; rounded to a whole divisor.
    start_sd : by block name, the standard deviations the start-up schedule is designed for; ``"steady"`` designs
        no schedule, None takes the model's own.
    sets : gain sets in the schedule.
    turn_intensity : how much the carrier may turn while the filter starts, see ``design.schedule.Turning`` [rad^2/s];
        used on models whose gain serves every attitude.  With white noise alone it speeds a start in motion up;
        where the carrier's own accelerations disturb the accelerometer, leave it at zero.

    Raises
    ------
    InputError : a rate is not positive, or a sensor is faster than the inputs.
    EstimatorError : the gain fails its certificate.
    """

    def __init__(
        self,
        model: Model,
        rate_hz: float,
        *,
        sensor_rates_hz: Mapping[str, float] | None = None,
        start_sd: Mapping[str, ArrayLike] | str | None = None,
        sets: int = 32,
        turn_intensity: float = 0.0,
    ) -> None:
        from robustnav.design.schedule import SensorRows, Startup, gain_table

        if not (np.isfinite(rate_hz) and rate_hz > 0):
            raise InputError("rate_hz", got=str(rate_hz), expected="a rate above zero")
        self.model, self.rate_hz = model, float(rate_hz)
        self.steady = isinstance(start_sd, str)
        if isinstance(start_sd, str) and start_sd != "steady":
            raise InputError("start_sd", got=repr(start_sd), expected="standard deviations by block, or 'steady'")
        startup = None
        if not isinstance(start_sd, str):
            startup = Startup(model.start_covariance(start_sd), sets, _turning(model, turn_intensity))
        functions = functions_of(model)
        x, u = model.nominal_state(), model.nominal_input()
        F, Q = functions.transition(x, u, 1.0 / rate_hz)
        rates = dict(sensor_rates_hz or {})
        sensors = []
        for i, s in enumerate(model.sensors):
            every = _every(s.name, rates.pop(s.name, rate_hz), rate_hz)
            sensors.append(SensorRows(s.name, functions.jacobian(i, x, model.nominal_known(i)), s.sd**2, every))
        if rates:
            raise InputError("sensor_rates_hz", got=", ".join(rates), expected=", ".join(s.name for s in model.sensors))
        self.table: GainTable = gain_table(F, Q, sensors, 1.0 / rate_hz, startup)
        _check_pattern(functions, self.table.gains)

    @property
    def name(self) -> str:
        """``h2``, with ``-euler`` on the published model."""
        return "h2" + _form(self.model)

    @property
    def certificate(self) -> Certificate:
        """What the steady gain promises, verified by a second route."""
        return self.table.certificate

    def setup(self, x: Array, P: Array | None = None) -> FilterSetup:
        """Return what a filter is started with; the covariance is the design's, so ``P`` is not used."""
        return FilterSetup("fixed", x, None, _rules(self.model, {}), times=self.table.times, gains=self.table.gains)

    def covariance_at(self, elapsed: Array) -> Array:
        """Return the designed covariance (n, ne, ne) at times since the start (n,) [s], body vectors in n axes."""
        chosen = np.searchsorted(self.table.times, elapsed, side="right") - 1
        out: Array = self.table.covariance[np.maximum(chosen, 0)]
        return out


Estimator = EKF | UKF | HInfinity | H2


def _turning(model: Model, intensity: float) -> Turning | None:
    if model.rotation is None or model.rotation.error != "n":
        return None
    from robustnav.design.schedule import Turning

    return Turning(tuple(model.error_slices[b.name] for b in model.state if b.frame == "b"), intensity)


def _every(name: str, sensor_hz: float, rate_hz: float) -> int:
    every = round(rate_hz / sensor_hz) if sensor_hz > 0 else 0
    if every < 1:
        raise InputError(f"rate of {name!r}", got=f"{sensor_hz} Hz", expected=f"a rate in (0, {rate_hz:g}] Hz")
    return every


def _check_pattern(functions: Any, gains: Array) -> None:
    """The compiled gain drops entries that the model's structure says are zero: they must be."""
    if not hasattr(functions, "gain"):
        return
    n, rows = gains.shape[-2:]
    kept = np.array([functions.gain(np.ones((n, rows)), column) for column in np.eye(rows)]).T != 0
    dropped = np.abs(np.where(kept, 0.0, gains)).max(axis=(0, 1))
    scale = np.abs(gains).max(axis=(0, 1)).max()
    if dropped.max() > 1e-9 * scale:
        raise InputError(
            "constant gain",
            got=f"an entry {dropped.max():.3g} where the compiled model has none",
            expected="a gain designed at the model's nominal point",
        )
