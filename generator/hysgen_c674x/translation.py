"""Translation of packets to C with the rules of the interpreter, compiled on the host, for runs of millions of cycles.

Every packet becomes one C function that schedules its results; `engine/run.c` is the cycle loop. Nothing is optimised
across packets: each function stands below its assembly and can be compared with it.
"""

from collections.abc import Callable, Iterator, Mapping
from importlib import resources
from typing import Any

from hysgen.checking.symbolic.semantics import FLOAT, MASK
from hysgen.machine.native import Library, Toolchain, build, default_toolchain
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
    Source,
    Store,
    WriteControl,
)
from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import (
    INTERRUPT_OVERHEAD,
    MEMORY_BASE,
    MEMORY_SIZE,
    RETURN_ADDRESS,
    Processor,
    ProcessorFault,
    RunCounts,
)

Engine = Callable[[Processor, int], RunCounts]

# The cycle loop takes most of the time of a run, the packets most of the time of the compiler.
_UNOPTIMISED = ("#if defined(__GNUC__) && !defined(__clang__)", '#pragma GCC optimize ("O0")', "#endif")
_UNIT_BITS = {name: 1 << bit for bit, name in enumerate(("L1", "S1", "M1", "L2", "S2", "M2"))}


def engine(packets: Mapping[int, Packet]) -> Engine:
    """A function with the same registers, memory, counts and errors as `interpreter.run` of this program.

    Raises BuildError if there is no C compiler on the host.
    """
    library = compiled(packets)

    def run(processor: Processor, cycle_limit: int) -> RunCounts:
        state, trace = initial(library, processor), processor.trace
        state.cycle_limit = cycle_limit
        state.trace, state.trace_room = library.ffi.from_buffer("uint64_t[]", trace.words), trace.room
        library.lib.c674x_run(state)
        if state.fault:
            raise processor.fault(ProcessorFault(state.fault), state.fault_address, state.fault_detail)
        processor.registers, trace.count = list(state.reg), state.traced
        processor.program_counter, processor.control = state.program_counter, list(state.control)
        lowest = state.lowest_stack_pointer
        return RunCounts(state.cycle, state.stalls, state.packets, state.denormals, state.nans, lowest)

    return run


def compiled(packets: Mapping[int, Packet]) -> Library:
    """The engine of a program. Raises BuildError if there is no C compiler on the host."""
    texts = runtime()
    host = Toolchain(default_toolchain().command, ("-O1",))
    return build([*texts.items(), ("program.c", program(packets))], texts["state.h"], host)


def initial(library: Library, processor: Processor) -> Any:
    """The c674x_t of a run that begins with the state of `processor`, whose memory it shares."""
    state = library.ffi.new("c674x_t *")
    state.reg, state.control = processor.registers, processor.control
    state.memory = library.ffi.from_buffer("uint8_t[]", processor.memory)
    state.memory_base, state.memory_size = MEMORY_BASE, MEMORY_SIZE
    state.read_only_end = processor.read_only_end
    state.program_counter, state.return_address = processor.program_counter, RETURN_ADDRESS
    state.lowest_stack_pointer, state.interrupt_overhead = MASK, INTERRUPT_OVERHEAD
    state.skipped = processor.skipped
    if processor.devices is not None:
        state.devices = library.ffi.cast("void *", processor.devices.handle_address)
        for name in ("device_load", "device_store", "device_events"):
            kind = library.ffi.typeof(getattr(state, name))
            setattr(state, name, library.ffi.cast(kind, processor.devices.address(name)))
    return state


def runtime() -> dict[str, str]:
    """The C files of the engine by name; every translated program is compiled with them."""
    names = ("state.h", "operations.h", "pipeline.h", "pipeline.c", "run.c")
    folder = resources.files(__package__) / "engine"
    return {name: (folder / name).read_text(encoding="utf-8") for name in names}


