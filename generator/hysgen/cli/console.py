"""Output of the verbs: text on stdout, warnings and progress on stderr, JSON to a file or to stdout."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from hysgen.machine.files import write_whole
from hysgen.machine.installed import version

SCHEMA_VERSION = 1
"""Version of the JSON of all verbs: it rises when a key changes its meaning or goes; new keys may come at any time."""

SECONDS_BETWEEN_PLAIN_LINES = 5.0


@dataclass
class Console:
    """Output of one verb. json_to: a file, "-" for stdout (text is then suppressed), or None for no JSON.

    verb: named by the schema of the JSON. quiet: print neither progress nor warnings.
    """

    json_to: str | None = None
    verb: str = ""
    quiet: bool = False
    out: TextIO = field(default_factory=lambda: sys.stdout)
    err: TextIO = field(default_factory=lambda: sys.stderr)
    _last_line: float = 0.0
    _open_line: bool = False

    def say(self, text: str = "") -> None:
        """Print lines of text, unless stdout carries the JSON."""
        self._close_line()
        if self.json_to != "-":
            print(text, file=self.out, flush=True)

    def warn(self, text: str) -> None:
        """Print a warning on stderr."""
        if self.quiet:
            return
        self._close_line()
        print(f"warning: {text}", file=self.err, flush=True)

    def progress(self, fraction: float, what: str) -> None:
        """Print the fraction done: one line rewritten on a terminal, else a line every few seconds."""
        if self.quiet:
            return
        now = time.monotonic()
        if self.err.isatty():
            print(f"\r\x1b[K{100 * fraction:5.1f} %  {what}", end="", file=self.err, flush=True)
            self._open_line = True
        elif now - self._last_line >= SECONDS_BETWEEN_PLAIN_LINES:
            print(f"{100 * fraction:5.1f} %  {what}", file=self.err, flush=True)
            self._last_line = now

    def write_json(self, result: Mapping[str, Any]) -> None:
        """Write the result of the verb as JSON with the option --json. Raises ValueError for NaN and infinity.

        A result without a schema of its own gets "hysgen-VERB" with the version SCHEMA_VERSION (docs/json.md).
        """
        if self.json_to is None:
            return
        head = {"schema": f"hysgen-{self.verb}", "version": SCHEMA_VERSION, "hysgen": version()}
        result = result if "schema" in result else head | dict(result)
        text = json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        if self.json_to == "-":
            self._close_line()
            print(text, end="", file=self.out, flush=True)
        else:
            write_whole(Path(self.json_to), text)

    def finish(self, result: Mapping[str, Any], holds: bool = True) -> int:
        """Write the result as JSON. Returns the exit code: 0 if the answer is yes, else 1."""
        self.write_json(result)
        return 0 if holds else 1

    def _close_line(self) -> None:
        if self._open_line:
            print("\r\x1b[K", end="", file=self.err, flush=True)
            self._open_line = False
