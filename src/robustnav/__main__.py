"""``python -m robustnav``: the command line."""

import sys

from robustnav.cli import main

sys.exit(main())
