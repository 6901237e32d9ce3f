"""Processors: one file each, found by listing the modules of this package and the entry points `hysgen.targets`.

A target is a module that defines TARGET, a `Target`: what the verbs ask of a processor, which is cycles of an
operation, a compiler, a simulator, kernels, an image. In another distribution an entry point names it:

    [project.entry-points."hysgen.targets"]
    c674x = "hysgen_c674x.target:TARGET"
"""

import functools
import importlib
import pkgutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any, Protocol

from hysgen.codegen.operations import Weights
from hysgen.errors import HysgenError, nearest
from hysgen.model.model import Model

Figures = Mapping[str, Mapping[str, int]]
"""Function, "all" or "data" -> name of the figure -> its value."""

Texts = Mapping[str, str]
"""Files of a generated folder by name."""

Progress = Callable[[float, str], None]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Extent:
    """What `verify --target` compares: samples of each function and updates of the learner, None for the target's own
    numbers; seed of the inputs; machines to run on, () for all."""

    samples: int | None
    seed: int
    updates: int | None
    machines: Sequence[str]


class Equality(Protocol):
    """The answer of `verify`, and of the proof of kernels."""

    @property
    def equal(self) -> bool: ...

    def lines(self) -> Sequence[str]: ...

    def to_json(self) -> dict[str, Any]: ...


@dataclass(frozen=True)
class TargetCost:
    """Cost of a generated folder as the target's compiler makes it.

    figures: by function, and of all code and data. notes: text below the tables. further: keys of the JSON beside
    `target`, which has the figures.
    """

    figures: Figures
    notes: Sequence[str] = ()
    further: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Kernels:
    """Functions of a generated folder scheduled for the target.

    assemblers: syntaxes of the file of the kernels, the usual one first. schedule: (name of the model, texts,
    assembler) -> the texts with the kernels, and the functions that stay in C with the reason. assembler: (name, texts)
    -> the assembler of a folder, None if it holds no kernels of this target. prove: (model, texts, functions) -> of
    these kernels, all if (), whether they are equal to their C for every input.
    """

    assemblers: tuple[str, ...]
    schedule: Callable[[str, Texts, str], tuple[dict[str, str], Mapping[str, str]]]
    assembler: Callable[[str, Texts], str | None]
    prove: Callable[[Model, Texts, Sequence[str]], Equality]


@dataclass(frozen=True)
class Target:
    """A processor; None and () where it does not have the thing.

    about: what `verify --target NAME` does. weights: cycles of an operation, for estimates. cost: measured cost of a
    folder. verify: bits of a folder against those of the host; verify_options: fields of `Extent` that it heeds beside
    samples and seed. firmware: (model, texts, samples, say, warn) -> sizes and cycles of the firmware's image as JSON;
    raises BuildError without a compiler.
    """

    name: str
    about: str = ""
    weights: Weights | None = None
    cost: Callable[[Model, Texts], TargetCost] | None = None
    verify: Callable[[Model, Texts, Extent, Progress], Equality] | None = None
    verify_options: tuple[str, ...] = ()
    kernels: Kernels | None = None
    firmware: Callable[[Model, Texts, int, Say, Say], dict[str, Any]] | None = None


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
