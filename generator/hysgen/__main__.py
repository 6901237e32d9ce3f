"""`python -m hysgen` is the command `hysgen`."""

from __future__ import annotations

import sys


def run() -> int:
    """The command line; an interrupt while its modules are loaded is one line, too."""
    try:
        from hysgen.cli import main

        return main()
    except KeyboardInterrupt:
        print("\nhysgen: interrupted before anything was done", file=sys.stderr)
        return 130


if __name__ == "__main__":
    raise SystemExit(run())
