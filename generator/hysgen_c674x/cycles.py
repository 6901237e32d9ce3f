"""Static bounds of a function's cycles: the shortest and the longest path through its packets.

Stalls are not modelled, so a path fixes its cycles exactly. The analysis follows a function packet by packet with the
branches in flight; at a branch that depends on data it follows both paths. Code without such branches has one path, and
its cycle count holds for every input. A loop of constant length also has one path: its counter is evaluated
(`counters`). A loop whose length depends on data needs a limit from the caller.

A jump through a register is taken as the return. This holds for C without function pointers compiled by `toolchain`,
with -fno-jump-tables; a call through a pointer is detected and refused.

Of the generated C of a model also the resources: cycles, code and stack of each function, bytes of data.
"""

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from hysgen.codegen.manifest import c_files
from hysgen.codegen.operations import figures
from hysgen.errors import TargetError
from hysgen_c674x import counters, toolchain
from hysgen_c674x.assembly import Register
from hysgen_c674x.counters import KnownPredicates
from hysgen_c674x.decode import BRANCH_DELAY, Jump, LoadAddress, Return
from hysgen_c674x.elf import ProgramImage
from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import STACK_POINTER

MAX_CALL_DEPTH = 16
MAX_VISITS = 4096  # of one packet with different counters; a longer loop is treated as a loop without a limit

_LINK = Register(32 + 3)
_NEVER = 1 << 30

# C6000 EABI (SPRAB89), chapter 3: no argument is in these when a function is entered; when it has returned, only its
# result and the registers that it preserves hold a value. What is known of the rest would only multiply the states.
_DEAD_BEFORE = frozenset(side + n for side in (0, 32) for n in (*range(3), *range(16, 32)))
_DEAD_AFTER = frozenset(side + n for side in (0, 32) for n in (*range(4), *range(6, 10), *range(16, 32)))
# The same chapter: a function returns with these as they were when it was entered, for it saves those that it changes.
_PRESERVED = tuple(side + n for side in (0, 32) for n in range(10, 16))


@dataclass(frozen=True)
class CycleBounds:
    """best <= cycles <= worst for every input. data_dependent: addresses of branches that depend on data.

    Without such branches best = worst, the cycles of every call. With them, paths that no input takes are included, so
    `worst` may exceed the largest cycle count that occurs. stack_bytes: most stack on any path, callees included.
    """

    best: int
    worst: int
    data_dependent: tuple[int, ...]
    stack_bytes: int = 0

    @property
    def constant(self) -> bool:
        """Whether every call takes the same number of cycles."""
        return self.best == self.worst


class _Place(NamedTuple):
    """State of a path when a packet is issued.

    landing: (cycles until it takes effect, target) of branches in flight; target None is the return. returns: return
    addresses and values of the registers that the callee preserves, innermost last. link: address in B3 set by a call,
    until a branch into a function uses it. taken: how often each bounded branch was taken. known: values of loop
    counters. answers: knowledge about predicate registers.
    """

    address: int
    landing: tuple[tuple[int, int | None], ...] = ()
    returns: tuple[tuple[int, tuple[counters.CounterValue | None, ...]], ...] = ()
    link: int | None = None
    taken: tuple[int, ...] = ()
    known: counters.KnownRegisters = counters.KnownRegisters()
    answers: KnownPredicates = KnownPredicates()


def bounds(
    image: ProgramImage, packets: Mapping[int, Packet], function: str, limits: Mapping[int, int] | None = None
) -> CycleBounds:
    """Bounds of the stall-free cycles of one call of `function`, including what it calls.

    limits: by address of a branch instruction, how often one call takes it at most.
    Raises TargetError for a loop without a limit, a computed jump, recursion, a stack pointer changed by an unknown
    amount, or code that the simulator refuses.
    """
    limits = limits or {}
    start = image.symbol(function).address
    registers = counters.decisive_registers(packets, start) | {STACK_POINTER}
    walk = _Walk(image, packets, tuple(sorted(limits)), limits, registers)
    known = counters.entry_values(registers)
    best, worst = walk.extremes(_Place(start, taken=(0,) * len(limits), known=known))
    return CycleBounds(best, worst, tuple(sorted(walk.data_dependent)), walk.stack_bytes)


def _without(registers: frozenset[int], place: _Place) -> _Place:
    """`place` without knowledge about `registers`."""
    return place._replace(known=place.known.without(registers), answers=place.answers.without(registers))


