"""Evidence, one file per cause, found by looking into this package: a module `<cause>.py` that defines CAUSE."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Mapping

from hysgen.diagnosis.causes.base import Cause, Estimate, Residual, Signature

__all__ = ["Cause", "Estimate", "Residual", "Signature", "causes"]


@functools.lru_cache(maxsize=1)
def causes() -> Mapping[str, Cause]:
    """Every cause that the probe's chain can hold, by name."""
    found: dict[str, Cause] = {}
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda entry: entry.name):
        cause: Cause | None = getattr(importlib.import_module(f"{__name__}.{module.name}"), "CAUSE", None)
        if cause is not None:
            found[cause.name] = cause
    return found
