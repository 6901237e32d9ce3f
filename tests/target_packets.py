"""Hand-written packets for the simulator's tests, in the form that objdump prints them. Needs no C674x compiler."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

from hysgen.target import interpreter, translation
from hysgen.target.assembly import instructions
from hysgen.target.elf import Image, Section, Symbol
from hysgen.target.packets import packets
from hysgen.target.processor import MEMORY_BASE, RETURN_ADDRESS, Counts, load

CODE = MEMORY_BASE
DATA = MEMORY_BASE + 0x8000
RETURN = "b .S2 b3\nnop 5"


@dataclass(frozen=True)
class After:
    """Registers and memory when a run has ended."""

    registers: list[int]
    memory: bytearray
    counts: Counts

    def __getitem__(self, register: str) -> int:
        return self.registers[index(register)]

    def word(self, address: int) -> int:
        return int(struct.unpack_from("<I", self.memory, address - MEMORY_BASE)[0])


def index(register: str) -> int:
    """0..63 for a0..b31."""
    return int(register[1:]) + (32 if register[0] == "b" else 0)


def bits(value: float) -> int:
    """The single-precision image of a value."""
    return int(struct.unpack("<I", struct.pack("<f", value))[0])


def listing(text: str) -> tuple[str, dict[str, int]]:
    """`text`, one instruction per line, as objdump prints it from CODE on; and where its labels (`name:`) stand."""
    lines = [line.strip() for line in text.strip().splitlines() if line.strip()]
    labels: dict[str, int] = {}
    code: list[str] = []
    for line in lines:
        if line.endswith(":"):
            labels[line[:-1]] = CODE + 4 * len(code)
        else:
            code.append(line)
    known = "|".join(labels) or "(?!)"
    named = [re.sub(rf"\b({known})\b", lambda found: f"{labels[found[1]]:x} <{found[1]}>", line) for line in code]
    return "\n".join(f"{CODE + 4 * i:x}:\t00000000 \t{line}" for i, line in enumerate(named)), labels


def program(text: str) -> tuple[Image, str]:
    """A program as the compiler would hand it over: code at CODE, 1 KiB of data at DATA, every label a function."""
    printed, labels = listing(text)
    code = Section(".text", CODE, 4 * len(printed.splitlines()), b"", writable=False)
    data = Section(".data", DATA, 1024, b"", writable=True)
    symbols = {name: Symbol(name, address, 0, True) for name, address in {"start": CODE, **labels}.items()}
    return Image((code, data), symbols), printed


class Bench:
    """Functions of hand-written packets, ready to be called again and again by their labels."""

    def __init__(self, text: str, interpreted: bool) -> None:
        self.image, printed = program(text)
        self.packets = packets(instructions(printed))
        self.engine = interpreter.run if interpreted else translation.engine(self.packets)

    def run(self, label: str = "start", memory: dict[int, int] | None = None, **registers: int) -> After:
        """Run from `label` until the return. memory: words by address. registers: 32-bit images; the others are 0."""
        processor = load(self.image, self.packets)
        processor.program_counter = self.image.symbol(label).address
        for address, word in (memory or {}).items():
            struct.pack_into("<I", processor.memory, address - MEMORY_BASE, word)
        for name, value in {"b3": RETURN_ADDRESS, **registers}.items():
            processor.registers[index(name)] = value
        counts = self.engine(processor, 10_000)
        return After(processor.registers, processor.memory, counts)


def run(text: str, interpreted: bool, memory: dict[int, int] | None = None, **registers: int) -> After:
    """Run packets once, from the first line; RETURN is added at the end if there is no return in them."""
    return Bench(text if "b3" in text else f"{text}\n{RETURN}", interpreted).run("start", memory, **registers)
