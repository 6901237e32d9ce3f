"""The registry of causes, found by listing the modules of this package.

A cause is a class derived from `Cause`, in a module of its own or beside others. Every other list of causes in the
package is a loop over `causes()`.
"""

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
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    inside = (kind for kind in Cause.__subclasses__() if kind.__module__.startswith(f"{__name__}."))
    for kind in sorted(inside, key=lambda kind: kind.name):
        if kind.name in registry or kind.rank in {other.rank for other in registry.values()}:
            raise ValueError(f"{kind.__name__}: name {kind.name!r} or rank {kind.rank} belongs to another cause")
        registry[kind.name] = kind()
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
