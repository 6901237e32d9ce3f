"""What the branches behind say of the registers that the predicates ahead read: zero, not zero, or not known.

A compiler asks the same register again (`[a2] b there`, further on `[!a2] b elsewhere`). Two branches that exclude each
other, or that come together, are two ways through the code and not four. What is said of a register holds until
something is written to it; while a result is on its way there, nothing is.
"""

from __future__ import annotations

from dataclasses import dataclass

from hysgen.c674x.assembly import Predicate
from hysgen.c674x.counters import writes
from hysgen.c674x.packets import Packet


@dataclass(frozen=True)
class Said:
    """zero: (register, whether it is 0). awaited: (cycles until a result lands, register)."""

    zero: tuple[tuple[int, bool], ...] = ()
    awaited: tuple[tuple[int, int], ...] = ()

    def holds(self, predicate: Predicate | None) -> bool | None:
        """Whether what carries the predicate is executed; None if that is not known."""
        zero = dict(self.zero).get(predicate.register.index) if predicate else None
        return None if predicate is None or zero is None else zero == predicate.when_zero

    def with_answer(self, predicate: Predicate | None, executed: bool) -> Said:
        """The same, and that the predicate held or did not."""
        if predicate is None or any(register == predicate.register.index for _, register in self.awaited):
            return self
        known = dict(self.zero) | {predicate.register.index: executed == predicate.when_zero}
        return Said(tuple(sorted(known.items())), self.awaited)

    def after(self, packet: Packet, cycles: int) -> Said:
        """What is left of it once the packet was issued and `cycles` cycles have passed."""
        written = [(register, delay) for action in packet.actions for register, _, delay in writes(action, {})]
        gone = {register for register, _ in written}
        awaited = [*self.awaited, *((delay + 1, register) for register, delay in written if delay)]
        return Said(
            tuple((register, zero) for register, zero in self.zero if register not in gone),
            tuple(sorted({(due - cycles, register) for due, register in awaited if due > cycles})),
        )
