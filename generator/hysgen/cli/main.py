"""Entry of the command line: runs the verb and turns each error into one line and an exit code.

Exit codes: 0 done; 1 done with a negative answer (bits differ, a file is stale, a model misses its target);
2 not done: bad input, a missing tool; 130 interrupted.
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
    """argparse with one-line errors, as in the rest of the program."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser(names: Sequence[str] = NAMES) -> argparse.ArgumentParser:
    """The parser of the command line with the verbs `names`."""
    top = _Parser(prog="hysgen", description=_DESCRIPTION)
    top.add_argument("--version", action="version", version=f"hysgen {version()}")
    verbs = top.add_subparsers(dest="verb", metavar="VERB", required=True, parser_class=_Parser)
    for name in names:
        chosen = verb(name)
        sub = verbs.add_parser(
            name,
            help=chosen.help.strip().splitlines()[0],
            description=chosen.help,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        chosen.arguments(sub)
        sub.add_argument("--json", metavar="FILE", help="write the result as JSON to FILE, or to stdout with -")
        sub.set_defaults(run=chosen.run)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb. Returns the exit code. A HysgenError is printed as one line without traceback."""
    words = list(sys.argv[1:] if argv is None else argv)
    names = [words[0]] if words and words[0] in NAMES else NAMES
    arguments = parser(names).parse_args(words)
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
        # The reader closed the pipe. This is no error, and Python must not report one when it closes stdout.
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
