"""One thread for the BLAS while hysgen computes.

The matrices here are small. Threads of the BLAS cost up to ten times the work where the trials of a diagnosis, or other
processes, want the same cores, and how many there are changes last bits. The package asks for one thread when it is
imported, which comes too late where NumPy was imported before; this holds whoever imported what first.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Inside, the BLAS uses one thread, in this thread and those that it starts; then as many as before.

    A context, and called, a decorator.
    """
    with ThreadpoolController().limit(limits=1, user_api="blas"):
        yield
