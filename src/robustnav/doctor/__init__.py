"""The doctor: what is in a recording, and which units, signs, frames and stamps in it are suspicious."""

from robustnav.doctor.examine import examine
from robustnav.doctor.record import Diagnosis, Finding

__all__ = ["Diagnosis", "Finding", "examine"]
