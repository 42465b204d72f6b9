"""Units of order one for a design: semidefinite solvers stop early on badly scaled data and call it optimal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.design.matrices import matrix, right_divide
from robustnav.design.plant import Plant
from robustnav.errors import InputError
from robustnav.records import Array


@dataclass(frozen=True)
class Scaling:
    """Change of units x = T x_s, y = R^1/2 y_s, z = size z_s that makes a plant's numbers of order one.

    Parameters
    ----------
    states : (n,) diagonal of T: expected standard deviation of each state's error, in its unit.
    outputs : (m, m) a square root of the sensor-noise intensity, lower triangular.
    size : expected size of z.
    """

    states: Array
    outputs: Array
    size: float

    @staticmethod
    def expected(plant: Plant, states: Array) -> Scaling:
        """Return the scaling for expected error standard deviations ``states`` (n,), all positive."""
        T = matrix(states, (len(plant.A),), "scaling: expected standard deviations")
        if not np.all(T > 0):
            raise InputError("scaling: expected standard deviations", got=str(T), expected="numbers above zero")
        size = float(np.linalg.norm(plant.C_z * T))
        return Scaling(T, np.asarray(np.linalg.cholesky(plant.R)), size if size > 0 else 1.0)

    def apply(self, plant: Plant) -> Plant:
        """Return the same plant in the scaled units."""
        T = self.states
        output: Array = np.asarray(np.linalg.solve(self.outputs, np.hstack([plant.C_y * T, plant.D_w])), float)
        return Plant(
            A=plant.A * T / T[:, None],
            B_w=plant.B_w / T[:, None],
            C_y=output[:, : len(T)],
            D_w=output[:, len(T) :],
            C_z=plant.C_z * T / self.size,
        )

    def gain(self, L_scaled: Array) -> Array:
        """Return in the plant's own units the gain L (n, m) found in the scaled ones: T L_s R^-1/2."""
        return self.states[:, None] * right_divide(L_scaled, self.outputs)
