"""`python -m hysgen` is the command `hysgen`."""

import _thread
import signal
import sys
import threading


def _again(swallowed: "sys.UnraisableHookArgs") -> None:
    """Interrupt once more: Python drops what is raised in a callback of a weak reference, and goes on."""
    if issubclass(swallowed.exc_type, KeyboardInterrupt):
        threading.Timer(0.01, _thread.interrupt_main).start()
    else:
        sys.__unraisablehook__(swallowed)


def run() -> int:
    """The command line; an interrupt while its modules are loaded is one line, too."""
    sys.unraisablehook = _again
    try:
        from hysgen.cli import main

        return main()
    except KeyboardInterrupt:
        print("\nhysgen: interrupted before anything was done", file=sys.stderr)
        return 130
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the answer is given
        # CPython notes an interrupt in executed text, as a dataclass is made of, and would end by the signal.
        exec("")


if __name__ == "__main__":
    raise SystemExit(run())
