"""Initial alignment of a strapdown unit at rest on a swaying, wind-disturbed carrier: no prior, no known wind."""

from robustnav.alignment.align import Alignment, align
from robustnav.alignment.bank import Aligner
from robustnav.alignment.heading_bank import BankRun, HeadingBank, heading_bank
from robustnav.alignment.readings import reading_rows, zero_velocity
from robustnav.alignment.setting import AlignSetup, Wind
from robustnav.alignment.wahba import wahba_attitude

__all__ = [
    "AlignSetup",
    "Aligner",
    "Alignment",
    "BankRun",
    "HeadingBank",
    "Wind",
    "align",
    "heading_bank",
    "reading_rows",
    "wahba_attitude",
    "zero_velocity",
]
