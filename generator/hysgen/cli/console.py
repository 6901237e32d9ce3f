"""What the terminal sees: tables and sentences on stdout, progress on stderr, JSON where it was asked for."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from hysgen.machine.files import write_whole

SECONDS_BETWEEN_PLAIN_LINES = 5.0


@dataclass
class Console:
    """Where a verb speaks. `json_to` is a file, "-" for stdout (then nothing else goes there), or None."""

    json_to: str | None = None
    out: TextIO = field(default_factory=lambda: sys.stdout)
    err: TextIO = field(default_factory=lambda: sys.stderr)
    _last_line: float = 0.0
    _open_line: bool = False

    def say(self, text: str = "") -> None:
        """One or more lines for people; silent where stdout carries the JSON."""
        self._close_line()
        if self.json_to != "-":
            print(text, file=self.out, flush=True)

    def warn(self, text: str) -> None:
        """A warning on stderr."""
        self._close_line()
        print(f"warning: {text}", file=self.err, flush=True)

    def progress(self, fraction: float, what: str) -> None:
        """How far the long work is: one line rewritten on a terminal, a line every few seconds elsewhere."""
        now = time.monotonic()
        if self.err.isatty():
            print(f"\r\x1b[K{100 * fraction:5.1f} %  {what}", end="", file=self.err, flush=True)
            self._open_line = True
        elif now - self._last_line >= SECONDS_BETWEEN_PLAIN_LINES:
            print(f"{100 * fraction:5.1f} %  {what}", file=self.err, flush=True)
            self._last_line = now

    def write_json(self, result: Mapping[str, Any]) -> None:
        """The verb's result, if it was asked for: sorted as given, two spaces, exact numbers, no NaN."""
        if self.json_to is None:
            return
        text = json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        if self.json_to == "-":
            self._close_line()
            print(text, end="", file=self.out, flush=True)
        else:
            write_whole(Path(self.json_to), text)

    def _close_line(self) -> None:
        if self._open_line:
            print("\r\x1b[K", end="", file=self.err, flush=True)
            self._open_line = False
