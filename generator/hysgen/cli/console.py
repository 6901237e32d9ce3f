"""Output of the verbs: text on stdout, warnings and progress on stderr, JSON to a file or to stdout."""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import shutil
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from hysgen.cli.folding import folded
from hysgen.cli.progress import ProgressLine
from hysgen.machine.files import write_whole
from hysgen.machine.installed import version

SCHEMA_VERSION = 1
"""Version of the JSON of all verbs: it rises when a key changes its meaning or goes; new keys may come at any time."""


@dataclass
class Console:
    """Output of one verb. json_to: a file, "-" for stdout (text is then suppressed), or None for no JSON.

    verb: named by the schema of the JSON. quiet: print neither progress nor warnings. verbose: every step of the
    progress on a line of its own. On a terminal, lines are folded to its width.
    """

    json_to: str | None = None
    out: TextIO = field(default_factory=lambda: sys.stdout)
    err: TextIO = field(default_factory=lambda: sys.stderr)
    verb: str = ""
    quiet: bool = False
    verbose: bool = False

    def __post_init__(self) -> None:
        self._progress = ProgressLine(self.err, self.verbose)

    def say(self, text: str = "") -> None:
        """Print lines of text, unless stdout carries the JSON."""
        self._progress.pause()
        if self.json_to != "-":
            try:
                print(folded(text, self._width()), file=self.out, flush=True)
            except BrokenPipeError:
                # Its reader has seen enough; the files of the verb are still wanted.
                discard_stdout()

    def warn(self, text: str) -> None:
        """Print a warning on stderr."""
        if self.quiet:
            return
        self._progress.pause()
        with contextlib.suppress(BrokenPipeError):
            print(folded(f"warning: {text}", self._width()), file=self.err, flush=True)

    def progress(self, fraction: float, what: str) -> None:
        """Print the fraction done and what is being done (`ProgressLine`)."""
        if not self.quiet:
            self._progress.show(fraction, what)

    def close(self) -> None:
        """End the progress; the verb is done or has failed."""
        self._progress.stop()

    def _width(self) -> int | None:
        """Columns of the terminal; None for output to a file, unless the environment variable COLUMNS is set."""
        if self.out.isatty() or os.environ.get("COLUMNS", "").isdecimal():
            return max(shutil.get_terminal_size().columns, 40)
        return None

    def write_json(self, result: Mapping[str, Any]) -> None:
        """Write the result of the verb as JSON with the option --json. Raises ValueError for NaN and infinity."""
        if self.json_to is None:
            return
        text = json.dumps(self.with_head(result), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        if self.json_to == "-":
            self._progress.pause()
            print(text, end="", file=self.out, flush=True)
        else:
            write_whole(Path(self.json_to), text)

    def with_head(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        """The result with its schema: `hysgen-VERB` in the version SCHEMA_VERSION, unless it has one of its own."""
        head = {"schema": f"hysgen-{self.verb}", "version": SCHEMA_VERSION, "hysgen": version()}
        return result if "schema" in result else head | dict(result)

    def finish(self, result: Mapping[str, Any], holds: bool = True) -> int:
        """Write the result as JSON. Returns the exit code: 0 if the answer is yes, else 1."""
        self.write_json(result)
        return 0 if holds else 1


def command_line() -> str:
    """The command line of this process; "" where another program called this module."""
    program = Path(sys.argv[0])
    own = program.name == "hysgen" or (program.name == "__main__.py" and program.parent.name == "hysgen")
    return " ".join(["hysgen", *map(shlex.quote, sys.argv[1:])]) if own else ""


def discard_stdout() -> None:
    """Send what is still in the buffer of stdout to nowhere, so that Python does not fail on it at its end."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
