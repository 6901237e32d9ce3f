"""Thread limits: one thread inside the BLAS, several for computations that wait; room for the process to grow.

The matrices are small. BLAS threads make a computation up to ten times slower where other threads or processes use the
same cores, and their number changes the last bits of a result.

OpenBLAS takes a buffer of 32 MB for each thread that computes. Where it gets none (`ulimit -v`, a batch system's
limit), it prints a message of its own and exits, or tries again without end; neither can be caught.
"""

import mmap
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from threadpoolctl import ThreadpoolController

from hysgen.errors import HysgenError

LIBRARIES = 384 * 2**20
"""Bytes of address space that NumPy, SciPy, HDF5 and the kernels take until the first result of a fit.

Measured with glibc 2.36 and two OpenBLAS: a fit ends at 340 MB beside the interpreter, and not at 330.
"""

THREAD = 144 * 2**20
"""Bytes of address space of one more thread that computes: its stack (8 MB), glibc's arena (64 MB), two buffers."""


def has_room(size: int) -> bool:
    """Whether the process may grow by `size` bytes of address space. Nothing is kept, and no page is touched.

    True on Windows, which has no such limit for a process.
    """
    if sys.platform == "win32":
        return True
    no_reserve = getattr(mmap, "MAP_NORESERVE", 0x4000 if sys.platform == "linux" else 0)
    try:
        mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | no_reserve).close()
    except OSError:
        return False
    return True


def require_room(size: int) -> None:
    """Raise HysgenError if the process may not grow by `size` bytes of address space."""
    if not has_room(size):
        raise HysgenError(
            f"not enough memory: the libraries of hysgen take {size / 1e6:.0f} MB of address space;"
            " raise the limit of this shell or job (ulimit -v)"
        )


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
