"""The command line: `hysgen VERB ...`."""

from hysgen.cli.main import main

__all__ = ["main"]
