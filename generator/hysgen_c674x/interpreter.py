"""Interpreter of execute packets, cycle by cycle: the readable specification of the pipeline.

The rules, each a few lines below (source: SPRUFE8, sections 3 and 4):
- every instruction of a packet reads its registers before any of them writes;
- a result is written `delay + 1` cycles after issue; until then reads give the old value;
- memory is read and written in the order of issue, the loads of a packet before its stores;
- a taken branch takes effect 6 cycles after issue and ends a multi-cycle NOP in progress;
- two writes to one register, or from one unit's write port, in one cycle are undefined and refused;
- an interrupt is taken before a packet that is in no branch's delay slots, the first of a vector INTERRUPT_OVERHEAD
  cycles later; results on their way arrive meanwhile.
Stalls (caches, memory banks, cross paths) are not part of `cycles`; those of the cross paths are counted separately.
"""

from dataclasses import dataclass, field

from hysgen.checking.symbolic.semantics import FLOAT, INTEGER, MASK, FloatUnit, signed
from hysgen_c674x.assembly import Instruction, Register
from hysgen_c674x.decode import (
    BRANCH_DELAY,
    CONTROL,
    Access,
    Action,
    Compute,
    Jump,
    Load,
    LoadAddress,
    ReadControl,
    Return,
    Source,
    Store,
    WriteControl,
)
from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import (
    INTERRUPT_OVERHEAD,
    MEMORY_BASE,
    MEMORY_SIZE,
    NEVER,
    RETURN_ADDRESS,
    STACK_POINTER,
    AccessKind,
    Processor,
    ProcessorFault,
    RunCounts,
)

_AMR, _CSR, _IFR, _ISR, _ICR, _IER, _ISTP, _IRP, _NRP, _TSCL, _FADCR, _FMCR = range(len(CONTROL) - 1)
_GIE, _PGIE, _NMI, _MASKABLE = 1, 2, 2, 0xFFF0


@dataclass(frozen=True)
class _Write:
    """A pending write to a register. port: the writing unit, None for loads and addresses."""

    register: Register
    value: int
    port: str | None
    load: bool


class _FaultError(Exception):
    """A fault in the packet being issued; `run` adds its address."""

    def __init__(self, kind: ProcessorFault, detail: int = 0) -> None:
        self.kind, self.detail = kind, detail


@dataclass
class PipelineState:
    """State of a run: the processor, and pending writes and branches by the cycle in which they take effect."""

    processor: Processor
    cycle: int = 0
    writes: dict[int, list[_Write]] = field(default_factory=dict)
    branches: dict[int, int] = field(default_factory=dict)
    unit: FloatUnit = field(default_factory=FloatUnit)
    lowest_stack_pointer: int = MASK
    next_event: int = 0

    def __post_init__(self) -> None:
        if self.processor.devices is None:
            self.next_event = NEVER


def run(processor: Processor, cycle_limit: int) -> RunCounts:
    """Run from `processor.program_counter` until a branch to RETURN_ADDRESS takes effect.

    Raises TargetError with the packet if the processor forbids its effect or the simulator does not model it.
    """
    state = PipelineState(processor)
    idle = stalls = issued = here = 0
    while True:
        just_written = land(state)
        target = state.branches.pop(state.cycle, None)
        if target is not None:
            processor.program_counter, idle = target, 0
        if processor.program_counter == RETURN_ADDRESS:
            break
        if state.cycle >= cycle_limit:
            raise processor.fault(ProcessorFault.CYCLE_LIMIT, here, cycle_limit)
        _events(state)
        vector = None if idle else interrupt(state)
        if idle:
            idle -= 1
        elif vector is not None:
            processor.program_counter, idle = vector, INTERRUPT_OVERHEAD - 1
        else:
            here = processor.program_counter
            packet = processor.packet(here)
            try:
                if issued != processor.skipped:
                    issue(packet, state)
            except _FaultError as fault:
                raise processor.fault(fault.kind, here, fault.detail) from None
            issued += 1
            stalls += bool(packet.cross_reads & just_written)
            processor.program_counter, idle = packet.next, packet.idle
        state.cycle += 1
    cycles = state.cycle
    while state.writes:
        state.cycle += 1
        land(state)
    return RunCounts(cycles, stalls, issued, state.unit.denormals, state.unit.nans, state.lowest_stack_pointer)


