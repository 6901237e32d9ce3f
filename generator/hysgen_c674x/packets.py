"""Execute packets: instructions issued in the same cycle, and the resource limits of one packet.

Source: SPRUFE8, section 3.8 (resource constraints). The effect of a packet beyond a limit is undefined on silicon. The
simulator refuses such packets, which also checks the compiler's schedule.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from hysgen.checking.symbolic.semantics import READS_DESTINATION
from hysgen.errors import TargetError
from hysgen_c674x.assembly import Instruction, Register
from hysgen_c674x.decode import (
    Access,
    Action,
    Compute,
    Idle,
    Jump,
    LoadAddress,
    ReadControl,
    Store,
    WriteControl,
    action,
)

_PACKET_LIMIT = 8
_READS_PER_REGISTER = 4
_UNITS_PER_CROSS_PATH = 2


@dataclass(frozen=True)
class Packet:
    """Instructions issued together at `address`, and their actions; `next` is the address after the packet.

    idle: cycles without instructions after the packet's own cycle.
    cross_reads: registers read over a cross path. Silicon stalls for one cycle if such a register was written in the
    preceding cycle by an instruction other than a load; the simulator counts these stalls separately from the cycles.
    refusal: why the packet cannot be run, or None. It is reported only when the packet is reached: linked library
    routines that are never called may hold instructions that are not modelled.
    """

    address: int
    next: int
    instructions: tuple[Instruction, ...]
    actions: tuple[Action, ...]
    idle: int
    cross_reads: frozenset[Register]
    refusal: str | None

    def __str__(self) -> str:
        return " ".join(instruction.text for instruction in self.instructions)


def packets(instructions: Iterable[Instruction]) -> Mapping[int, Packet]:
    """The packets of a program by address; the bars (`||`) of the listing mark parallel instructions."""
    return {packet.address: packet for packet in map(_packet, _groups(instructions))}


def _groups(instructions: Iterable[Instruction]) -> Iterator[list[Instruction]]:
    group: list[Instruction] = []
    for instruction in instructions:
        adjacent = bool(group) and instruction.address == group[-1].address + 4
        if group and not (instruction.parallel and adjacent):
            yield group
            group = []
        group.append(instruction)
    if group:
        yield group


def _packet(group: list[Instruction]) -> Packet:
    actions: tuple[Action, ...] = ()
    refusal = None
    try:
        actions = tuple(action(instruction) for instruction in group)
        _check(group, actions)
    except TargetError as fault:
        refusal = str(fault)
    crossed = {register for pair in zip(group, actions, strict=False) for register in _cross_reads(*pair)}
    idle = sum(_idle(each) for each in actions)
    return Packet(group[0].address, group[-1].address + 4, tuple(group), actions, idle, frozenset(crossed), refusal)


def _check(group: list[Instruction], actions: tuple[Action, ...]) -> None:
    here = group[0]
    if len(group) > _PACKET_LIMIT:
        raise TargetError(f"{here}: {len(group)} instructions in one packet, the limit is {_PACKET_LIMIT}")
    if here.parallel:
        raise TargetError(f"{here}: the packet starts with an instruction that is parallel to nothing")
    units = Counter(instruction.unit.name for instruction in group if instruction.unit)
    _refuse_excess(here, "unit", units, 1)
    _refuse_excess(here, "data path", Counter(_data_paths(group, actions)), 1)
    reads = Counter(str(register) for each in actions for register in operands(each, ports=True))
    _refuse_excess(here, "register read port of", reads, _READS_PER_REGISTER)
    if sum(_idle(each) > 0 for each in actions) > 1:
        raise TargetError(f"{here}: two instructions of the packet request idle cycles")
    _check_cross_paths(group, actions)
    for instruction, each in zip(group, actions, strict=True):
        _check_sides(instruction, each)


def _refuse_excess(here: Instruction, what: str, uses: Counter[str], limit: int) -> None:
    for name, count in uses.items():
        if count > limit:
            raise TargetError(f"{here}: {what} {name} used {count} times in the packet, the limit is {limit}")


def _idle(each: Action) -> int:
    """Cycles without instructions that the action requests after its packet's own cycle."""
    match each:
        case Idle(cycles=cycles):
            return cycles
        case Jump(idle=cycles) | LoadAddress(idle=cycles):
            return cycles
    return 0


def _data_paths(group: list[Instruction], actions: tuple[Action, ...]) -> Iterator[str]:
    """Data paths used by loads and stores; an unaligned access uses both."""
    for instruction, each in zip(group, actions, strict=True):
        if isinstance(each, Access) and instruction.unit:
            unaligned = each.alignment < each.size
            yield from ("T1", "T2") if unaligned else (f"T{instruction.unit.path}",)


def operands(each: Action, ports: bool = False) -> Iterator[Register]:
    """Registers that an action reads, besides its predicate; ports: through operand ports.

    The destination of mvkh and addk has a port of its own.
    """
    match each:
        case Compute(mnemonic=mnemonic, sources=sources):
            printed = sources[:-1] if ports and mnemonic in READS_DESTINATION else sources
            yield from (source for source in printed if isinstance(source, Register))
        case Access(memory=memory):
            yield memory.base
            if isinstance(memory.offset, Register):
                yield memory.offset
            if isinstance(each, Store):
                yield from each.registers
        case Jump(target=Register() as target):
            yield target
        case WriteControl(source=source):
            yield source


def _cross_reads(instruction: Instruction, each: Action) -> Iterator[Register]:
    unit = instruction.unit
    if unit and unit.cross:
        yield from (register for register in operands(each, ports=True) if register.side != unit.side)


def _check_cross_paths(group: list[Instruction], actions: tuple[Action, ...]) -> None:
    """Each cross path carries one register per packet, to at most two units."""
    carried: dict[int, list[Register]] = defaultdict(list)
    for instruction, each in zip(group, actions, strict=True):
        if instruction.unit:
            carried[instruction.unit.side].extend(_cross_reads(instruction, each))
    for side, registers in carried.items():
        if len(set(registers)) > 1:
            names = " and ".join(sorted(map(str, set(registers))))
            raise TargetError(f"{group[0]}: cross path {side}X would have to carry {names} at once")
        if len(registers) > _UNITS_PER_CROSS_PATH:
            raise TargetError(f"{group[0]}: cross path {side}X serves {len(registers)} units, the limit is 2")


def _check_sides(instruction: Instruction, each: Action) -> None:
    """Operands come from the unit's own register file or over the cross path; results go to the unit's own file."""
    unit = instruction.unit
    if unit is None:
        return
    match each:
        case Compute(destination=destination):
            own = [destination] if unit.cross else [destination, *operands(each, ports=True)]
        case Access(memory=memory):
            own = [memory.base] if isinstance(memory.offset, int) else [memory.base, memory.offset]
            for register in each.registers:
                if register.side != unit.path:
                    raise TargetError(f"{instruction}: data path T{unit.path} does not reach {register}")
        case ReadControl(destination=destination):
            own = [destination]
        case _:
            own = []
    for register in own:
        if register.side != unit.side:
            raise TargetError(f"{instruction}: {register} is out of reach of unit {unit.name}")
