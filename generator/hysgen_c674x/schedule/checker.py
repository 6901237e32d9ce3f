"""Execution of assembled kernels with symbols for numbers, and every rule of the pipeline that a schedule has to keep.

The packets come from the disassembly of the linked program, so this shares no code with the scheduler. A kernel is
followed from its first packet to the end of the delay slots of its return. It is correct for every timing of
interrupts if no register is read or written while a result for it is in flight: an interrupt only lets such results
arrive earlier. What a register or a word of memory holds is an operation of a graph; that of addresses is decomposed
into the object that they lie in and a number of bytes.
"""

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from hysgen.checking.symbolic.arrays import COMPUTED
from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.memory import WORD
from hysgen.checking.symbolic.semantics import MASK, signed
from hysgen_c674x.assembly import Instruction, Register
from hysgen_c674x.decode import (
    BRANCH_DELAY,
    Access,
    Action,
    Compute,
    Jump,
    Load,
    LoadAddress,
    ReadControl,
    Return,
    Store,
    WriteControl,
)
from hysgen_c674x.elf import ProgramImage
from hysgen_c674x.packets import Packet, operands
from hysgen_c674x.processor import STACK_POINTER

_LINK: Final = 32 + 3
_PRESERVED: Final = frozenset({*range(10, 16), *range(32 + 10, 32 + 16), _LINK})
ARGUMENTS: Final = (4, 32 + 4, 6, 32 + 6, 8, 32 + 8)
_GUARDS: Final = frozenset({0, 1, 2, 32, 33, 34})
_SCALED: Final[Mapping[str, int]] = {"addk": 1, "addab": 1, "addah": 2, "addaw": 4, "addad": 8}
_STACK: Final = "stack"


@dataclass(frozen=True)
class Finding:
    """A broken rule in the packet at an address."""

    address: int
    rule: str
    text: str

    def __str__(self) -> str:
        return f"{self.address:08x}: {self.rule}: {self.text}"


@dataclass(frozen=True)
class _InFlight:
    """A result that arrives at the start of cycle `arrives`; guard: the predicate of its instruction."""

    arrives: int
    chosen: Callable[[Op], Op]
    guard: tuple[int, bool] | None
    load: bool


def function_packets(image: ProgramImage, packets: Mapping[int, Packet], function: str) -> list[Packet]:
    """The packets of a function in the order of their addresses."""
    symbol = image.symbol(function)
    return [packets[at] for at in sorted(packets) if symbol.address <= at < symbol.address + symbol.size]


def inspect(packets: Sequence[Packet], parameters: int) -> list[Finding]:
    """All broken rules of a kernel with this number of arguments."""
    graph = Graph()
    return Execution(graph, {f"argument {k}": [] for k in range(parameters)}).run(packets)


