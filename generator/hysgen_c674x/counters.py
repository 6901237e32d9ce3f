"""Static evaluation of loop counters: registers whose values do not depend on data.

A loop of constant length counts in a register, or moves a pointer to a fixed distance from its start. A value is
therefore a number, or a number plus the value of a register on entry. Only registers that decide a backward branch, and
the registers these are computed from, are evaluated. The result of any other operation is unknown.

Knowledge about predicate registers from earlier branches: zero, not zero, or unknown.

A compiler tests the same register repeatedly (`[a2] b there`, later `[!a2] b elsewhere`). Two branches on one register
that exclude or imply each other make two paths, not four. The knowledge holds until the next write to the register; a
register with a pending write is unknown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hysgen.checking.symbolic.semantics import INTEGER, MASK, signed
from hysgen.errors import TargetError
from hysgen_c674x.assembly import Instruction, MemoryOperand, Predicate, Register
from hysgen_c674x.decode import Access, Action, Compute, Jump, Load, LoadAddress, ReadControl, Source
from hysgen_c674x.packets import Packet


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


REGISTERS = 64


class CounterValue(NamedTuple):
    """`number` plus the value of register `base` on entry; `number` alone if base is None."""

    number: int
    base: int | None = None


_STEP = {"add": 1, "addab": 1, "addah": 2, "addaw": 4, "addad": 8, "addk": 1}
_STEP_BACK = {"sub": 1, "subab": 1, "subah": 2, "subaw": 4}


class KnownRegisters(NamedTuple):
    """values: by register, None if unknown. awaited: (cycles until a pending write, register); unknown until then."""

    values: tuple[CounterValue | None, ...] = (None,) * REGISTERS
    awaited: tuple[tuple[int, int], ...] = ()

    def holds(self, instruction: Instruction) -> bool | None:
        """Whether the instruction is executed; None if unknown."""
        if instruction.predicate is None:
            return True
        value = self.values[instruction.predicate.register.index]
        if value is None or value.base is not None:
            return None
        return (value.number == 0) == instruction.predicate.when_zero

    def below(self, register: int) -> int:
        """Entry value of the register minus its value now, at least 0. Raises TargetError if that is unknown."""
        value = self.values[register]
        if value is None or value.base != register:
            raise TargetError(
                f"{Register(register)}: changed by an unknown amount; the depth of the stack is not bounded"
            )
        return max(0, -signed(value.number))

    def restored(self, before: Mapping[int, CounterValue | None]) -> KnownRegisters:
        """The values after the return of a function that preserves the registers of `before`, values at the call.

        Raises TargetError if the function left another value in one of them.
        """
        values = list(self.values)
        pending = {register for _, register in self.awaited}
        for register, value in before.items():
            if value is None or register in pending:
                continue
            if values[register] not in (None, value):
                raise TargetError(f"{Register(register)}: a function returns with another value than the caller's")
            values[register] = value
        return self._replace(values=tuple(values))

    def without(self, registers: frozenset[int]) -> KnownRegisters:
        """The known values of the other registers."""
        values = (None if register in registers else value for register, value in enumerate(self.values))
        return self._replace(values=tuple(values))


def decisive_registers(packets: Mapping[int, Packet], start: int) -> frozenset[int]:
    """Registers that decide a backward branch reachable from `start`, and the registers they are computed from."""
    reached = _reached(packets, start)
    every = [pair for packet in reached for pair in zip(packet.instructions, packet.actions, strict=True)]
    decisive = {
        instruction.predicate.register.index
        for instruction, action in every
        if isinstance(action, Jump)
        and instruction.predicate
        and isinstance(action.target, int)
        and action.target <= instruction.address
    }
    size = -1
    while decisive and size != len(decisive):
        size = len(decisive)
        for _, action in every:
            if isinstance(action, Compute) and action.mnemonic in INTEGER and action.destination.index in decisive:
                decisive |= {source.index for source in action.sources if isinstance(source, Register)}
    return frozenset(decisive)


def is_executed(instruction: Instruction, known: KnownRegisters, answers: KnownPredicates) -> bool | None:
    """Whether the instruction is executed, by the values of counters or by earlier branches; None if unknown."""
    counted = known.holds(instruction)
    return answers.holds(instruction.predicate) if counted is None else counted


def entry_values(registers: frozenset[int]) -> KnownRegisters:
    """Every register has its own value on entry."""
    every = range(REGISTERS)
    return KnownRegisters(tuple(CounterValue(0, register) if register in registers else None for register in every))


def after(
    known: KnownRegisters, answers: KnownPredicates, packet: Packet, cycles: int, registers: frozenset[int]
) -> KnownRegisters:
    """The known values after the packet was issued and `cycles` cycles have passed; answers: as it was issued."""
    if not registers:
        return known
    before = known.values
    values, awaited = list(before), list(known.awaited)
    for instruction, action in zip(packet.instructions, packet.actions, strict=True):
        executed = is_executed(instruction, known, answers)
        if executed is False:
            continue
        for register, value, delay in writes(action, before):
            if register not in registers:
                continue
            if delay:
                awaited.append((delay + 1, register))
                value = None
            unknown = executed is None or any(other == register for _, other in awaited)
            values[register] = None if unknown else value
    left = tuple(sorted({(due - cycles, register) for due, register in awaited if due > cycles}))
    return KnownRegisters(tuple(values), left)


def written(packet: Packet) -> tuple[tuple[int, int], ...]:
    """(register, delay slots) of each result of the packet."""
    unknown = KnownRegisters().values
    return tuple((register, delay) for action in packet.actions for register, _, delay in writes(action, unknown))


def writes(action: Action, before: Sequence[CounterValue | None]) -> list[tuple[int, CounterValue | None, int]]:
    """(register, value or None, delay slots) of each result, given the values `before`."""
    results: list[tuple[int, CounterValue | None, int]] = []
    if isinstance(action, Compute):
        results.append((action.destination.index, _computed(action, before), action.delay))
    elif isinstance(action, LoadAddress):
        results.append((action.destination.index, CounterValue(action.address), 0))
    elif isinstance(action, Jump) and action.link is not None:
        results.append((action.link.index, None, 0))
    elif isinstance(action, ReadControl):
        results.append((action.destination.index, None, 0))
    elif isinstance(action, Access):
        if action.memory.step:
            results.append((action.memory.base.index, _moved(action.memory, action.size, before), 0))
        if isinstance(action, Load):
            results += [(register.index, None, action.delay) for register in action.registers]
    return results


def _moved(memory: MemoryOperand, size: int, before: Sequence[CounterValue | None]) -> CounterValue | None:
    base, offset = before[memory.base.index], _value(memory.offset, before)
    if base is None or offset is None or offset.base is not None:
        return None
    step = offset.number * (size if memory.scaled else 1)
    return CounterValue(base.number + memory.sign * step & MASK, base.base)


def _computed(action: Compute, before: Sequence[CounterValue | None]) -> CounterValue | None:
    operands = [_value(source, before) for source in action.sources]
    known = [operand for operand in operands if operand is not None]
    if action.mnemonic not in INTEGER or len(known) != len(operands):
        return None
    if all(operand.base is None for operand in known):
        return CounterValue(INTEGER[action.mnemonic](*[operand.number for operand in known]))
    return _relative(action.mnemonic, *known) if len(known) == 2 else None


def _relative(mnemonic: str, a: CounterValue, b: CounterValue) -> CounterValue | None:
    """The operation on a and b, of which at least one is relative to the entry value of a register."""
    if mnemonic in _STEP and b.base is None:
        return CounterValue(a.number + _STEP[mnemonic] * b.number & MASK, a.base)
    if mnemonic in _STEP and a.base is None and _STEP[mnemonic] == 1:
        return CounterValue(a.number + b.number & MASK, b.base)
    if mnemonic in _STEP_BACK and b.base is None:
        return CounterValue(a.number - _STEP_BACK[mnemonic] * b.number & MASK, a.base)
    if mnemonic == "sub" and a.base == b.base:
        return CounterValue(a.number - b.number & MASK)
    if mnemonic == "cmpeq" and a.base == b.base:
        return CounterValue(int(a.number == b.number))
    if mnemonic in ("or", "xor") and CounterValue(0) in (a, b):
        return b if a == CounterValue(0) else a
    return None


def _value(source: Source, before: Sequence[CounterValue | None]) -> CounterValue | None:
    return before[source.index] if isinstance(source, Register) else CounterValue(source & MASK)


def _reached(packets: Mapping[int, Packet], start: int) -> list[Packet]:
    """Every packet reachable from `start`, through calls and returns as well."""
    reached: dict[int, Packet] = {}
    todo = [start]
    while todo:
        packet = packets.get(todo.pop())
        if packet is None or packet.refusal or packet.address in reached:
            continue
        reached[packet.address] = packet
        todo += [packet.next]
        todo += [a.target for a in packet.actions if isinstance(a, Jump) and isinstance(a.target, int)]
    return list(reached.values())
