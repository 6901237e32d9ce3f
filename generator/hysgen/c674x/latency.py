"""Latencies: delay slots of every modelled instruction.

The result of an instruction issued in cycle t with d delay slots is read by instructions issued in cycle t + d + 1 and
later; until then the register holds its old value. The pipeline has no interlocks: the compiler must schedule for it.
Source: SPRUFE8, section 4 (pipeline phases per instruction type).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

BRANCH_DELAY = 5
LOAD_DELAY = 4

_SINGLE_CYCLE = (
    "add sub and or xor andn abs addab addah addaw addad subab subah subaw shl shr shru ext extu set clr "
    "cmpeq cmpgt cmplt cmpgtu cmpltu lmbd mvk mvkh addk abssp cmpeqsp cmpgtsp cmpltsp"
)
_TWO_CYCLE = "rotl mpy mpyu mpysu mpyus mpyh mpyhu mpyhl mpylh mpyhlu mpylhu"
_FOUR_CYCLE = "mpy32 addsp subsp mpysp intsp intspu spint sptrunc"
_LOADS = "ldb ldbu ldh ldhu ldw lddw ldnw ldndw"

DELAY_SLOTS: Mapping[str, int] = {
    **dict.fromkeys(_SINGLE_CYCLE.split(), 0),
    **dict.fromkeys(_TWO_CYCLE.split(), 1),
    **dict.fromkeys(_FOUR_CYCLE.split(), 3),
    **dict.fromkeys(_LOADS.split(), LOAD_DELAY),
}

_ENTRY = re.compile(r"^INSNE?\s*\((.*?)(?=^INSNE?\s*\(|^#|\Z)", re.S | re.M)
_WRITTEN = re.compile(r"\bOW(?:D|T)?REG[DL]?(\d)\b")
_READ_AND_WRITTEN = re.compile(r"\bORWREG(\d)\b")


def write_cycles(opcode_table: str) -> dict[str, frozenset[int]]:
    """For each mnemonic, the pipeline cycles (1 = E1) of the write to its destination, according to binutils.

    opcode_table: text of binutils' include/opcode/tic6x-opcode-table.h; the digit of its operand macros, such as
    OWREG4, is the cycle. Forms with 40-bit results and 16-bit opcodes are included.
    """
    found: dict[str, set[int]] = {}
    for entry in _ENTRY.finditer(opcode_table):
        body = entry[1]
        cycles = {int(digit) for digit in (*_WRITTEN.findall(body), *_READ_AND_WRITTEN.findall(body))}
        found.setdefault(body.split(",")[0].strip(), set()).update(cycles)
    return {mnemonic: frozenset(cycles) for mnemonic, cycles in found.items()}


def disagreements(opcode_table: str, delay_slots: Mapping[str, int] = DELAY_SLOTS) -> Iterator[str]:
    """One line for each mnemonic whose delay slots differ from the write cycles in binutils' opcode table."""
    written = write_cycles(opcode_table)
    for mnemonic, delay in sorted(delay_slots.items()):
        cycles = written.get(mnemonic, frozenset())
        if cycles != {delay + 1}:
            cycles_text = " or ".join(f"E{cycle}" for cycle in sorted(cycles)) or "nothing"
            yield f"{mnemonic}: {delay} delay slots here, written in {cycles_text} by binutils"
