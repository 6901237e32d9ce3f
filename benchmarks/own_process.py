"""Time and memory of a task in a process of its own (Linux)."""

from __future__ import annotations

import multiprocessing
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Done:
    """Result of a task. seconds: of the task; MB: growth of the peak resident size of its process."""

    value: Any
    seconds: float
    MB: float


def alone(task: Callable[..., Any], *arguments: Any) -> Done:
    """Run `task` in a new process."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(_timed, task, arguments).result()


def _timed(task: Callable[..., Any], arguments: Sequence[Any]) -> Done:
    warnings.simplefilter("ignore")
    prepared = task(*arguments)
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # The peak becomes the present size.
    before = _peak_MB()
    begun = time.perf_counter()
    value = prepared()
    seconds = time.perf_counter() - begun
    return Done(value, seconds, _peak_MB() - before)


def _peak_MB() -> float:
    """The peak resident size of this process [MB]; Linux only."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return float(status.partition("VmHWM:")[2].split()[0]) / 1024
