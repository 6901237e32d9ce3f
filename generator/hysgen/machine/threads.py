"""Thread limits: one thread inside the BLAS, several for computations that wait, as for a compiler.

The matrices are small. BLAS threads make a computation up to ten times slower where other threads or processes use the
same cores, and their number changes the last bits of a result.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from threadpoolctl import ThreadpoolController

from hysgen.machine.memory import THREAD, has_room

Item = TypeVar("Item")
Result = TypeVar("Result")

MOST_THREADS = 4
"""Compilers that run at once; a comparison has about 12 builds."""


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Inside this context the BLAS uses one thread, in every thread of the process; the old limit returns afterwards.

    Also a decorator: `@one_blas_thread()`.
    """
    with ThreadpoolController().limit(limits=1, user_api="blas"):
        yield


def in_threads(function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """[function(item) for item in items], computed by several threads; results in the order of the items.

    For items that wait for other programs: short kernels gain nothing (`processes`). A worker process of a pool
    computes one item at a time, because its sibling processes use the other cores. Where memory is limited, there are
    no more threads than it has room for; their number changes no result.
    """
    threads = 1 if multiprocessing.parent_process() is not None else min(os.cpu_count() or 1, MOST_THREADS)
    while threads > 1 and not has_room(threads * THREAD):
        threads -= 1
    if threads == 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))
