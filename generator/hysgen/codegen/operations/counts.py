"""Operation counts by kind, with sum, multiple and comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self


@dataclass(frozen=True)
class Counts:
    """Operations of one call.

    add: float32 additions and subtractions; multiply: float32 multiplications; compare: float32 comparisons;
    convert: conversions between float32 and integer; integer: integer operations except those of addresses, and
    conditional moves `c ? a : b`; load, store: 32-bit words of the caller's structs and of constant tables (local
    variables count as registers); branch: branches of if statements and loops.
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
        return Counts(
            self.add + other.add,
            self.multiply + other.multiply,
            self.compare + other.compare,
            self.convert + other.convert,
            self.integer + other.integer,
            self.load + other.load,
            self.store + other.store,
            self.branch + other.branch,
        )

    def times(self, count: int) -> Counts:
        """The counts multiplied by `count`."""
        return Counts(*(count * number for number in vars(self).values()))

    @property
    def total(self) -> int:
        """Sum over all kinds."""
        return sum(vars(self).values())

    def to_json(self) -> dict[str, int]:
        """The counts by kind and their total, as JSON values."""
        return {**vars(self), "total": self.total}

    def describe(self) -> str:
        """The counts that are not zero, in one line of text."""
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
    """The argument with the larger total."""
    return one if one.total >= other.total else other
