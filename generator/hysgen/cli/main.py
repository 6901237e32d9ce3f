"""Choosing the verb, and turning every fault of the user's into one line and an exit code.

Exit codes: 0 done; 1 done, and the answer is no (bits differ, a file is stale, a model misses what was asked);
2 it could not be done: bad input, a missing tool; 130 interrupted.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from hysgen.cli.console import Console
from hysgen.cli.verbs import NAMES, verb
from hysgen.errors import HysgenError
from hysgen.machine.installed import version

_DESCRIPTION = (
    "From measured voltage/displacement records of a piezo stage to verified float32 C: "
    "fit a fuzzy hysteresis model, see what its simulation gets wrong, and generate prediction, learning and inverse."
)


class _Parser(argparse.ArgumentParser):
    """argparse, but one line a fault, like every other error of this program."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser(names: Sequence[str] = NAMES) -> argparse.ArgumentParser:
    """The whole command line, for the program and for its documentation; or that of some verbs alone."""
    top = _Parser(prog="hysgen", description=_DESCRIPTION)
    top.add_argument("--version", action="version", version=f"hysgen {version()}")
    verbs = top.add_subparsers(dest="verb", metavar="VERB", required=True, parser_class=_Parser)
    for name in names:
        module = verb(name)
        summary = (module.__doc__ or "").strip().splitlines()[0]
        sub = verbs.add_parser(
            name, help=summary, description=module.__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        module.arguments(sub)
        sub.add_argument("--json", metavar="FILE", help="write the result as JSON to FILE, or to stdout with -")
        sub.set_defaults(run=module.run)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; returns the exit code. Never prints a traceback for a fault of the user's."""
    words = list(sys.argv[1:] if argv is None else argv)
    asked = [words[0]] if words and words[0] in NAMES else NAMES
    arguments = parser(asked).parse_args(words)
    console = Console(json_to=arguments.json)
    try:
        return int(arguments.run(arguments, console))
    except HysgenError as fault:
        text = " ".join(str(fault).split())
        print(f"hysgen {arguments.verb}: {text}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"\nhysgen {arguments.verb}: interrupted; files already written are whole", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of a pipe went away: nothing is wrong, but Python must not complain while closing stdout.
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
