"""Inspection of assembled kernels: every rule of the pipeline that a schedule has to keep.

The packets come from the disassembly of the linked program, so the inspection shares no code with the scheduler. A
kernel is followed from its first packet to the end of the delay slots of its return. It is correct for every timing of
interrupts if no register is read or written while a result for it is in flight: an interrupt only lets such results
arrive earlier.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from hysgen.checking.symbolic.semantics import signed
from hysgen_c674x.assembly import Instruction, Register
from hysgen_c674x.decode import (
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
from hysgen_c674x.latency import BRANCH_DELAY
from hysgen_c674x.packets import Packet, operands

_LINK, _STACK = 32 + 3, 32 + 15
_PRESERVED: Final = frozenset({*range(10, 16), *range(32 + 10, 32 + 16), _LINK})
ARGUMENTS: Final = (4, 32 + 4, 6, 32 + 6, 8, 32 + 8)
_GUARDS: Final = frozenset({0, 1, 2, 32, 33, 34})


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
    value: object
    guard: tuple[int, bool] | None
    load: bool


@dataclass(frozen=True)
class _Argument:
    """The argument in a register at entry plus an offset; an argument that is an address is a multiple of 8."""

    register: int
    offset: int


@dataclass(frozen=True)
class _Stack:
    """The stack pointer at entry plus an offset."""

    offset: int


def function_packets(image: ProgramImage, packets: Mapping[int, Packet], function: str) -> list[Packet]:
    """The packets of a function in the order of their addresses."""
    symbol = image.symbol(function)
    return [packets[at] for at in sorted(packets) if symbol.address <= at < symbol.address + symbol.size]


def inspect(packets: Sequence[Packet], parameters: int) -> list[Finding]:
    """All broken rules of a kernel with this number of arguments."""
    return _Inspection(parameters).run(packets)


@dataclass
class _Inspection:
    parameters: int
    findings: list[Finding] = field(default_factory=list)
    values: dict[int, object] = field(default_factory=dict)
    flying: dict[int, list[_InFlight]] = field(default_factory=dict)
    stack: dict[int, object] = field(default_factory=dict)
    arrived: dict[int, tuple[int, bool]] = field(default_factory=dict)
    ports: dict[tuple[str, int], int] = field(default_factory=dict)
    returns: int | None = None
    here: int = 0

    def run(self, packets: Sequence[Packet]) -> list[Finding]:
        self.values = {register: f"entry {register}" for register in _PRESERVED}
        self.values[_STACK] = _Stack(0)
        self.values |= {register: _Argument(register, 0) for register in ARGUMENTS[: self.parameters]}
        cycle = 0
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
            wanted = _Stack(0) if register == _STACK else f"entry {register}"
            if self.values.get(register) != wanted:
                self._found("convention", f"{Register(register)} does not have its value at entry")
        return self.findings

    def _found(self, rule: str, text: str) -> None:
        self.findings.append(Finding(self.here, rule, text))

    def _land(self, cycle: int) -> None:
        for register, flying in self.flying.items():
            for each in [each for each in flying if each.arrives <= cycle]:
                if each.guard is None or register not in self.values or isinstance(self.values[register], _Argument):
                    self.values[register] = each.value
                elif self.values[register] != each.value:
                    self.values[register] = "either"
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
                self._read(guard.register, cycle, False)
            for register in operands(action):
                crosses = instruction.unit is not None and register.side != instruction.unit.side
                self._read(register, cycle, crosses and not isinstance(action, Access))
        defined = set(self.values) | {register for register, flying in self.flying.items() if flying}
        for instruction, action in pairs:
            self._act(instruction, action, cycle)
        for index, flying in self.flying.items():
            if index not in defined and len(flying) == 1 and flying[0].guard is not None:
                self._found("undefined", f"{Register(index)} is written under a condition and holds nothing otherwise")

    def _read(self, register: Register, cycle: int, crosses: bool) -> None:
        index = register.index
        if any(each.arrives > cycle for each in self.flying.get(index, [])):
            self._found("in flight", f"{register} is read while a result for it is on its way")
        elif index not in self.values:
            self._found("undefined", f"{register} is read before it is written")
        elif crosses and self.arrived.get(index) == (cycle, False):
            self._found("stall", f"{register} crosses in the cycle behind its write")

    def _act(self, instruction: Instruction, action: Action, cycle: int) -> None:
        condition = instruction.predicate
        guard = (condition.register.index, condition.when_zero) if condition else None
        if isinstance(action, Access):
            self._aligned(action)
        match action:
            case Compute(destination=destination, delay=delay):
                unit = instruction.unit
                if unit is not None and unit.kind in "LSM":
                    self._port(unit.name, cycle + delay, guard)
                self._write(destination, cycle + delay + 1, self._computed(action), guard, False)
            case Load(registers=registers, delay=delay):
                place = self._place(action)
                for word, register in enumerate(registers):
                    value = self.stack.get(place.offset + 4 * word, object()) if place is not None else object()
                    self._write(register, cycle + delay + 1, value, guard, True)
            case Store(registers=registers):
                place = self._place(action)
                pointer = self.values.get(_STACK)
                if place is not None:
                    lowest = pointer.offset if isinstance(pointer, _Stack) else 0
                    if not lowest < place.offset <= -action.size:
                        self._found("stack", f"a store at {place.offset} from the stack pointer of the caller")
                    for word, register in enumerate(registers):
                        self.stack[place.offset + 4 * word] = self.values.get(register.index)
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

    def _port(self, unit: str, cycle: int, guard: tuple[int, bool] | None) -> None:
        key = unit, cycle
        if key in self.ports:
            self._found("write port", f"two results leave {unit} in one cycle")
        self.ports[key] = cycle

    def _write(
        self, register: Register, arrives: int, value: object, guard: tuple[int, bool] | None, load: bool
    ) -> None:
        flying = self.flying.setdefault(register.index, [])
        for each in flying:
            opposite = guard is not None and each.guard == (guard[0], not guard[1]) and each.arrives == arrives
            if not opposite:
                self._found("in flight", f"{register} is written while another result for it is on its way")
        if register.index == _LINK:
            self._found("convention", "the return address is written")
        flying.append(_InFlight(arrives, value, guard, load))

    def _computed(self, action: Compute) -> object:
        """The value of an instruction, as far as it is followed: constants, copies, stack pointer, arguments."""
        known = [self.values.get(each.index) if isinstance(each, Register) else each for each in action.sources]
        if action.mnemonic == "addk" and isinstance(known[0], int) and isinstance(known[1], _Stack):
            return _Stack(known[1].offset + signed(known[0]))
        if action.mnemonic == "addk" and isinstance(known[1], int) and isinstance(known[0], _Stack):
            return _Stack(known[0].offset + signed(known[1]))
        if action.mnemonic in ("mvk", "mvkl") and len(known) == 1 and isinstance(known[0], int):
            return signed(known[0])
        if action.mnemonic in ("mv", "add", "or") and (0 in known or len(known) == 1):
            other = [each for each in known if each != 0]
            if len(other) == 1 and isinstance(other[0], _Stack | _Argument):
                return other[0]
        if action.mnemonic == "add" and len(known) == 2:
            for base, distance in (known, reversed(known)):
                if isinstance(base, _Argument) and isinstance(distance, int):
                    return _Argument(base.register, base.offset + signed(distance))
        return object()

    def _aligned(self, action: Access) -> None:
        """64-bit accesses are to multiples of 8 from an argument, or to the stack."""
        if action.alignment < 8:
            return
        base = self.values.get(action.memory.base.index)
        offset = action.memory.offset
        if not isinstance(base, _Argument | _Stack) or not isinstance(offset, int):
            self._found("alignment", "64 bits at an address that is not known to be a multiple of 8")
        elif (base.offset + offset * (action.size if action.memory.scaled else 1)) % 8:
            self._found("alignment", "64 bits at an address that is not a multiple of 8")

    def _place(self, action: Access) -> _Stack | None:
        """The address of an access to the stack."""
        base = self.values.get(action.memory.base.index)
        offset = action.memory.offset
        if not isinstance(base, _Stack):
            return None
        if not isinstance(offset, int) or action.memory.step:
            self._found("stack", "an address on the stack that is not constant")
            return None
        return _Stack(base.offset + action.memory.sign * offset * (action.size if action.memory.scaled else 1))
