"""Output of the verbs: text at the width of a terminal on stdout, warnings and progress on stderr, JSON."""

import contextlib
import json
import os
import re
import shlex
import shutil
import sys
import textwrap
import threading
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TextIO

from hysgen.display import WRITTEN_IN
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
                shown = folded(WRITTEN_IN.get().text(text), self._width())
                code = getattr(self.out, "encoding", None) or "utf-8"  # a pipe may have no letter for a picture
                print(shown.encode(code, "replace").decode(code), file=self.out, flush=True)
            except BrokenPipeError:
                # Its reader has seen enough; the files of the verb are still wanted.
                discard_stdout()

    def warn(self, text: str) -> None:
        """Print a warning on stderr."""
        if self.quiet:
            return
        self._progress.pause()
        with contextlib.suppress(BrokenPipeError):
            print(folded(f"warning: {WRITTEN_IN.get().text(text)}", self._width()), file=self.err, flush=True)

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
            self._progress.show(fraction, WRITTEN_IN.get().text(what))

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
        head: dict[str, Any] = {"schema": f"hysgen-{self.verb}", "version": SCHEMA_VERSION, "hysgen": version()}
        stated = WRITTEN_IN.get()
        if stated.other:  # what stands in the keys that end so
            head |= {"units": {"_V": stated.input_unit, "_um": stated.output_unit}}
        return result if "schema" in result else head | stated.json(dict(result))

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


SECONDS: Final = 2.0
"""Longest time between two lines while a verb computes, also where the fraction does not change."""

SECONDS_ON_TERMINAL: Final = 0.5

LEAST_SECONDS: Final = 3.0
"""Run time in seconds from which on a line states the time passed and the time left."""

LEAST_FRACTION: Final = 0.05
"""Fraction done from which on a line states the time left."""


@dataclass
class ProgressLine:
    """One line that is rewritten on a terminal; lines of their own in a file, at most one in SECONDS unless verbose.

    started: time of the first second, of time.monotonic(). A thread repeats the last line with its new time until
    `stop`.
    """

    err: TextIO
    verbose: bool = False
    started: float = field(default_factory=time.monotonic)
    _printed: float = 0.0
    _last: tuple[float, str] | None = None
    _estimated: tuple[float, float, float] = (0.0, 0.0, 0.0)
    _open: bool = False
    _lock: threading.RLock = field(default_factory=threading.RLock)
    _ended: threading.Event = field(default_factory=threading.Event)
    _thread: threading.Thread | None = None

    def show(self, fraction: float, what: str) -> None:
        """Print the fraction done and what is being done."""
        with self._lock:
            self._last = None if fraction >= 1.0 else (fraction, what)
            if fraction != self._estimated[0]:
                now = time.monotonic()
                remaining_s = (now - self.started) * (1.0 - fraction) / fraction if fraction > LEAST_FRACTION else 0.0
                self._estimated = fraction, now, remaining_s
            if self.verbose or fraction >= 1.0 or time.monotonic() - self._printed >= self._interval():
                self._print(fraction, what)
            if self._thread is None and self._last is not None:
                thread = threading.Thread(target=self._repeat, daemon=True)
                with contextlib.suppress(RuntimeError):  # no memory for a thread: nothing is repeated
                    thread.start()
                    self._thread = thread

    def pause(self) -> None:
        """Clear the line of a terminal, because other text follows; nothing is repeated until the next `show`."""
        with self._lock:
            self._last = None
            if self._open:
                with contextlib.suppress(BrokenPipeError):
                    print("\r\x1b[K", end="", file=self.err, flush=True)
                self._open = False

    def stop(self) -> None:
        """End the thread."""
        self.pause()
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def _interval(self) -> float:
        return SECONDS_ON_TERMINAL if self.err.isatty() else SECONDS

    def _repeat(self) -> None:
        while not self._ended.wait(0.25):
            with self._lock, contextlib.suppress(OSError, ValueError):
                if self._last is not None and time.monotonic() - self._printed >= self._interval():
                    self._print(*self._last)

    def _print(self, fraction: float, what: str) -> None:
        with contextlib.suppress(BrokenPipeError):  # a reader of stderr has closed it; the verb goes on
            self._print_line(fraction, what)

    def _print_line(self, fraction: float, what: str) -> None:
        now = time.monotonic()
        line = f"{100 * fraction:5.1f} %  {what}{self._seconds(fraction, now)}"
        if self.err.isatty() and not self.verbose:
            width = shutil.get_terminal_size().columns
            print(f"\r\x1b[K{line[: width - 1]}", end="", file=self.err, flush=True)
            self._open = True
        else:
            print(line, file=self.err, flush=True)
        self._printed = now

    def _seconds(self, fraction: float, now: float) -> str:
        """Seconds since the start, and those that are left if the rest goes as fast.

        The time left is estimated where the fraction changes and counts down from there, until nothing is left.
        """
        passed = now - self.started
        if passed < LEAST_SECONDS:
            return ""
        _, at, estimate = self._estimated
        remaining_s = estimate - (now - at)
        return (
            f"  ({passed:.0f} s{f', about {remaining_s:.0f} s left' if remaining_s >= 0.5 and fraction < 1.0 else ''})"
        )
