"""Output of the verbs: text at the width of a terminal on stdout, warnings and progress on stderr, JSON."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shlex
import shutil
import sys
import textwrap
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from hysgen.cli.progress import ProgressLine
from hysgen.errors import RecordWarning
from hysgen.machine.files import version, write_whole

RULER = re.compile(r"-+(?:  -+)+")
"""The line under the header of a table."""

NARROWEST = 10
"""Columns of a table are not narrowed below this."""

CELLS = re.compile(r"\S {2,}\S")
"""Two blanks inside a line: columns that belong to no table, which are not folded."""


def folded(text: str, width: int | None) -> str:
    """The text with sentences and tables folded at `width` columns; None folds nothing.

    >>> print(folded("noise floor 0.001 um rms from rests of the input", 24))
    noise floor 0.001 um rms
        from rests of the
        input
    >>> print(folded("cause  because\\n-----  -----------------------\\ncreep  the longest rest is 0 s", 24))
    cause  because
    -----  -----------------
    creep  the longest rest
           is 0 s
    """
    if width is None:
        return text
    lines = text.split("\n")
    made: list[str] = []
    at = 0
    while at < len(lines):
        if at + 1 < len(lines) and RULER.fullmatch(lines[at + 1]) and len(lines[at + 1]) > width:
            end = _end(lines, at + 1)
            made += _narrowed(lines[at], lines[at + 1], lines[at + 2 : end], width)
            at = end
            continue
        line = lines[at]
        at += 1
        if len(line) <= width or CELLS.search(line):
            made.append(line)
        else:
            made += textwrap.wrap(line, width, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(made)


def _spans(ruler: str) -> list[tuple[int, int]]:
    return [match.span() for match in re.finditer("-+", ruler)]


def _end(lines: Sequence[str], ruler: int) -> int:
    """The line behind the rows of a table: the first that is blank or writes between the columns."""
    spans = _spans(lines[ruler])
    for at in range(ruler + 1, len(lines)):
        line = lines[at]
        if not line.strip() or any(line[stop : stop + 2].strip() for _, stop in spans):
            return at
    return len(lines)


def _narrowed(header: str, ruler: str, rows: Sequence[str], width: int) -> list[str]:
    """The table with its widest columns of text narrowed until it fits; as it is if columns of numbers are too wide."""
    spans = _spans(ruler)
    cells = [[line[start:stop].rstrip() for start, stop in spans] for line in (header, *rows)]
    right = [all(len(row[j]) in (0, b - a) for row in cells) for j, (a, b) in enumerate(spans)]
    widths = [stop - start for start, stop in spans]
    text = [j for j, is_right in enumerate(right) if not is_right]
    while sum(widths) + 2 * (len(widths) - 1) > width:
        widest = max(text, key=lambda j: widths[j], default=None)
        if widest is None or widths[widest] <= NARROWEST:
            return [header, ruler, *rows]
        widths[widest] -= 1
    made: list[str] = []
    for number, row in enumerate(cells):
        parts = [
            textwrap.wrap(cell.strip(), w, break_on_hyphens=False) or [""] for cell, w in zip(row, widths, strict=True)
        ]
        for line in range(max(map(len, parts))):
            pieces = [part[line] if line < len(part) else "" for part in parts]
            placed = (
                piece.rjust(w) if is_right else piece.ljust(w)
                for piece, w, is_right in zip(pieces, widths, right, strict=True)
            )
            made.append("  ".join(placed).rstrip())
        if number == 0:
            made.append("  ".join("-" * w for w in widths))
    return made


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

    @contextlib.contextmanager
    def warnings_of_records(self) -> Iterator[None]:
        """Print every RecordWarning as `warn` does; other warnings as Python does."""
        with warnings.catch_warnings():
            otherwise = warnings.showwarning

            def show(message: Warning | str, category: type[Warning], *place: Any) -> None:
                if issubclass(category, RecordWarning):
                    self.warn(str(message))
                else:
                    otherwise(message, category, *place)

            warnings.simplefilter("always", RecordWarning)
            warnings.showwarning = show  # type: ignore[assignment]
            yield

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
