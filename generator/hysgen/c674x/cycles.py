"""Cycles of a function without running it: the shortest and the longest way through its packets.

Stalls are not modelled, so a way through the code fixes its cycles exactly. A function is followed packet by packet
with the branches under way; where a branch depends on data, both ways are followed. Code without such branches has one
way, and its cycles are a fact, not a measurement. A loop of constant length has one way too: its counter is followed
(`counters`). A branch that can be taken again and again, as data will have it, needs a limit from the caller.

A jump through a register is taken for the return. That holds for what `toolchain` compiles, with -fno-jump-tables, from
C without function pointers; a pointer that is called, not jumped to, is noticed and refused.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from hysgen.c674x import counters
from hysgen.c674x.assembly import Register
from hysgen.c674x.decode import Branch, LoadAddress
from hysgen.c674x.elf import Image
from hysgen.c674x.latency import BRANCH_DELAY
from hysgen.c674x.packets import Packet
from hysgen.c674x.predicates import Said
from hysgen.c674x.processor import STACK_POINTER
from hysgen.errors import TargetError

MAX_CALL_DEPTH = 16
MAX_VISITS = 4096  # of one packet under different counters: a longer loop counts as one without a limit

_LINK = Register(32 + 3)
_NEVER = 1 << 30


@dataclass(frozen=True)
class CycleBounds:
    """best <= cycles <= worst for every input. data_dependent: addresses of branches whose way depends on data.

    One way only (no such branch) makes best = worst: the cycles of every call. Ways that no input takes are counted
    too, so with data-dependent branches `worst` may exceed what can happen, never the reverse.
    stack_bytes: how far the stack reaches down on some way, called functions included.
    """

    best: int
    worst: int
    data_dependent: tuple[int, ...]
    stack_bytes: int = 0

    @property
    def constant(self) -> bool:
        """Whether every call takes the same number of cycles."""
        return self.best == self.worst


@dataclass(frozen=True)
class _Place:
    """Where a way stands when a packet is issued.

    landing: (cycles until it lands, target) of branches under way, a target None being the return. returns: addresses
    to return to, innermost last. link: what a call has put into B3, until a branch into a function uses it.
    taken: how often each bounded branch was taken. known: loop counters. said: what branches say of predicates.
    """

    address: int
    landing: tuple[tuple[int, int | None], ...] = ()
    returns: tuple[int, ...] = ()
    link: int | None = None
    taken: tuple[int, ...] = ()
    known: counters.Known = field(default_factory=counters.Known)
    said: Said = field(default_factory=Said)


def bounds(
    image: Image, packets: Mapping[int, Packet], function: str, limits: Mapping[int, int] | None = None
) -> CycleBounds:
    """Bounds of the stall-free cycles of one call of `function`, including what it calls.

    limits: for the address of a branch instruction, how often it is taken at most in one call.
    Raises TargetError for a loop without a limit, a computed jump, recursion, a stack that moves by what is not known,
    or code that the simulator refuses.
    """
    limits = limits or {}
    start = image.symbol(function).address
    registers = counters.followed(packets, start) | {STACK_POINTER}
    walk = _Walk(image, packets, tuple(sorted(limits)), limits, registers)
    known = counters.on_entry(registers)
    best, worst = walk.extremes(_Place(start, taken=(0,) * len(limits), known=known))
    return CycleBounds(best, worst, tuple(sorted(walk.data_dependent)), walk.stack_bytes)


class _Walk:
    """Every place that can be reached, each visited once."""

    def __init__(
        self,
        image: Image,
        packets: Mapping[int, Packet],
        bounded: tuple[int, ...],
        limits: Mapping[int, int],
        registers: frozenset[int],
    ) -> None:
        self.registers = registers
        self.visits: Counter[int] = Counter()
        self.stack_bytes = 0
        self.packets = packets
        self.bounded = bounded
        self.limits = limits
        self.owners = sorted((symbol.address, symbol.name) for symbol in image.symbols.values() if symbol.function)
        self.entries = {address for address, _ in self.owners}
        self.data_dependent: set[int] = set()

    def extremes(self, start: _Place) -> tuple[int, int]:
        """Fewest and most cycles from `start` to the return: depth first, without recursion."""
        known: dict[_Place | None, tuple[int, int]] = {None: (0, 0)}
        onward: dict[_Place, list[tuple[int, _Place | None]]] = {}
        stack: list[_Place] = [start]
        while stack:
            place = stack[-1]
            if place not in onward:
                self.visits[place.address] += 1
                if self.visits[place.address] > MAX_VISITS:
                    raise TargetError(self._endless(place, place))
                self.stack_bytes = max(self.stack_bytes, place.known.below(STACK_POINTER))
                onward[place] = list(self._steps(place))
                for _, following in onward[place]:
                    if following in onward and following not in known:
                        raise TargetError(self._endless(place, following))
                    if following is not None and following not in known:
                        stack.append(following)
                continue
            stack.pop()
            if place not in known:
                ways = [(cycles, known[following]) for cycles, following in onward[place]]
                known[place] = (min(c + w[0] for c, w in ways), max(c + w[1] for c, w in ways))
        return known[start]

    def _steps(self, place: _Place) -> Iterator[tuple[int, _Place | None]]:
        """What may follow the packet at `place`, and the cycles until then; None: the function has returned."""
        packet = self.packets.get(place.address)
        if packet is None or packet.refusal:
            raise TargetError((packet and packet.refusal) or f"{place.address:08x}: no execute packet starts here")
        for after in self._issued(packet, place):
            due, target = min(after.landing, default=(_NEVER, None), key=lambda branch: branch[0])
            cycles = min(due, 1 + packet.idle)
            landing = tuple((left - cycles, there) for left, there in after.landing if left > cycles)
            known = counters.after(place.known, packet, cycles, self.registers)
            after = replace(after, known=known, said=after.said.after(packet, cycles))
            if due > cycles:
                yield cycles, replace(after, address=packet.next, landing=landing)
            elif target is not None:
                yield cycles, self._entered(replace(after, address=target, landing=landing))
            elif after.link is not None:
                raise TargetError(f"{place.address:08x}: a call through a pointer; what it calls is not known here")
            elif after.returns:
                address, outer = after.returns[-1], after.returns[:-1]
                yield cycles, replace(after, address=address, landing=landing, returns=outer)
            else:
                yield cycles, None

    def _issued(self, packet: Packet, place: _Place) -> Iterator[_Place]:
        """`place` after the packet's own effects: one for each combination of branches taken and not taken."""
        link = place.link
        ways = [place]
        for instruction, action in zip(packet.instructions, packet.actions, strict=True):
            if isinstance(action, LoadAddress) and action.destination == _LINK:
                link = action.address
            if not isinstance(action, Branch):
                continue
            if action.link is not None:
                link = packet.next
            onward: list[_Place] = []
            for way in ways:
                counted = place.known.holds(instruction)
                executed = way.said.holds(instruction.predicate) if counted is None else counted
                if executed is None:
                    self.data_dependent.add(instruction.address)
                may = executed is not False and self._may_be_taken(instruction.address, way)
                if not (executed and may):
                    onward.append(replace(way, said=way.said.with_answer(instruction.predicate, executed=False)))
                if may:
                    said = way.said.with_answer(instruction.predicate, executed=True)
                    onward.append(self._branched(instruction.address, action, replace(way, said=said)))
            ways = onward
        for way in ways:
            yield replace(way, link=link)

    def _may_be_taken(self, branch: int, way: _Place) -> bool:
        return branch not in self.limits or way.taken[self.bounded.index(branch)] < self.limits[branch]

    def _branched(self, branch: int, action: Branch, way: _Place) -> _Place:
        target = action.target
        if isinstance(target, Register) and target != _LINK and self._in_library(branch):
            raise TargetError(
                f"{branch:08x}: the compiler's library jumps to the address in {target}, by a table or so"
            )
        there = None if isinstance(target, Register) else target
        taken = tuple(n + (at == branch) for at, n in zip(self.bounded, way.taken, strict=True))
        return replace(way, landing=(*way.landing, (BRANCH_DELAY + 1, there)), taken=taken)

    def _in_library(self, address: int) -> bool:
        """Whether the code is the compiler's own library, which is not compiled with FLAGS and may use jump tables."""
        return self.owners[bisect_right(self.owners, (address, "~")) - 1][1].startswith("__")

    def _entered(self, place: _Place) -> _Place:
        """A branch that lands on a function with B3 set for it is a call: remember where it returns to."""
        if place.link is None or place.address not in self.entries:
            return place
        if len(place.returns) >= MAX_CALL_DEPTH:
            raise TargetError(f"{place.address:08x}: calls nest deeper than {MAX_CALL_DEPTH}; recursion is not bounded")
        return replace(place, returns=(*place.returns, place.link), link=None)

    def _endless(self, place: _Place, head: _Place) -> str:
        inside = sorted(at for at in self.data_dependent if head.address <= at <= place.address + 4 * 8)
        named = ", ".join(f"{at:08x}" for at in inside) or "none that depends on data"
        return f"{head.address:08x}: a loop without a limit; give one for a branch of it ({named})"
