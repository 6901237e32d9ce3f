"""One module a verb: `arguments(parser)`, `run(arguments, console) -> exit code`, and a docstring that is its help."""

from __future__ import annotations

import importlib
from types import ModuleType

NAMES = (
    "fit",
    "score",
    "describe",
    "diagnose",
    "generate",
    "verify",
    "prove",
    "cost",
    "refit",
    "diff",
    "demo",
    "experiments",
    "bank",
    "endurance",
    "image",
    "firmware",
    "track",
)


def verb(name: str) -> ModuleType:
    """The module of a verb; loaded only when it is asked for, for some bring half of SciPy along."""
    return importlib.import_module(f"{__name__}.{name}")
