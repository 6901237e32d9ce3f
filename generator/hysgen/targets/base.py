"""What the verbs ask of a processor: cycles of an operation, a compiler, a simulator, kernels, an image."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from hysgen.codegen.operations.cycles import Weights
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

    samples: int | None = None
    seed: int = 1
    updates: int | None = None
    machines: Sequence[str] = ()


class Equality(Protocol):
    """The answer of `verify`."""

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
    -> the assembler of a folder, None if it holds no kernels of this target.
    """

    assemblers: tuple[str, ...]
    schedule: Callable[[str, Texts, str], tuple[dict[str, str], Mapping[str, str]]]
    assembler: Callable[[str, Texts], str | None]


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
