"""The registry of causes: one file per cause, found by listing the modules of this package.

A cause is a module `<cause>.py` that defines CAUSE, an instance of a class derived from `Cause`. Every other list of
causes in the package is a loop over `causes()`.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Iterable, Mapping

from hysgen.diagnosis.causes.base import Cause, Estimate, Residual, Signature
from hysgen.diagnosis.probe import Chain

__all__ = [
    "VOCABULARY",
    "Cause",
    "Estimate",
    "Residual",
    "Signature",
    "causes",
    "in_ladder_order",
    "slow_causes",
    "without_causes",
]


@functools.lru_cache(maxsize=1)
def causes() -> Mapping[str, Cause]:
    """Every cause by its name. Raises ValueError if two causes have the same name or rank."""
    registry: dict[str, Cause] = {}
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda entry: entry.name):
        cause: Cause | None = getattr(importlib.import_module(f"{__name__}.{module.name}"), "CAUSE", None)
        if cause is None:
            continue
        if cause.name in registry or cause.rank in {other.rank for other in registry.values()}:
            raise ValueError(f"{module.name}: name {cause.name!r} or rank {cause.rank} belongs to another cause")
        registry[cause.name] = cause
    return registry


def in_ladder_order(names: Iterable[str]) -> list[str]:
    """The names in the order of the ladder, by `Cause.rank`. Raises KeyError for a name outside the vocabulary."""
    return sorted(names, key=lambda name: causes()[name].rank)


def slow_causes() -> tuple[str, ...]:
    """Names of the slow causes (`Cause.slow`), in the order of the ladder."""
    return tuple(in_ladder_order(name for name, cause in causes().items() if cause.slow))


def without_causes(chain: Chain, names: Iterable[str]) -> Chain:
    """The chain without the parts of the named causes."""
    for name in names:
        chain = causes()[name].without(chain)
    return chain


VOCABULARY = tuple(in_ladder_order(causes()))
"""Every name that a diagnosis can give, in the order of the ladder."""