def program(packets: Mapping[int, Packet]) -> str:
    """C of a program: one function per packet, and a table of the functions by address for the cycle loop."""
    start = min(packets, default=0)
    words = (max(packets, default=0) - start) // 4 + 1
    lines = [*_UNOPTIMISED, '#include "pipeline.h"', ""]
    for packet in packets.values():
        lines.extend(_function(packet))
    lines += [
        "extern const uint32_t program_start, program_words;",
        "extern const packet_t program[];",
        f"const uint32_t program_start = 0x{start:x}u, program_words = {words};",
        f"const packet_t program[{words}] = {{",
    ]
    for packet in packets.values():
        crossed = sum(1 << register.index for register in packet.cross_reads)
        row = f"packet_{packet.address:08x}, 0x{crossed:x}u, 0x{packet.next:08x}u, {packet.idle}"
        lines.append(f"    [{(packet.address - start) // 4}] = {{{row}}},")
    lines += ["};", ""]
    return "\n".join(lines)


def _function(packet: Packet) -> Iterator[str]:
    yield f"/* {packet} */"
    yield f"static void packet_{packet.address:08x}(c674x_t *m)"
    yield "{"
    if packet.refusal:
        yield "    stop(m, FAULT_REFUSED, 0);"
    else:
        pairs = list(zip(packet.instructions, packet.actions, strict=True))
        # Loads see memory as it was before this packet's stores. Registers do not change before the next cycle.
        for instruction, action in sorted(pairs, key=lambda pair: isinstance(pair[1], Store)):
            body = list(_statements(instruction, action, packet))
            yield from _guarded(instruction, body) if body else ()
    yield "}"
    yield ""


def _guarded(instruction: Instruction, body: list[str]) -> Iterator[str]:
    condition = instruction.predicate
    if condition is None:
        yield from (f"    {line}" for line in body)
    else:
        yield f"    if ({_value(condition.register)} {'==' if condition.when_zero else '!='} 0) {{"
        yield from (f"        {line}" for line in body)
        yield "    }"


def _statements(instruction: Instruction, action: Action, packet: Packet) -> Iterator[str]:
    match action:
        case Compute(destination=destination, delay=delay):
            yield _later(delay, destination, _computed(action), _port(instruction))
        case Access():
            yield from _access(action)
        case Jump(target=target, link=link):
            yield f"branch(m, {BRANCH_DELAY}, {_value(target)});"
            if link is not None:
                yield _later(0, link, _value(packet.next))
        case LoadAddress(destination=destination, address=address):
            yield _later(0, destination, _value(address))
        case ReadControl(control=number, destination=destination):
            yield _later(0, destination, f"read_control(m, {number})", _port(instruction))
        case WriteControl(control=number, source=source):
            yield f"write_control(m, {number}, {_value(source)});"
        case Return(control=number):
            yield f"return_from(m, {BRANCH_DELAY}, {number});"


def _computed(action: Compute) -> str:
    operands = ", ".join(_value(source) for source in action.sources)
    return f"op_{action.mnemonic}({'m, ' if action.mnemonic in FLOAT else ''}{operands})"


def _access(action: Access) -> Iterator[str]:
    memory = action.memory
    base = _value(memory.base)
    scale = f" * {action.size}u" if memory.scaled else ""
    moved = f"{base} {'+' if memory.sign > 0 else '-'} {_value(memory.offset)}{scale}"
    if memory.step:
        yield _later(0, memory.base, moved)
    where = f"{base if memory.step == 'after' else moved}, {action.size}, {action.alignment}"
    if isinstance(action, Load):
        value = f"load(m, {where})"
        if action.signed:
            bits = 64 - 8 * action.size
            value = f"(uint64_t)((int64_t)({value} << {bits}) >> {bits})"
        yield f"{{ uint64_t loaded = {value};"
        for word, register in enumerate(action.registers):
            part = f"(uint32_t)(loaded >> {32 * word})"
            yield f"  later(m, {action.delay}, {register.index}, {part}, 0, 1);"
        yield "}"
    else:
        words = (f"(uint64_t){_value(register)} << {32 * i}" for i, register in enumerate(action.registers))
        yield f"store(m, {where}, {' | '.join(words)});"


def _value(source: Source) -> str:
    return f"m->reg[{source.index}]" if isinstance(source, Register) else f"0x{source:x}u"


def _port(instruction: Instruction) -> int:
    unit = instruction.unit
    return _UNIT_BITS.get(unit.name, 0) if unit else 0


def _later(delay: int, register: Register, value: str, port: int = 0) -> str:
    return f"later(m, {delay}, {register.index}, {value}, {port}, 0);"
