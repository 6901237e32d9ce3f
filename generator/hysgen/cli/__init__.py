"""The command line: `hysgen VERB ...`."""

import os

# Before NumPy is imported: for matrices as small as these, BLAS threads cost up to ten times the work on a busy
# machine, and their number changes the last bits of results. A number set by the user is kept. In a notebook, hysgen
# limits the threads inside its own calls only (`machine.processes`).
for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

from hysgen.cli.main import main  # noqa: E402

__all__ = ["main"]
