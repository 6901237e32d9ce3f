"""Compiled float64 kernels: the recurrences that would take minutes in Python.

Each kernel is one C file beside this one, hand-written in float64. They share nothing with the generated float32 C:
the truth is a statement of its own. Compiled once per machine by `hysgen.native` and kept in its cache.
"""

from __future__ import annotations

from hysgen.kernels.play import play_operators

__all__ = ["play_operators"]
