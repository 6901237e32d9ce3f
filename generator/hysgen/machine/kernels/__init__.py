"""Compiled float64 kernels: the recurrences that would take minutes in Python.

Each kernel is one C file beside this one, hand-written in float64. They share nothing with the generated float32 C:
the truth is a statement of its own. Compiled once per machine by `hysgen.machine.native` and kept in its cache.
"""

from __future__ import annotations

from hysgen.machine.kernels.play import play_operators
from hysgen.machine.kernels.rls import rls_updates
from hysgen.machine.kernels.run import Rules, free_run, horizon_errors, one_step, rule_rows
from hysgen.machine.kernels.sensitivity import FreeRunSums, free_run_sums
from hysgen.machine.kernels.triangular import triangularise

__all__ = [
    "FreeRunSums",
    "Rules",
    "free_run",
    "free_run_sums",
    "horizon_errors",
    "one_step",
    "play_operators",
    "rls_updates",
    "rule_rows",
    "triangularise",
]
