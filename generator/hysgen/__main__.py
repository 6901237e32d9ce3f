"""`python -m hysgen` is the command `hysgen`."""

import sys


def run() -> int:
    """The command line; an interrupt while its modules are loaded is one line, too."""
    try:
        from hysgen.cli import main

        return main()
    except KeyboardInterrupt:
        print("\nhysgen: interrupted before anything was done", file=sys.stderr)
        return 130
    finally:
        # CPython notes an interrupt in executed text, as a dataclass is made of, and would end by the signal.
        exec("")


if __name__ == "__main__":
    raise SystemExit(run())