class _Walk:
    """Depth-first visit of every reachable state, each once."""

    def __init__(
        self,
        image: ProgramImage,
        packets: Mapping[int, Packet],
        bounded: tuple[int, ...],
        limits: Mapping[int, int],
        registers: frozenset[int],
    ) -> None:
        self.registers = registers
        self.visits: Counter[int] = Counter()
        self.written: dict[int, tuple[tuple[int, int], ...]] = {}
        self.stack_bytes = 0
        self.packets = packets
        self.bounded = bounded
        self.limits = limits
        self.owners = sorted((symbol.address, symbol.name) for symbol in image.symbols.values() if symbol.function)
        self.entries = {address for address, _ in self.owners}
        self.data_dependent: set[int] = set()

    def extremes(self, start: _Place) -> tuple[int, int]:
        """Fewest and most cycles from `start` to the return; iterative, for functions of any length."""
        known: dict[_Place | None, tuple[int, int]] = {None: (0, 0)}
        onward: dict[_Place, list[tuple[int, _Place | None]]] = {}
        stack: list[_Place] = [start]
        while stack:
            place = stack[-1]
            paths = onward.get(place)
            if paths is None:
                self.visits[place.address] += 1
                if self.visits[place.address] > MAX_VISITS:
                    raise TargetError(self._endless(place, place))
                self.stack_bytes = max(self.stack_bytes, place.known.below(STACK_POINTER))
                paths = onward[place] = list(self._steps(place))
                for _, successor in paths:
                    if successor is not None and successor not in known:
                        if successor in onward:
                            raise TargetError(self._endless(place, successor))
                        stack.append(successor)
                continue
            stack.pop()
            if place not in known:
                ends = [(cycles, known[successor]) for cycles, successor in paths]
                known[place] = (min(c + rest[0] for c, rest in ends), max(c + rest[1] for c, rest in ends))
        return known[start]

    def _steps(self, place: _Place) -> Iterator[tuple[int, _Place | None]]:
        """(cycles, next state) for each path onward from the packet at `place`; the state is None after the return."""
        packet = self.packets.get(place.address)
        if packet is None or packet.refusal:
            raise TargetError((packet and packet.refusal) or f"{place.address:08x}: no execute packet starts here")
        for after in self._issued(packet, place):
            due, target = min(after.landing, default=(_NEVER, None), key=lambda branch: branch[0])
            cycles = min(due, 1 + packet.idle)
            landing = tuple((left - cycles, there) for left, there in after.landing if left > cycles)
            known = counters.after(place.known, after.answers, packet, cycles, self.registers)
            after = after._replace(known=known, answers=after.answers.after(self._written(packet), cycles))
            if due > cycles:
                yield cycles, after._replace(address=packet.next, landing=landing)
            elif target is not None:
                yield cycles, self._entered(after._replace(address=target, landing=landing))
            elif after.link is not None:
                raise TargetError(f"{place.address:08x}: a call through a pointer; its target is unknown")
            elif after.returns:
                yield cycles, self._returned(after._replace(landing=landing))
            else:
                yield cycles, None

    def _written(self, packet: Packet) -> tuple[tuple[int, int], ...]:
        if packet.address not in self.written:
            self.written[packet.address] = counters.written(packet)
        return self.written[packet.address]

    def _issued(self, packet: Packet, place: _Place) -> Iterator[_Place]:
        """`place` after the packet's own effects, one state for each combination of branches taken and not taken."""
        link = place.link
        paths = [place]
        for instruction, action in zip(packet.instructions, packet.actions, strict=True):
            if isinstance(action, LoadAddress) and action.destination == _LINK:
                link = action.address
            if isinstance(action, Return):
                raise TargetError(f"{instruction}: a return from an interrupt, whose target only a run tells")
            if not isinstance(action, Jump):
                continue
            if action.link is not None:
                link = packet.next
            onward: list[_Place] = []
            for path in paths:
                executed = counters.is_executed(instruction, place.known, path.answers)
                if executed is None:
                    self.data_dependent.add(instruction.address)
                may = executed is not False and self._may_be_taken(instruction.address, path)
                if not (executed and may):
                    onward.append(
                        path._replace(answers=path.answers.with_answer(instruction.predicate, executed=False))
                    )
                if may:
                    answers = path.answers.with_answer(instruction.predicate, executed=True)
                    onward.append(self._branched(instruction.address, action, path._replace(answers=answers)))
            paths = onward
        for path in paths:
            yield path._replace(link=link)

    def _may_be_taken(self, branch: int, path: _Place) -> bool:
        return branch not in self.limits or path.taken[self.bounded.index(branch)] < self.limits[branch]

    def _branched(self, branch: int, action: Jump, path: _Place) -> _Place:
        target = action.target
        if isinstance(target, Register) and target != _LINK and self._in_library(branch):
            raise TargetError(
                f"{branch:08x}: the compiler's library jumps to the address in {target}; jump tables are not followed"
            )
        there = None if isinstance(target, Register) else target
        taken = tuple(n + (at == branch) for at, n in zip(self.bounded, path.taken, strict=True))
        return path._replace(landing=(*path.landing, (BRANCH_DELAY + 1, there)), taken=taken)

    def _in_library(self, address: int) -> bool:
        """Whether the code is from the compiler's library, which may use jump tables: FLAGS do not apply to it."""
        return self.owners[bisect_right(self.owners, (address, "~")) - 1][1].startswith("__")

    def _entered(self, place: _Place) -> _Place:
        """A branch to a function with B3 set is a call: push its return address."""
        if place.link is None or place.address not in self.entries:
            return place
        if len(place.returns) >= MAX_CALL_DEPTH:
            raise TargetError(f"{place.address:08x}: calls nest deeper than {MAX_CALL_DEPTH}; recursion is not bounded")
        frame = place.link, tuple(place.known.values[register] for register in _PRESERVED)
        return _without(_DEAD_BEFORE, place._replace(returns=(*place.returns, frame), link=None))

    def _returned(self, place: _Place) -> _Place:
        """`place` behind the innermost call, with the registers that the callee preserves as they were before it."""
        address, before = place.returns[-1]
        known = place.known.restored(dict(zip(_PRESERVED, before, strict=True)))
        return _without(_DEAD_AFTER, place._replace(address=address, returns=place.returns[:-1], known=known))

    def _endless(self, place: _Place, head: _Place) -> str:
        inside = sorted(at for at in self.data_dependent if head.address <= at <= place.address + 4 * 8)
        named = ", ".join(f"{at:08x}" for at in inside) or "none that depends on data"
        return f"{head.address:08x}: a loop without a limit; give one for a branch of it ({named})"


