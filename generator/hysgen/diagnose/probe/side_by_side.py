"""Trials side by side: the kernels and BLAS let go of the interpreter, so threads share the processor's cores.

Results come in the order of the trials whatever their number of threads; nothing depends on which is done first.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Trial = TypeVar("Trial")
Result = TypeVar("Result")

MOST_THREADS = 4
"""More have to wait for the interpreter between two kernels."""


def side_by_side(function: Callable[[Trial], Result], trials: Iterable[Trial]) -> list[Result]:
    """`function` of every trial, in their order. In a worker process one at a time: its neighbours have the cores."""
    threads = 1 if multiprocessing.parent_process() is not None else min(os.cpu_count() or 1, MOST_THREADS)
    if threads == 1:
        return [function(trial) for trial in trials]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, trials))
