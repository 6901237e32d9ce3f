"""What an additive term and an input block have in common: optimiser, C, model file and examples see them alike."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.model.chain_part import Part
from hysgen.model.structs import Member, Quantity

READERS: Mapping[str, Callable[[Any], Any]] = {
    "float": float,
    "float | None": lambda value: None if value is None else float(value),
    "int": int,
    "str": str,
    "tuple[float, ...]": lambda values: tuple(float(value) for value in values),
    "tuple[str, ...]": lambda values: tuple(str(value) for value in values),
}
"""How a field is read, by its annotation; bool is strict."""


def to_plain(one: Any) -> dict[str, Any]:
    """Fields of a dataclass by name, in their order, tuples as lists; exact."""
    values = {item.name: getattr(one, item.name) for item in dataclasses.fields(one)}
    return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


def arguments(kind: type[Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a dataclass out of `to_plain` of it; a field with a default may be missing.

    Raises KeyError if a field is missing, TypeError or ValueError if a value is malformed or the annotation of a field
    is not in READERS.
    """
    found: dict[str, Any] = {}
    for item in dataclasses.fields(kind):
        if item.name not in data and item.default is not dataclasses.MISSING:
            continue
        value = data[item.name]
        if item.type == "bool":
            if not isinstance(value, bool):
                raise TypeError(f"{item.name} must be true or false")
            found[item.name] = value
        elif isinstance(item.type, str) and item.type in READERS:
            found[item.name] = READERS[item.type](value)
        else:
            raise TypeError(
                f"{item.name}: no reader for {item.type}; write to_json() and from_json() of {kind.__name__}"
            )
    return found


Floats = NDArray[np.float64]
Words = NDArray[np.uint32] | NDArray[np.float32]


class ModelPart(Part, abc.ABC):
    """A part of a model: parameters and, in C, a struct of its own. The defaults are those of a part without any."""

    kind: ClassVar[str]
    two_words: ClassVar[bool] = False
    """Whether its states are sums of two words (`float32_arithmetic`)."""

    quantities: ClassVar[Mapping[str, Quantity]] = {}
    """Meaning and unit of every array of `constants`, by its name."""

    def members(self) -> tuple[Member, ...]:
        """The members of the C struct that keeps the state, in its order, with units; () without a state.

        Scalars and arrays of up to two sizes. The mirror has an attribute of the name of each.
        """
        return ()

    def constants(self, Ts_s: float) -> Mapping[str, Words]:
        """The 32-bit numbers that the C needs, by the name of their array in `<name>_params.h` (see `quantities`)."""
        return {}

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, exact; includes "kind"."""
        return {"kind": self.kind, **to_plain(self)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """Inverse of to_json. Raises KeyError, TypeError or ValueError on malformed data."""
        return cls(**arguments(cls, data))

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """One part with random parameters for each form of the C, first the form that a diagnosis delivers.

        `verify` compares models of them bit for bit.
        """
        return (cls(),)
