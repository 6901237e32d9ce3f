"""Room for the process to grow: tried before OpenBLAS needs it, which otherwise ends the process or waits for ever.

OpenBLAS takes a buffer of 32 MB for each thread that computes. Where it gets none (`ulimit -v`, a batch system's
limit), it prints a message of its own and exits, or tries again without end; neither can be caught.
"""

from __future__ import annotations

import mmap
import sys

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
