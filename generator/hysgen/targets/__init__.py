"""Processors: one file each, found by listing the modules of this package and the entry points `hysgen.targets`.

A target is a module that defines TARGET, a `Target`. In another distribution an entry point names it:

    [project.entry-points."hysgen.targets"]
    c674x = "hysgen_c674x.target:TARGET"
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Mapping
from importlib import metadata

from hysgen.errors import HysgenError
from hysgen.record.columns import nearest
from hysgen.targets.base import Equality, Extent, Kernels, Target, TargetCost

__all__ = ["Equality", "Extent", "Kernels", "Target", "TargetCost", "named", "target", "targets", "with_kernels_in"]

GROUP = "hysgen.targets"
PACKAGES = {"c674x": "hysgen_c674x"}
"""Packages of targets that are known without their entry points."""


@functools.lru_cache(maxsize=1)
def targets() -> Mapping[str, Target]:
    """Every installed target by its name. Raises ValueError if two targets have the same name."""
    modules = sorted(module.name for module in pkgutil.iter_modules(__path__))
    present = [getattr(importlib.import_module(f"{__name__}.{name}"), "TARGET", None) for name in modules]
    for entry in sorted(metadata.entry_points(group=GROUP)):
        try:
            present.append(entry.load())
        except ModuleNotFoundError as fault:
            if str(fault.name) != _package(entry):
                raise
    registry: dict[str, Target] = {}
    for item in present:
        if item is not None and registry.setdefault(item.name, item) is not item:
            raise ValueError(f"target {item.name!r}: two packages have it")
    return dict(sorted(registry.items()))


def named(ability: str) -> list[str]:
    """Names of the targets that have `ability`, a field of `Target`."""
    return [name for name, target in targets().items() if getattr(target, ability)]


def target(name: str, ability: str) -> Target:
    """The target of this name, if it has `ability`. Raises HysgenError with one line that says what to install."""
    if name in named(ability):
        return targets()[name]
    packages = PACKAGES | {entry.name: _package(entry) for entry in metadata.entry_points(group=GROUP)}
    if name in packages and name not in targets():
        raise HysgenError(
            f"{name}: this target is in the package {packages[name]}, which is missing; install hysgen whole"
        )
    known = named(ability)
    raise HysgenError(f"{name}: is no target here{nearest(name, known)}; choose from {', '.join(known) or 'none'}")


def with_kernels_in(name: str, texts: Mapping[str, str]) -> tuple[Target, str]:
    """The target whose kernels the folder of model `name` holds, and their assembler. Raises HysgenError without it."""
    for item in targets().values():
        assembler = item.kernels and item.kernels.assembler(name, texts)
        if assembler:
            return item, assembler
    raise HysgenError(f"{name}: its folder holds kernels of a target that is not installed; install hysgen whole")


def _package(entry: metadata.EntryPoint) -> str:
    return entry.module.partition(".")[0]
