"""Calls from a lower room to an upper one: `hysgen/__init__`, which stands above all, says what answers them.

Each name is a function that imports the upper room and returns the function that does the work.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

draw: Callable[[], Callable[..., Any]]
"""Of `Displayed.plot`: (result, *what) -> a drawing."""

inverse: Callable[[], Callable[..., Any]]
"""Of `Model.inverse`: (model, reference_um, y_um) -> voltages."""
