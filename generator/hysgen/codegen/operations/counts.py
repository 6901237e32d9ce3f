"""Numbers of operations by kind, and how they add up along the worst path."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self


@dataclass(frozen=True)
class Counts:
    """Operations of one call.

    add: float32 additions and subtractions; multiply: float32 multiplications; compare: float32 comparisons;
    convert: between float32 and integers; integer: everything on integers but addresses, and selections `c ? a : b` of
    values that are there; load, store: 32-bit words of the caller's structs and of constant tables (local variables
    count as registers); branch: jumps of ifs and loops.
    """

    add: int = 0
    multiply: int = 0
    compare: int = 0
    convert: int = 0
    integer: int = 0
    load: int = 0
    store: int = 0
    branch: int = 0

    def __add__(self, other: Self) -> Counts:
        mine, theirs = dataclasses.astuple(self), dataclasses.astuple(other)
        return Counts(*(a + b for a, b in zip(mine, theirs, strict=True)))

    def times(self, count: int) -> Counts:
        """The same `count` times."""
        return Counts(*(count * number for number in dataclasses.astuple(self)))

    @property
    def total(self) -> int:
        """All kinds together."""
        return sum(dataclasses.astuple(self))

    def to_json(self) -> dict[str, int]:
        """Plain JSON values, by kind, and their total."""
        return {**dataclasses.asdict(self), "total": self.total}

    def describe(self) -> str:
        """One line for people, kinds that do not occur left out."""
        words = {
            "add": "float +-",
            "multiply": "float *",
            "compare": "float comparisons",
            "convert": "conversions",
            "integer": "integer",
            "load": "loads",
            "store": "stores",
            "branch": "branches",
        }
        named = ((getattr(self, field), word) for field, word in words.items())
        return ", ".join(f"{number} {word}" for number, word in named if number)


def worse(one: Counts, other: Counts) -> Counts:
    """The one with more operations."""
    return one if one.total >= other.total else other
