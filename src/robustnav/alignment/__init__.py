"""Initial alignment of a strapdown unit at rest on a swaying, wind-disturbed carrier: no prior, no known wind."""

from robustnav.alignment.align import Alignment, align
from robustnav.alignment.bank import Aligner
from robustnav.alignment.readings import reading_rows, zero_velocity
from robustnav.alignment.setting import AlignSetup, Wind

__all__ = ["AlignSetup", "Aligner", "Alignment", "Wind", "align", "reading_rows", "zero_velocity"]
