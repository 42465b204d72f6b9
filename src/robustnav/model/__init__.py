"""Models as data: blocks and equations, their Jacobians, their discretisation, their C."""

from robustnav.model.blocks import Equations, Model, Noise, Rotation, Sensor, Symbols, Vector

__all__ = ["Equations", "Model", "Noise", "Rotation", "Sensor", "Symbols", "Vector"]