def land(state: PipelineState) -> set[Register]:
    """Perform the writes due in this cycle; returns the registers that a cross path would have to wait for."""
    landing = state.writes.pop(state.cycle, [])
    for write in landing:
        state.processor.registers[write.register.index] = write.value
        if write.register.index == STACK_POINTER:
            state.lowest_stack_pointer = min(state.lowest_stack_pointer, write.value)
    return {write.register for write in landing if not write.load}


def _events(state: PipelineState) -> None:
    """Set the interrupt flags that devices raise in this cycle; raises TargetError if one resets the chip."""
    processor, devices = state.processor, state.processor.devices
    if devices is not None and state.cycle >= state.next_event:
        ahead = devices.library.ffi.new("uint64_t *")
        flags = devices.library.lib.device_events(devices.handle, state.cycle, ahead)
        state.next_event = ahead[0]
        if flags & 1:
            raise processor.fault(ProcessorFault.RESET, processor.program_counter, 0)
        processor.control[_IFR] |= flags


def interrupt(state: PipelineState) -> int | None:
    """Take the interrupt that is due, the lowest number first, and return its vector; None if none is due.

    Source: SPRUFE8, chapter 5. NMI needs NMIE, the others GIE, NMIE and their bit of IER.
    """
    control = state.processor.control
    pending = control[_IFR] & control[_IER]
    if not pending or state.branches or not control[_IER] & _NMI:
        return None
    if pending & _NMI:
        number = 1
        control[_IER] &= ~_NMI
        control[_NRP] = state.processor.program_counter
    elif pending & _MASKABLE and control[_CSR] & _GIE:
        number = (pending & _MASKABLE & -(pending & _MASKABLE)).bit_length() - 1
        control[_CSR] = control[_CSR] & ~(_GIE | _PGIE) | _PGIE
        control[_IRP] = state.processor.program_counter
    else:
        return None
    control[_IFR] &= ~(1 << number)
    return (control[_ISTP] & ~0x3FF) + 32 * number


def issue(packet: Packet, state: PipelineState) -> None:
    """Start the instructions of a packet whose predicates hold; their results land in later cycles."""
    registers = tuple(state.processor.registers)
    state.processor.trace.add(state.cycle, AccessKind.FETCH, packet.address)
    executed = [
        (instruction, action)
        for instruction, action in zip(packet.instructions, packet.actions, strict=True)
        if _executes(instruction, registers)
    ]
    # Loads see memory as it was before this packet's stores.
    for instruction, action in sorted(executed, key=lambda pair: isinstance(pair[1], Store)):
        _start(instruction, action, packet, registers, state)


def _executes(instruction: Instruction, registers: tuple[int, ...]) -> bool:
    condition = instruction.predicate
    return condition is None or (registers[condition.register.index] == 0) == condition.when_zero


def _start(
    instruction: Instruction, action: Action, packet: Packet, registers: tuple[int, ...], state: PipelineState
) -> None:
    """Read the operands from `registers`, the values at issue, and schedule the results."""
    match action:
        case Compute(destination=destination, delay=delay):
            value = _computed(action, registers, state.unit)
            _later(state, delay, _Write(destination, value, _port(instruction), False))
        case Load():
            address = _address(action, registers, state)
            state.processor.trace.add(state.cycle, AccessKind.LOAD, address)
            value = _read(state, address, action)
            for word, register in enumerate(action.registers):
                _later(state, action.delay, _Write(register, value >> 32 * word & MASK, None, True))
        case Store():
            address = _address(action, registers, state)
            state.processor.trace.add(state.cycle, AccessKind.STORE, address)
            value = sum(registers[register.index] << 32 * word for word, register in enumerate(action.registers))
            _store(state, address, action.size, value)
        case Jump(target=target, link=link):
            lands = state.cycle + BRANCH_DELAY + 1
            if lands in state.branches:
                raise _FaultError(ProcessorFault.BRANCH_CLASH)
            state.branches[lands] = _value(target, registers)
            if link is not None:
                _later(state, 0, _Write(link, packet.next, None, False))
        case LoadAddress(destination=destination, address=address):
            _later(state, 0, _Write(destination, address, None, False))
        case ReadControl(control=number, destination=destination):
            _later(state, 0, _Write(destination, _control(state, number), _port(instruction), False))
        case WriteControl(control=number, source=source):
            _set_control(state, number, registers[source.index])
        case Return(control=number):
            _return(state, number)


