"""How far the integer filter may be from the double one, part by part; docs/firmware.md, section 4."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, sqrt

import numpy as np

from robustnav.export.scaling import WIDTH, Scaling
from robustnav.frames import Array
from robustnav.model.blocks import Model


@dataclass(frozen=True)
class Budget:
    """Parts of the attitude difference [rad].

    ``late``: the last correction, which waits for the next update, three standard deviations with the model's noise;
    ``cut``: attitude and rotation matrix cut to Q15; ``waiting``: half turns kept for the next; ``rounding``: three
    standard deviations of what rounded corrections leave, sensor noise dithering them; ``reference``: the field's
    length through rounded gains; ``dead``: largest error that rounded corrections do not see without any noise.
    """

    late: float
    cut: float
    waiting: float
    rounding: float
    reference: float
    dead: float

    @classmethod
    def of(cls, scaling: Scaling, K: Array, model: Model) -> Budget:
        """Return the budget of a scaling for the gain (6, 5) it was derived from."""
        g, north, down = (model.parameters[name] for name in ("gravity", "mag_north", "mag_down"))
        H = np.array([[0, g, 0], [-g, 0, 0], [0, -down, 0], [down, 0, -north], [0, north, 0]])
        share = float(np.abs(np.linalg.eigvals(K[:3] @ H)).min())  # of an error that one update takes away
        part = scaling.sets[3]
        unit = 2.0 * 2.0**-part.turn
        counts = np.array([0, 0, north, 0, down]) / scaling.counts.mag * 2.0 ** WIDTH["mag"]
        pushed = float(np.abs(part.gains @ counts).max()) / 2.0**part.gains_down * unit
        spread = sqrt(2.0 * share - share * share)
        sd = np.sqrt(model.variances[[0, 0, 1, 1, 1]])
        late = 3.0 * float(np.linalg.norm(K[:3] * sd))
        return cls(late, 2.0 * 2.0**-15, 2 * sqrt(3) * 2.0**-scaling.coarse, 3 * unit / sqrt(12) / spread,
                   pushed / share, unit / 2 / share)  # fmt: skip

    @property
    def whole(self) -> float:
        """All parts but the dead zone."""
        return self.late + self.cut + self.waiting + self.rounding + self.reference

    @property
    def said(self) -> str:
        """A sentence for the README."""
        parts = ", ".join(
            f"{degrees(getattr(self, p)):.4f} {p}" for p in ("late", "cut", "waiting", "rounding", "reference")
        )
        return (
            f"Difference from the double filter: at most {degrees(self.whole):.3f} deg ({parts}); without any sensor "
            f"noise to dither them, corrections of errors below {degrees(self.dead):.2f} deg round to nothing."
        )
