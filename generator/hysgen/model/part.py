"""What an additive term and an input block have in common: optimiser, C, model file and examples see them alike."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.model.plain import arguments, to_plain
from hysgen.model.structs import Member, Quantity

Floats = NDArray[np.float64]
Words = NDArray[np.uint32] | NDArray[np.float32]


class ModelPart(abc.ABC):
    """A part of a model: parameters and, in C, a struct of its own. The defaults are those of a part without any."""

    kind: ClassVar[str]
    two_words: ClassVar[bool] = False
    """Whether its states are sums of two words (module `twofloat`)."""

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
