"""What data sheets say of sensors: named presets in SI, used by models and by the simulator."""

from robustnav.datasheet.presets import imu, magnetometer, names
from robustnav.datasheet.sensors import Imu, Magnetometer, SensorSpec

__all__ = ["Imu", "Magnetometer", "SensorSpec", "imu", "magnetometer", "names"]
