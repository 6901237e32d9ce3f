"""Assembly text of a schedule, in the syntax of the GNU assembler for the C6000."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from hysgen_c674x.schedule.placement import Placement, Schedule

_MOST_IDLE = 9


def function_text(name: str, schedule: Schedule) -> str:
    """One function; its packets in order, empty cycles as a multi-cycle nop."""
    packets: dict[int, list[str]] = defaultdict(list)
    for placement in schedule.placements:
        packets[placement.cycle] += _instructions(placement)
    for each in schedule.frame:
        packets[each.cycle].append(each.text)
    packets[schedule.branch].append("b .s2 b3")
    lines = [f"\t.global {name}", f"\t.type {name}, @function", "\t.align 5", f"{name}:"]
    idle = 0
    for cycle in range(schedule.cycles):
        if not packets[cycle]:
            idle += 1
            continue
        lines += _idle(idle)
        idle = 0
        first, *others = packets[cycle]
        lines += [f"\t   {first}", *(f"\t|| {each}" for each in others)]
    lines += [*_idle(idle), f"\t.size {name}, .-{name}"]
    return "\n".join(lines) + "\n"


def code_bytes(schedule: Schedule) -> int:
    """Bytes of a function without padding: 4 for every instruction."""
    return 4 * sum(line.startswith(("\t   ", "\t|| ")) for line in function_text("", schedule).splitlines())


def table_text(name: str, words: tuple[int, ...]) -> str:
    """A table of constants."""
    rows = [", ".join(f"0x{word:08x}" for word in words[k : k + 6]) for k in range(0, len(words), 6)]
    return "\n".join(["\t.align 2", f"{name}:", *(f"\t.word {row}" for row in rows)]) + "\n"


def file_text(header: str, functions: Mapping[str, Schedule], tables: Mapping[str, tuple[int, ...]]) -> str:
    """The assembly file of several functions and their tables."""
    parts = [header]
    parts += [f'\t.section .text.{name}, "ax"\n{function_text(name, each)}\n' for name, each in functions.items()]
    if tables:
        parts += ["\t.section .rodata\n", *(table_text(name, words) for name, words in tables.items())]
    return "".join(parts)


def _idle(cycles: int) -> list[str]:
    lines = []
    while cycles > 0:
        here = min(cycles, _MOST_IDLE)
        lines.append(f"\t   nop {here}" if here > 1 else "\t   nop")
        cycles -= here
    return lines


def _register(register: tuple[int, int] | int) -> str:
    return str(register) if isinstance(register, int) else f"{'ab'[register[0]]}{register[1]}"


def _instructions(placement: Placement) -> list[str]:
    node = placement.node
    own = [_register(operand) for operand in placement.operands]
    result = _register((placement.data_side, placement.register)) if placement.register is not None else ""
    unit = f".{placement.unit.lower()}" + ("x" if placement.cross else "")
    match node.mnemonic:
        case "lddw":
            sign, words = ("-" if node.number < 0 else "+"), abs(node.number) // 8
            assert placement.register is not None
            high = _register((placement.data_side, placement.register + 1))
            return [f"lddw {unit}t{placement.data_side + 1} *{sign}{own[0]}[{words}], {high}:{result}"]
        case "stdw":
            sign, words = ("-" if node.number < 0 else "+"), abs(node.number) // 8
            even, odd = (operand for operand in placement.operands[1:] if not isinstance(operand, int))
            assert (even[0], even[1] + 1) == odd, "a 64-bit store takes neighbouring registers"
            guard = f"[{_register(placement.guard)}] " if placement.guard else ""
            return [f"{guard}stdw {unit}t{placement.data_side + 1} {own[2]}:{own[1]}, *{sign}{own[0]}[{words}]"]
        case "ldw" | "stw":
            sign, words = ("-" if node.number < 0 else "+"), abs(node.number) // 4
            path = f"{unit}t{placement.data_side + 1}"
            where = f"*{sign}{own[0]}[{words}]"
            if node.mnemonic == "ldw":
                return [f"ldw {path} {where}, {result}"]
            guard = f"[{_register(placement.guard)}] " if placement.guard else ""
            return [f"{guard}stw {path} {own[1]}, {where}"]
        case "select":
            assert placement.guard is not None
            return [
                f"[{'!' if when_zero else ''}{_register(placement.guard)}] "
                f"{'mvk' if isinstance(operand, int) else 'mv'} .{name.lower()}{'x' if cross else ''} "
                f"{_register(operand)}, {result}"
                for name, when_zero, operand, cross in placement.moves
            ]
        case "mvk":
            return [f"mvk {unit} {node.number}, {result}"]
        case "mvkl" | "mvkh":
            return [f"{node.mnemonic} {unit} {node.symbol or hex(node.number)}, {result}"]
    return [f"{node.mnemonic} {unit} {', '.join([*own, result])}"]