def _control(state: PipelineState, number: int) -> int:
    processor = state.processor
    if number == _TSCL:
        return 0 if processor.counter_from is None else state.cycle - processor.counter_from & MASK
    return processor.control[number]


def _set_control(state: PipelineState, number: int, value: int) -> None:
    control = state.processor.control
    if number in (_AMR, _FADCR, _FMCR) and value:
        raise _FaultError(ProcessorFault.MODE, number)
    if number == _ISR:
        control[_IFR] |= value & _MASKABLE
    elif number == _ICR:
        control[_IFR] &= ~(value & _MASKABLE)
    elif number == _TSCL:
        if state.processor.counter_from is None:
            state.processor.counter_from = state.cycle
    elif number != _IFR:
        control[number] = value


def _return(state: PipelineState, number: int) -> None:
    """Return from an interrupt: GIE becomes PGIE; from an NMI: NMIE is set."""
    control, lands = state.processor.control, state.cycle + BRANCH_DELAY + 1
    if lands in state.branches:
        raise _FaultError(ProcessorFault.BRANCH_CLASH)
    state.branches[lands] = control[number]
    if number == _IRP:
        control[_CSR] = control[_CSR] & ~_GIE | control[_CSR] >> 1 & _GIE
    else:
        control[_IER] |= _NMI


def _computed(action: Compute, registers: tuple[int, ...], unit: FloatUnit) -> int:
    images = [_value(source, registers) for source in action.sources]
    if action.mnemonic in INTEGER:
        return INTEGER[action.mnemonic](*images)
    try:
        return FLOAT[action.mnemonic](unit, *images)
    except ValueError:
        raise _FaultError(ProcessorFault.NAN_TO_INTEGER) from None


def _value(source: Source, registers: tuple[int, ...]) -> int:
    return registers[source.index] if isinstance(source, Register) else source


def _port(instruction: Instruction) -> str | None:
    """The write port shared by results of different latencies of an L, S or M unit; a D unit has one latency only."""
    unit = instruction.unit
    return unit.name if unit and unit.kind in "LSM" else None


def _later(state: PipelineState, delay: int, write: _Write) -> None:
    landing = state.writes.setdefault(state.cycle + delay + 1, [])
    for other in landing:
        if other.register == write.register:
            raise _FaultError(ProcessorFault.REGISTER_CLASH, write.register.index)
        if write.port is not None and other.port == write.port:
            raise _FaultError(ProcessorFault.PORT_CLASH)
    landing.append(write)


def _address(action: Access, registers: tuple[int, ...], state: PipelineState) -> int:
    """The accessed address; an updated base register gets its new value in the next cycle."""
    memory = action.memory
    base = registers[memory.base.index]
    offset = _value(memory.offset, registers) * (action.size if memory.scaled else 1)
    moved = base + memory.sign * offset & MASK
    if memory.step:
        _later(state, 0, _Write(memory.base, moved, None, False))
    address = base if memory.step == "after" else moved
    if address % action.alignment:
        raise _FaultError(ProcessorFault.MISALIGNED, address)
    if state.processor.devices is None and not _inside(address, action.size):
        raise _FaultError(ProcessorFault.OUTSIDE, address)
    return address


def _inside(address: int, size: int) -> bool:
    return MEMORY_BASE <= address <= MEMORY_BASE + MEMORY_SIZE - size


def _read(state: PipelineState, address: int, action: Load) -> int:
    processor, devices, start = state.processor, state.processor.devices, address - MEMORY_BASE
    if devices is not None and not _inside(address, action.size):
        value = devices.library.lib.device_load(devices.handle, state.cycle, address, action.size)
    else:
        value = int.from_bytes(processor.memory[start : start + action.size], "little")
    return signed(value, 8 * action.size) & MASK if action.signed else value


def _store(state: PipelineState, address: int, size: int, value: int) -> None:
    processor, devices = state.processor, state.processor.devices
    if devices is not None and not _inside(address, size):
        devices.library.lib.device_store(devices.handle, state.cycle, address, size, value & (1 << 8 * size) - 1)
        state.next_event = 0  # a store may start a timer
        return
    if address < processor.read_only_end:
        raise _FaultError(ProcessorFault.READ_ONLY, address)
    start = address - MEMORY_BASE
    processor.memory[start : start + size] = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
