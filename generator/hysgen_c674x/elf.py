"""Reading a linked C674x program: its memory sections and symbols."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass

from hysgen.errors import TargetError

_EM_TI_C6000 = 140
_SHT_SYMTAB, _SHT_NOBITS = 2, 8
_SHF_WRITE, _SHF_ALLOC = 1, 2
_STT_FUNC = 2


@dataclass(frozen=True)
class MemorySection:
    """`size` bytes of target memory at `address`: `content`, then zeros."""

    name: str
    address: int
    size: int
    content: bytes
    writable: bool


@dataclass(frozen=True)
class Symbol:
    """A named address of `size` bytes; function: whether it is a function."""

    name: str
    address: int
    size: int
    function: bool


@dataclass(frozen=True)
class ProgramImage:
    """The memory image of a linked program."""

    sections: tuple[MemorySection, ...]
    symbols: Mapping[str, Symbol]

    def symbol(self, name: str) -> Symbol:
        """The symbol of that name. Raises TargetError if the program has none."""
        if name not in self.symbols:
            raise TargetError(f"{name}: no such symbol in the program; a static function, or a misspelt name?")
        return self.symbols[name]


def read(data: bytes) -> ProgramImage:
    """Loadable sections and named symbols of a linked ELF file.

    Raises TargetError if `data` is not a little-endian 32-bit ELF file for the C6000.
    Source: System V ABI, chapters 4 and 5; C6000 EABI (SPRAB89), chapter 14.
    """
    if data[:6] != b"\x7fELF\x01\x01":
        raise TargetError("not a little-endian 32-bit ELF file; build the program with hysgen_c674x.toolchain")
    (machine,) = struct.unpack_from("<H", data, 18)
    if machine != _EM_TI_C6000:
        raise TargetError(f"ELF machine {machine} is not the C6000 ({_EM_TI_C6000}); was the host's compiler used?")
    (table,) = struct.unpack_from("<I", data, 32)
    entry_size, count, names_index = struct.unpack_from("<HHH", data, 46)
    headers = [struct.unpack_from("<10I", data, table + entry_size * i) for i in range(count)]
    names_at = headers[names_index][4]

    sections = []
    symbols: dict[str, Symbol] = {}
    for name_at, kind, flags, address, offset, size, link, *_ in headers:
        if flags & _SHF_ALLOC and size:
            content = b"" if kind == _SHT_NOBITS else data[offset : offset + size]
            name = _text(data, names_at + name_at)
            sections.append(MemorySection(name, address, size, content, bool(flags & _SHF_WRITE)))
        if kind == _SHT_SYMTAB:
            for at in range(offset, offset + size, 16):
                name_at, value, extent, info, _other, index = struct.unpack_from("<IIIBBH", data, at)
                name = _text(data, headers[link][4] + name_at)
                if name and index:
                    symbols[name] = Symbol(name, value, extent, info & 15 == _STT_FUNC)
    return ProgramImage(tuple(sections), symbols)


def _text(data: bytes, at: int) -> str:
    return data[at : data.index(b"\0", at)].decode("ascii")
