"""Other people's recordings into streams: SI units, body forward-right-down, one file per format.

``read`` opens flights and trials by their content; sets of ranges are opened by name, for a folder or a pair of files
does not tell what it is.
"""

from robustnav.logs.reading import read
from robustnav.logs.table_write import write_table
from robustnav.logs.uwb_hyu import read_uwb_hyu
from robustnav.logs.uwb_hyu_static import read_uwb_hyu_static
from robustnav.logs.uwb_isas import read_uwb_isas
from robustnav.logs.uwb_lias import read_uwb_lias, read_uwb_lias_sheet
from robustnav.logs.uwb_recording import RangeRecording, StaticRanges
from robustnav.logs.uwb_table import read_uwb_table

__all__ = [
    "RangeRecording",
    "StaticRanges",
    "read",
    "read_uwb_hyu",
    "read_uwb_hyu_static",
    "read_uwb_isas",
    "read_uwb_lias",
    "read_uwb_lias_sheet",
    "read_uwb_table",
    "write_table",
]
