"""The progress of a verb on stderr: what it does, the fraction done, the seconds passed and left."""

from __future__ import annotations

import contextlib
import shutil
import threading
import time
from dataclasses import dataclass, field
from typing import Final, TextIO

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