def c_texts(texts: Mapping[str, str]) -> list[tuple[str, str]]:
    """(file name, text) of what is compiled for the target among generated files: C, headers, and scheduled kernels."""
    return [*c_files(texts).items(), *((name, text) for name, text in texts.items() if name.endswith("_c674x.s"))]


def cycle_bounds(
    name: str, texts: Mapping[str, str], firmware: toolchain.Firmware | None = None
) -> dict[str, CycleBounds]:
    """Stall-free cycles of each public function, by its name without the model's.

    firmware: the compiled texts, if they are compiled already.
    Raises BuildError without the toolchain, TargetError if the cycles of a function cannot be bounded.
    """
    program = firmware or toolchain.compile(c_texts(texts))
    code = program.packets
    functions = figures(name, texts).operations
    return {function: bounds(program.image, code, f"{name}_{function}") for function in functions}


def footprint(name: str, texts: Mapping[str, str]) -> dict[str, dict[str, int]]:
    """Function without the model's name -> worst-case cycles, bytes of its own code, most stack including callees.

    "all" holds the bytes of the program's code, "data" the bytes of the public structs and of the constant tables. The
    self-test is left out.
    Raises BuildError without the toolchain, TargetError if cycles or stack cannot be bounded.
    """
    firmware = toolchain.compile([(file, text) for file, text in c_texts(texts) if "selftest" not in file])
    counted = figures(name, texts)
    taken: dict[str, dict[str, int]] = {}
    for function, bound in cycle_bounds(name, texts, firmware).items():
        taken[function] = {
            "cycles": bound.worst,
            "code_bytes": firmware.function_bytes(f"{name}_{function}"),
            "stack_bytes": bound.stack_bytes,
        }
    taken["all"] = {"code_bytes": firmware.section_bytes[".text"]}
    taken["data"] = {"struct_bytes": sum(counted.struct_bytes.values()), "constant_bytes": counted.constant_bytes}
    return taken
