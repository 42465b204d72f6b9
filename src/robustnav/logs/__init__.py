"""Other people's recordings into streams: SI units, body forward-right-down, one file per format."""

from robustnav.logs.reading import read
from robustnav.logs.table_write import write_table

__all__ = ["read", "write_table"]
