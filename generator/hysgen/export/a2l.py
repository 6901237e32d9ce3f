"""ASAP2 1.7 (A2L): every parameter and state of the generated C with unit, limits, axis, and address in a linked ELF.

Limits of states are the certified box (`hysgen.checking.proof.eva.boxes`): intervals that no call leaves.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from hysgen.checking.proof.eva.boxes import instance_box
from hysgen.codegen.interface import Interface
from hysgen.errors import BuildError
from hysgen.float32.learner_status import LEARNER_MEANINGS
from hysgen.model.model import Model
from hysgen.model.status import MEANINGS
from hysgen.model.structs import BYTES_PER_WORD, Member, Struct

LARGEST: Final = 3.4028234663852886e38
"""Limit of a float32 for which no interval is proved."""

LARGEST_WORD: Final = 4294967295.0

_TABLE: Final = re.compile(
    r"^static const (float|uint32_t) (\w+)\[(\w+)\](?:\[\w+\])? = \{\n(.*?)^\};", re.MULTILINE | re.DOTALL
)
_UNIT: Final = re.compile(r"\[([^\[\]]+)\]")
_ADDRESS_BITS: Final = 32


@dataclass(frozen=True)
class Entry:
    """A MEASUREMENT or a CHARACTERISTIC. address: of its first word; count: words; axis: values of its index [um]."""

    name: str
    about: str
    type: str
    unit: str
    address: int
    count: int
    low: float
    high: float
    axis: tuple[float, ...] = ()
    mask: str = ""

    @property
    def asap(self) -> str:
        return "FLOAT32_IEEE" if self.type == "float" else "ULONG"

    @property
    def conversion(self) -> str:
        """Name of the COMPU_METHOD."""
        return f"CM_{self.asap}_{re.sub(r'[^A-Za-z0-9]+', '_', self.unit) or 'none'}"


@dataclass(frozen=True)
class Description:
    """All entries of an A2L file, and the ELF that the addresses are of."""

    characteristics: tuple[Entry, ...]
    measurements: tuple[Entry, ...]
    byte_order: str

    @property
    def methods(self) -> list[Entry]:
        """One entry per numeric COMPU_METHOD."""
        both = (*self.characteristics, *self.measurements)
        return list({entry.conversion: entry for entry in both}.values())


@dataclass(frozen=True)
class Elf:
    """Symbols of a linked ELF: name -> (address, bytes)."""

    symbols: Mapping[str, tuple[int, int]]
    little_endian: bool


def read_elf(path: Path) -> Elf:
    """The data symbols of an ELF. Raises BuildError if pyelftools is missing or the file is no linked ELF."""
    try:
        from elftools.common.exceptions import ELFError
        from elftools.elf.elffile import ELFFile
        from elftools.elf.sections import SymbolTableSection
    except ImportError as fault:
        raise BuildError("pyelftools is not installed: pip install 'hysgen[export]'") from fault
    try:
        with path.open("rb") as stream:
            elf = ELFFile(stream)
            table = elf.get_section_by_name(".symtab")
            if not isinstance(table, SymbolTableSection):
                raise BuildError(f"{path}: has no symbol table; link it without stripping")
            symbols = {
                symbol.name: (int(symbol["st_value"]), int(symbol["st_size"]))
                for symbol in table.iter_symbols()
                if symbol["st_info"]["type"] == "STT_OBJECT"
            }
            return Elf(symbols, bool(elf.little_endian))
    except (OSError, ELFError) as fault:
        raise BuildError(f"{path}: is no ELF file that can be read ({fault})") from fault


def describe(
    model: Model, interface: Interface, params: str, elf: Elf, instance: str, learner: str | None
) -> Description:
    """Every word of the instance, the learner and the tables of `<name>_params.h` at its address in `elf`.

    instance, learner: names of the variables of the types `<name>_t` and `<name>_learner_t`; learner None: none.
    Raises BuildError if a variable or a table is not in the ELF, has another size, or lies above 4 GiB.
    """
    name = model.name
    centres = tuple(float(c) for c in model.grid.centres_um)
    characteristics = list(_tables(name, params, elf, centres))
    box = {path: (interval.low, interval.high) for path, interval in instance_box(model).items()}
    measurements: list[Entry] = []
    pairs = [(instance, interface.struct(f"{name}_t"), box)]
    if learner is not None:
        pairs.append((learner, interface.struct(f"{name}_learner_t"), {}))
    for variable, struct, limits in pairs:
        base = _placed(elf, variable, struct.bytes)
        for entry in _members(struct, variable, base, limits, centres):
            (characteristics if f"{variable}.bank" in entry.name else measurements).append(entry)
            if entry.name == f"{variable}.status":
                measurements += _bits(entry, MEANINGS if variable == instance else LEARNER_MEANINGS)
    return Description(tuple(characteristics), tuple(measurements), "MSB_LAST" if elf.little_endian else "MSB_FIRST")


def _bits(word: Entry, meanings: Mapping[Any, str]) -> Iterator[Entry]:
    """One measurement of 0 or 1 for every bit of a status word."""
    for flag, meaning in meanings.items():
        yield replace(word, name=f"{word.name}.{flag.name}", about=meaning, high=1.0, mask=f"0x{int(flag):X}")


def _placed(elf: Elf, symbol: str, size: int) -> int:
    if symbol not in elf.symbols:
        raise BuildError(f"{symbol}: the ELF has no such variable; name it with --instance, or link it")
    address, found = elf.symbols[symbol]
    if found != size:
        raise BuildError(f"{symbol}: has {found} bytes in the ELF, {size} in the model; link the model's present C")
    if address + size > 1 << _ADDRESS_BITS:
        raise BuildError(f"{symbol}: lies at {address:#x}, beyond the 32 bits of an A2L address; link with -no-pie")
    return address


def _tables(name: str, params: str, elf: Elf, centres: tuple[float, ...]) -> Iterator[Entry]:
    """The tables of constants: parts 2 of `<name>_params.h`."""
    text = params.partition(f"#ifdef {name.upper()}_SELFTEST_NUMBERS")[0]
    for kind, symbol, _, body in _TABLE.findall(text):
        count = len(re.findall(r"^\s+\S+,", body, re.MULTILINE))
        address = _placed(elf, symbol, BYTES_PER_WORD * count)
        low, high = (-LARGEST, LARGEST) if kind == "float" else (0.0, LARGEST_WORD)
        axis = centres if count == len(centres) else ()
        yield Entry(symbol, f"table of {name}_params.h", kind, "", address, count, low, high, axis)


def _members(
    struct: Struct, path: str, address: int, box: Mapping[str, tuple[float, float]], centres: tuple[float, ...]
) -> Iterator[Entry]:
    for member in struct.members:
        for place, (name, kind) in enumerate(_elements(member)):
            own = f"{path}.{name}"
            if isinstance(kind, Struct):
                yield from _members(kind, own, address + place * kind.bytes, box, centres)
        if not isinstance(member.type, Struct):
            yield _scalar(member, path, address, box, centres)
        address += BYTES_PER_WORD * sum(1 for _ in member.words())


def _elements(member: Member) -> Iterator[tuple[str, Any]]:
    for place in np.ndindex(*member.sizes):
        yield member.name + "".join(f"[{i}]" for i in place), member.type


def _scalar(
    member: Member, path: str, address: int, box: Mapping[str, tuple[float, float]], centres: tuple[float, ...]
) -> Entry:
    unit = _UNIT.search(member.meaning)
    count = sum(1 for _ in member.words())
    inside = path.partition(".")[2]
    own = f"{inside}.{member.name}" if inside else member.name
    known = [interval for word, interval in box.items() if word == own or word.startswith(f"{own}[")]
    if member.type == "float":
        low = min((a for a, _ in known), default=-LARGEST)
        high = max((b for _, b in known), default=LARGEST)
    else:
        low, high = 0.0, LARGEST_WORD
    axis = centres if ".bank[" in f".{inside}" and count == len(centres) else ()
    return Entry(
        f"{path}.{member.name}", member.meaning, str(member.type), unit[1] if unit else "", address, count, low, high,
        axis,
    )  # fmt: skip