@dataclass
class Execution:
    """Registers and memory during a kernel. given: the arguments, or the words behind them, by parameter."""

    graph: Graph
    given: Mapping[str, Op | Sequence[Op]]
    registers: dict[int, Op] = field(default_factory=dict)
    memory: dict[tuple[str, int], Op] = field(default_factory=dict)
    objects: dict[Op, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    defined: set[int] = field(default_factory=set)
    flying: dict[int, list[_InFlight]] = field(default_factory=dict)
    arrived: dict[int, tuple[int, bool]] = field(default_factory=dict)
    ports: set[tuple[str, int]] = field(default_factory=set)
    returns: int | None = None
    here: int = 0

    def __post_init__(self) -> None:
        self.registers = {index: self.graph.symbol(f"entry {Register(index)}") for index in range(64)}
        self.objects = {self.registers[STACK_POINTER]: _STACK}
        self.defined = set(_PRESERVED)
        for index, (name, given) in zip(ARGUMENTS, self.given.items(), strict=False):
            self.defined.add(index)
            if isinstance(given, Op):
                self.registers[index] = given
            else:
                self.objects[self.registers[index]] = name
                self.memory |= {(name, WORD * k): word for k, word in enumerate(given)}

    def run(self, packets: Sequence[Packet]) -> list[Finding]:
        """Every broken rule."""
        entry, cycle = dict(self.registers), 0
        for packet in packets:
            self.here = packet.address
            if self.returns is not None and cycle >= self.returns:
                self._found("return", "instructions behind the delay slots of the return")
                break
            if packet.refusal:
                self._found("resources", packet.refusal)
                break
            self._packet(packet, cycle)
            cycle += 1 + packet.idle
        if self.returns is None:
            self._found("return", "the function has no return")
            return self.findings
        if cycle < self.returns:
            self._found("return", f"ends {self.returns - cycle} cycles before its return takes effect")
        self._land(self.returns)
        for index, flying in sorted(self.flying.items()):
            if flying:
                self._found("return", f"{Register(index)} is still to be written when the function has returned")
        for register in sorted(_PRESERVED):
            if self.registers[register] is not entry[register]:
                self._found("convention", f"{Register(register)} does not have its value at entry")
        return self.findings

    def _found(self, rule: str, text: str) -> None:
        self.findings.append(Finding(self.here, rule, text))

    def _land(self, cycle: int) -> None:
        for register, flying in self.flying.items():
            for each in [each for each in flying if each.arrives <= cycle]:
                self.registers[register] = each.chosen(self.registers[register])
                self.defined.add(register)
                self.arrived[register] = each.arrives, each.load
                flying.remove(each)

    def _packet(self, packet: Packet, cycle: int) -> None:
        self._land(cycle)
        pairs = list(zip(packet.instructions, packet.actions, strict=True))
        for instruction, action in pairs:
            guard = instruction.predicate
            if guard is not None:
                if guard.register.index not in _GUARDS:
                    self._found("predicate", f"{guard.register} cannot be tested")
                self._check(guard.register, cycle, False)
            for register in operands(action):
                crosses = instruction.unit is not None and register.side != instruction.unit.side
                self._check(register, cycle, crosses and not isinstance(action, Access))
        defined = self.defined | {register for register, flying in self.flying.items() if flying}
        for instruction, action in sorted(pairs, key=lambda pair: isinstance(pair[1], Store)):
            self._act(instruction, action, cycle)
        for index, flying in self.flying.items():
            if index not in defined and len(flying) == 1 and flying[0].guard is not None:
                self._found("undefined", f"{Register(index)} is written under a condition and holds nothing otherwise")

    def _check(self, register: Register, cycle: int, crosses: bool) -> None:
        index = register.index
        if any(each.arrives > cycle for each in self.flying.get(index, [])):
            self._found("in flight", f"{register} is read while a result for it is on its way")
        elif index not in self.defined:
            self._found("undefined", f"{register} is read before it is written")
        elif crosses and self.arrived.get(index) == (cycle, False):
            self._found("stall", f"{register} crosses in the cycle behind its write")

    def _act(self, instruction: Instruction, action: Action, cycle: int) -> None:
        predicate, guard = instruction.predicate, None
        condition = self.graph.const(1)
        if predicate is not None:
            guard, condition = (predicate.register.index, predicate.when_zero), self.registers[predicate.register.index]
            condition = self.graph.op("cmpeq", condition, self.graph.const(0)) if predicate.when_zero else condition

        def chosen(value: Op) -> Callable[[Op], Op]:
            return lambda old: self.graph.select(condition, value, old)

        match action:
            case Compute(destination=destination, delay=delay):
                unit = instruction.unit
                if unit is not None and unit.kind in "LSM":
                    if (unit.name, cycle + delay) in self.ports:
                        self._found("write port", f"two results leave {unit.name} in one cycle")
                    self.ports.add((unit.name, cycle + delay))
                value = self._computed(action.mnemonic, [self._value(each) for each in action.sources])
                self._write(destination, _InFlight(cycle + delay + 1, chosen(value), guard, False))
            case Load(registers=registers, delay=delay):
                for k, register in enumerate(registers):
                    value = self._read(*self._place(action, k))
                    self._write(register, _InFlight(cycle + delay + 1, chosen(value), guard, True))
            case Store(registers=registers):
                for k, register in enumerate(registers):
                    self._store(*self._place(action, k), chosen(self.registers[register.index]))
            case Jump(target=target):
                if not isinstance(target, Register) or target.index != _LINK or guard is not None:
                    self._found("return", "a branch that is not the return")
                elif self.returns is not None:
                    self._found("return", "a second return")
                self.returns = cycle + BRANCH_DELAY + 1
            case LoadAddress():
                self._found("return", "a call")
            case ReadControl() | WriteControl() | Return():
                self._found("convention", "a control register in a function")

    def _write(self, register: Register, result: _InFlight) -> None:
        flying = self.flying.setdefault(register.index, [])
        for each in flying:
            opposite = result.guard is not None and each.guard == (result.guard[0], not result.guard[1])
            if not opposite or each.arrives != result.arrives:
                self._found("in flight", f"{register} is written while another result for it is on its way")
        if register.index == _LINK:
            self._found("convention", "the return address is written")
        flying.append(result)

    def _value(self, operand: Register | int) -> Op:
        return self.registers[operand.index] if isinstance(operand, Register) else self.graph.const(operand)

    def _computed(self, mnemonic: str, values: list[Op]) -> Op:
        op, const = self.graph.op, self.graph.const
        match mnemonic:
            case "mvk":
                return values[0]
            case "sub" if values[1].kind == "const":
                return op("add", values[0], const(-values[1].number))
            case mnemonic if mnemonic in _SCALED:
                return op("add", values[0], op("mpy32", values[1], const(_SCALED[mnemonic])))
            case "andn":
                return op("and", values[0], op("xor", values[1], const(MASK)))
            case "clr" if all(value.kind == "const" for value in values[1:]):
                return op("and", values[0], op("clr", const(MASK), *values[1:]))
            case "extu":
                return op("shru", op("shl", values[0], values[1]), values[2])
            case mnemonic if mnemonic in COMPUTED or all(value.kind == "const" for value in values):
                return op(mnemonic, *values)
        return self._untraced(f"{mnemonic} is not traced")

    def _untraced(self, text: str) -> Op:
        """A value that nothing is known of."""
        return self.graph.symbol(f"{text}: {self.graph.count}")

    def _decomposed(self, *addresses: Op) -> tuple[str, int, Op | None]:
        """Object, bytes from its start, and what is added to them, of a sum."""
        pending, rest, number, name = list(addresses), [], 0, ""
        while pending:
            match pending.pop():
                case Op(kind="add", args=args):
                    pending += args
                case Op(kind="const", number=further):
                    number += signed(further)
                case Op() as op if op in self.objects:
                    name = self.objects[op]
                case op:
                    rest.append(op)
        return name, number, functools.reduce(functools.partial(self.graph.op, "add"), rest) if rest else None

    def _place(self, action: Access, word: int) -> tuple[str, int, Op | None]:
        """`_decomposed` of the address of a word of an access."""
        memory = action.memory
        scale = memory.sign * (action.size if memory.scaled else 1)
        offset = self.graph.op("mpy32", self._value(memory.offset), self.graph.const(scale))
        name, number, rest = self._decomposed(self.registers[memory.base.index], offset)
        if action.alignment >= 8 and not word:
            if not name or rest:
                self._found("alignment", "64 bits at an address that is not known to be a multiple of 8")
            elif number % 8:
                self._found("alignment", "64 bits at an address that is not a multiple of 8")
        if name == _STACK:
            if rest or memory.step:
                self._found("stack", "an address on the stack that is not constant")
            pointer = self._decomposed(self.registers[STACK_POINTER])
            lowest = pointer[1] if pointer[0] == _STACK and not pointer[2] else 0
            if isinstance(action, Store) and not word and not lowest < number <= -action.size:
                self._found("stack", f"a store at {number} from the stack pointer of the caller")
        elif memory.step or action.size < WORD:
            self._untraced("an access of less than a word, or one that moves its base")
        return name, number + WORD * word, rest

    def _read(self, name: str, offset: int, distance: Op | None) -> Op:
        if distance is None and name:
            return self.memory.setdefault((name, offset), self.graph.symbol(f"unknown {name}{offset:+}"))
        return self._untraced("a load")

    def _store(self, name: str, offset: int, distance: Op | None, chosen: Callable[[Op], Op]) -> None:
        if distance is None and name:
            self.memory[name, offset] = chosen(self.memory.get((name, offset), self.graph.const(0)))
