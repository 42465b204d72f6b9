"""``design``: gains with their certificates, before any data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from cyclopts import App, Parameter

from robustnav.cli.options import Flag
from robustnav.cli.show import say, say_json, say_settings, say_table
from robustnav.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from robustnav.design import Certificate, Plant
    from robustnav.model.blocks import Model
    from robustnav.models import AttitudeNoise

design = App(name="design", help="Design a constant attitude gain and certify it.")
STATES = ("eps_N", "eps_E", "eps_D", "beta_N", "beta_E", "beta_D")
READINGS = ("f_N", "f_E", "m_N", "m_E", "m_D")
SIGN = "x_hat' = A x_hat + B u + L (y_hat - y)"


@Parameter(name="*")
@dataclass(frozen=True)
class Setting:
    """Sensors and place of a design."""

    imu: str = "mpu9250"
    """Data-sheet preset of the IMU."""
    magnetometer: str = "ak8963"
    """Data-sheet preset of the magnetometer."""
    rate_hz: float = 100.0
    """Sample rate."""
    bias_walk_dps_rts: float = 1e-4
    """Random walk of the gyro bias, deg/s per root second; no data sheet states it."""
    field_ut: float = 48.0
    """Strength of the magnetic field, microtesla."""
    dip_deg: float = 60.0
    """Angle of the field below the horizon."""

    def noise(self) -> AttitudeNoise:
        """Return the sensors' noise at the sample rate."""
        from robustnav.models import AttitudeNoise
        from robustnav.units import DPS

        if not self.rate_hz > 0:
            raise InputError("--rate-hz", got=str(self.rate_hz), expected="a rate above zero")
        walk = self.bias_walk_dps_rts * DPS
        return AttitudeNoise.from_datasheet(self.imu, self.magnetometer, self.rate_hz, gyro_bias_density=walk)

    def model(self) -> Model:
        """Return the nine-axis attitude model at these numbers."""
        from robustnav.models import attitude
        from robustnav.units import MICRO_TESLA

        return attitude(self.noise(), field=self.field_ut * MICRO_TESLA, dip_deg=self.dip_deg)

    def plant(self) -> Plant:
        """Return the attitude error's plant at these numbers."""
        from robustnav.run.plants import plant_of

        return plant_of(self.model(), self.rate_hz)


STANDARD = Setting()


@design.command
def h2(
    setting: Setting = STANDARD, *, route: Literal["riccati", "lmi", "both"] = "riccati", json: Flag = False
) -> None:
    """Design the H2-optimal gain by the Riccati equation, by the published LMI (extra `lmi`), or by both.

    Parameters
    ----------
    setting
        Sensors and place.
    route
        How the gain is found; both also prints how far the two gains are apart.
    json
        Print one JSON document.
    """
    from robustnav.design import h2_lmi, h2_riccati

    plant = setting.plant()
    routes = {"riccati": (h2_riccati,), "lmi": (h2_lmi,), "both": (h2_riccati, h2_lmi)}[route]
    designs = [find(plant) for find in routes]
    numbers: dict[str, object] = {"h2_norm": designs[0].gamma}
    if len(designs) == 2:
        apart = abs(designs[0].L - designs[1].L).max() / abs(designs[0].L).max()
        numbers["largest_difference_of_the_routes"] = float(apart)
    _show("h2", setting, designs[0].L, designs[0].certificate, numbers, json)


@design.command
def hinf(setting: Setting = STANDARD, *, gamma: float | None = None, json: Flag = False) -> None:
    """Design an H-infinity gain: the smallest gamma by bisection, or a given one, verified by a frequency sweep.

    Parameters
    ----------
    setting
        Sensors and place.
    gamma
        Bound to reach; default: one per cent above the smallest.
    json
        Print one JSON document.
    """
    from robustnav.design import hinf_observer

    found = hinf_observer(setting.plant(), gamma)
    numbers: dict[str, object] = {"gamma": found.gamma, "largest_gain_over_frequency": found.swept}
    _show("hinf", setting, found.L, found.certificate, numbers, json)


def _show(
    kind: str, setting: Setting, L: np.ndarray, certificate: Certificate, numbers: dict[str, object], json: bool
) -> None:
    proof = vars(certificate) | {"eigenvalues": [str(complex(e)) for e in certificate.eigenvalues]}
    if json:
        say_json({"design": kind, "setting": vars(setting), "gain": L, "sign": SIGN, **numbers, "certificate": proof})
        return
    rows = [{"state": s} | dict(zip(READINGS, map(float, row), strict=True)) for s, row in zip(STATES, L, strict=True)]
    say_table(f"Gain L of {SIGN}", rows)
    say()
    say_settings(numbers | {f"certificate: {name}": value for name, value in proof.items()})
