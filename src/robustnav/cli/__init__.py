"""The command line: every verb parses its arguments and calls one public function."""

from robustnav.cli.app import main

__all__ = ["main"]
