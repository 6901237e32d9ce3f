"""C674x instructions as data, parsed from the text of objdump.

The assembler's own disassembler decodes the bits, so simulator and assembler cannot disagree about an encoding. One
line becomes one `Instruction`; `decode` gives its action.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from hysgen.errors import TargetError


@dataclass(frozen=True)
class Register:
    """One of the 64 registers: A0..A31 are 0..31, B0..B31 are 32..63."""

    index: int

    @property
    def side(self) -> int:
        """1 for register file A, 2 for file B, as in the names of the functional units."""
        return 1 + self.index // 32

    def __str__(self) -> str:
        return f"{'ab'[self.index // 32]}{self.index % 32}"


@dataclass(frozen=True)
class Pair:
    """A register pair `high:low` that holds 64 bits."""

    high: Register
    low: Register


@dataclass(frozen=True)
class MemoryOperand:
    """An address operand: base register plus or minus an offset, with optional update of the base.

    offset: a number or a register, in bytes, or in elements if `scaled`. sign: +1 or -1.
    step: '' (base unchanged), 'before' or 'after' (base := base +- offset before or after the access).
    """

    base: Register
    offset: int | Register
    sign: int
    scaled: bool
    step: str


@dataclass(frozen=True)
class Label:
    """A code address."""

    address: int


Operand = Register | Pair | MemoryOperand | Label | int | str  # str: a form without a class, such as a control register


@dataclass(frozen=True)
class Unit:
    """A functional unit: `kind` L, S, M or D on `side` 1 or 2.

    cross: one operand comes from the other register file. path: data path 1 or 2 of a load or store, else 0.
    """

    kind: str
    side: int
    cross: bool
    path: int

    @property
    def name(self) -> str:
        """Name without modifiers: L1, S2, ..."""
        return f"{self.kind}{self.side}"


@dataclass(frozen=True)
class Predicate:
    """A condition of execution: the register is not zero, or is zero if `when_zero`."""

    register: Register
    when_zero: bool


@dataclass(frozen=True)
class Instruction:
    """One 32-bit instruction. parallel: whether it is in the execute packet of the preceding instruction."""

    address: int
    parallel: bool
    predicate: Predicate | None
    mnemonic: str
    unit: Unit | None
    operands: tuple[Operand, ...]
    text: str

    def __str__(self) -> str:
        return f"{self.address:08x} {self.text}"


_LINE = re.compile(r"^\s*([0-9a-f]+):\t([0-9a-f]+)\s*\t(.+)$")
_INSTRUCTION = re.compile(r"(\|\| )?(?:\[(!?)([ab]\d+)\] )?(\w+)(?: \.([LSMD])([12])(X?)(?:T([12]))?)?(?: (.*))?$")
_REGISTER = re.compile(r"[ab](?:[12]?\d|3[01])$")
_PAIR = re.compile(r"[ab]\d+:[ab]\d+$")
_NUMBER = re.compile(r"-?\d+$")
_OFFSET = r"[ab]\d+|\d+"
_MEMORY = re.compile(rf"\*(\+\+|--|\+|-)?([ab]\d+)(\+\+|--)?(?:\(({_OFFSET})\)|\[({_OFFSET})\])?$")


def instructions(listing: str) -> Iterator[Instruction]:
    """Every instruction of an `objdump -dz` listing, in order.

    Raises TargetError for an opcode that is not 32 bits wide. An operand of an unknown form stays text; `decode`
    refuses the instruction when it is executed.
    """
    for line in listing.splitlines():
        match = _LINE.match(line)
        if match is None:
            continue
        address, opcode, text = int(match[1], 16), match[2], match[3].strip()
        if len(opcode) != 8:
            raise TargetError(f"{address:08x} {text}: a compact instruction; the simulator models 32-bit opcodes only")
        yield _instruction(address, text)


def _instruction(address: int, text: str) -> Instruction:
    match = _INSTRUCTION.match(text)
    if match is None:
        raise TargetError(f"{address:08x} {text}: not an instruction form that the simulator parses")
    parallel, inverted, condition, mnemonic, kind, side, cross, path, rest = match.groups()
    return Instruction(
        address=address,
        parallel=parallel is not None,
        predicate=Predicate(_register(condition), inverted == "!") if condition else None,
        mnemonic=mnemonic,
        unit=Unit(kind, int(side), bool(cross), int(path or 0)) if kind else None,
        operands=tuple(_operand(part.strip()) for part in rest.split(",")) if rest else (),
        text=text,
    )


def _operand(text: str) -> Operand:
    if "<" in text:
        return Label(int(text.split()[0], 16))
    if _REGISTER.match(text):
        return _register(text)
    if _PAIR.match(text):
        high, low = text.split(":")
        return Pair(_register(high), _register(low))
    if _NUMBER.match(text):
        return int(text, 0)
    return _memory(text) or text


def _memory(text: str) -> MemoryOperand | None:
    match = _MEMORY.match(text)
    if match is None:
        return None
    before, base, after, in_bytes, in_elements = match.groups()
    step = "before" if before in ("++", "--") else "after" if after else ""
    sign = -1 if "-" in (before or "") + (after or "") else 1
    offset = in_bytes or in_elements or "0"
    if _NUMBER.match(offset):
        # objdump prints constant offsets in bytes, except those of ldndw and stndw that the opcode encodes in elements.
        return MemoryOperand(_register(base), int(offset), sign, in_elements is not None, step)
    return MemoryOperand(_register(base), _register(offset), sign, in_elements is not None, step)


def _register(text: str) -> Register:
    return Register(int(text[1:]) + (32 if text[0] == "b" else 0))
