"""Knowledge about predicate registers from earlier branches: zero, not zero, or unknown.

A compiler tests the same register repeatedly (`[a2] b there`, later `[!a2] b elsewhere`). Two branches on one register
that exclude or imply each other make two paths, not four. The knowledge holds until the next write to the register; a
register with a pending write is unknown.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hysgen_c674x.assembly import Predicate


class KnownPredicates(NamedTuple):
    """zero: (register, whether it is 0). awaited: (cycles until a pending write, register)."""

    zero: tuple[tuple[int, bool], ...] = ()
    awaited: tuple[tuple[int, int], ...] = ()

    def holds(self, predicate: Predicate | None) -> bool | None:
        """Whether an instruction with the predicate is executed; None if unknown."""
        zero = dict(self.zero).get(predicate.register.index) if predicate else None
        return None if predicate is None or zero is None else zero == predicate.when_zero

    def with_answer(self, predicate: Predicate | None, executed: bool) -> KnownPredicates:
        """The knowledge after the predicate was found true (`executed`) or false."""
        if predicate is None or any(register == predicate.register.index for _, register in self.awaited):
            return self
        known = dict(self.zero) | {predicate.register.index: executed == predicate.when_zero}
        return KnownPredicates(tuple(sorted(known.items())), self.awaited)

    def without(self, registers: frozenset[int]) -> KnownPredicates:
        """The knowledge about the other registers."""
        return self._replace(zero=tuple(pair for pair in self.zero if pair[0] not in registers))

    def after(self, written: Sequence[tuple[int, int]], cycles: int) -> KnownPredicates:
        """The knowledge `cycles` cycles after a packet was issued whose results are `written`: (register, delay)."""
        if not written and not self.awaited:
            return self
        gone = {register for register, _ in written}
        awaited = [*self.awaited, *((delay + 1, register) for register, delay in written if delay)]
        return KnownPredicates(
            tuple((register, zero) for register, zero in self.zero if register not in gone),
            tuple(sorted({(due - cycles, register) for due, register in awaited if due > cycles})),
        )
