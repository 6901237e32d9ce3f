"""ASAP2 1.7 (A2L): every parameter and state of the generated C with unit, limits, axis, and address in a linked ELF.

Names, units and axes are those of the structs and tables that the generated C is rendered from. Limits of states and
banks are the boxes of the proof (`hysgen.checking.proof.eva`): intervals that no call leaves.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from hysgen.checking.proof.eva.boxes import learner_box, parts_box, state_box
from hysgen.codegen import tables
from hysgen.codegen.parameters import Table, numbers_digest_of
from hysgen.codegen.structs import Interface, interface
from hysgen.errors import BuildError
from hysgen.export.base import Export, Option, Written, make
from hysgen.float32.learner_numbers import bank_box
from hysgen.float32.struct_words import LearnerStatus
from hysgen.machine.files import write_whole
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
from hysgen.model.structs import BYTES_PER_WORD, Axis, Member, Status, Struct

LARGEST: Final = 3.4028234663852886e38
"""Limit of a float32 for which no interval is proved."""

LARGEST_WORD: Final = 4294967295.0

_ADDRESS_BITS: Final = 32

README: Final = """\
{{ name }}.a2l (ASAP2 1.7) describes every word of an instance{{ ", of a learner" if learns }} and of the tables of
constants: unit, limits, conversion, axis, and its address in {{ elf }}. Limits of the instance's states are intervals
that no call leaves (`hysgen prove`){{ ", those of the learner the range of a float" if learns }};
{{ description.characteristics | length }} parameters, {{ description.measurements | length }} measurements.

    make run                                                                # link and run the example program
    hysgen export MODEL --to a2l --elf firmware.elf --instance NAME -o DIR  # addresses of your own firmware

The banks in the instance can be written while the model runs: write the idle bank, then `active`. The tables are
read-only. A 32-bit A2L address does not reach a position-independent program of a 64-bit machine: link with -no-pie.
"""


@dataclass(frozen=True)
class Entry:
    """A MEASUREMENT or a CHARACTERISTIC.

    address: of its first word; count: words. writable: whether a calibration tool may write it.
    """

    name: str
    about: str
    type: str
    unit: str
    address: int
    count: int
    low: float
    high: float
    axis: Axis | None = None
    mask: str = ""
    writable: bool = False

    @property
    def asap(self) -> str:
        return "FLOAT32_IEEE" if self.type == "float" else "ULONG"

    @property
    def conversion(self) -> str:
        """Name of the COMPU_METHOD."""
        return _conversion(self.asap, self.unit)

    @property
    def axis_conversion(self) -> str:
        """Name of the COMPU_METHOD of the axis."""
        return _conversion("FLOAT32_IEEE", self.axis.unit) if self.axis else ""


def _conversion(asap: str, unit: str) -> str:
    """Name of the COMPU_METHOD of a type and a unit."""
    return f"CM_{asap}_{''.join(c if c.isalnum() else '_' for c in unit) or 'none'}"


@dataclass(frozen=True)
class Method:
    """A COMPU_METHOD: the physical value is the value; type: ASAP2 type of the words."""

    name: str
    type: str
    unit: str


@dataclass(frozen=True)
class Description:
    """All entries of an A2L file, and the ELF that the addresses are of."""

    characteristics: tuple[Entry, ...]
    measurements: tuple[Entry, ...]
    byte_order: str

    @property
    def methods(self) -> list[Method]:
        """Every COMPU_METHOD that an entry or an axis names, once."""
        both = (*self.characteristics, *self.measurements)
        methods = [Method(entry.conversion, entry.asap, entry.unit) for entry in both]
        methods += [Method(entry.axis_conversion, "FLOAT32_IEEE", entry.axis.unit) for entry in both if entry.axis]
        return list({method.name: method for method in methods}.values())


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
    model: Model, interface: Interface, tables: Sequence[Table], elf: Elf, instance: str, learner: str | None
) -> Description:
    """Every word of the instance, the learner and the tables of `<name>_params.h` at its address in `elf`.

    tables: those of `hysgen.codegen.tables`. instance, learner: names of the variables of the types `<name>_t` and
    `<name>_learner_t`; learner None: none.
    Raises BuildError if a variable or a table is not in the ELF, has another size, or lies above 4 GiB.
    """
    name = model.name
    entries = list(
        _members(
            interface.struct(f"{name}_t"),
            Place(instance, _placed(elf, instance, interface.struct(f"{name}_t").bytes)),
            Limits.of_instance(model),
            f"{name}_bank_t",
        )
    )
    status: list[tuple[str, type[Status | LearnerStatus]]] = [(instance, Status)]
    if learner is not None:
        struct = interface.struct(f"{name}_learner_t")
        entries += _members(struct, Place(learner, _placed(elf, learner, struct.bytes)), Limits.of_learner(model))
        status.append((learner, LearnerStatus))
    words = {entry.name: entry for entry in entries}
    bits = [bit for variable, flags in status for bit in _bits(words[f"{variable}.status"], flags)]
    return Description(
        characteristics=(
            *(_table(name, table, elf) for table in tables),
            *(entry for entry in entries if entry.writable),
        ),
        measurements=(*(entry for entry in entries if not entry.writable), *bits),
        byte_order="MSB_LAST" if elf.little_endian else "MSB_FIRST",
    )


@dataclass(frozen=True)
class Limits:
    """Intervals that no call leaves, by C path in the struct: floats; largest values of integers."""

    floats: Mapping[str, Interval]
    integers: Mapping[str, int]

    @classmethod
    def of_instance(cls, model: Model) -> Limits:
        """With the parameters that a learner may commit; parameters that are not learned have no limits."""
        banks = bank_box(model) if model.learner else {}
        learned = {path: interval for path, interval in banks.items() if interval.width > 0.0}
        floats = {f"bank[{b}].{path}": interval for b in range(2) for path, interval in learned.items()}
        return cls({**state_box(model), **floats}, {**parts_box(model).integers, "active": 1})

    @classmethod
    def of_learner(cls, model: Model) -> Limits:
        """Of a model with a learner; its covariance has none."""
        box = learner_box(model)
        return cls(box.floats, box.integers)

    def of(self, path: str, member: Member) -> tuple[float, float]:
        """The hull over all elements of a member with scalars; the range of its type where an element has none."""
        paths = [word.path for word in member.words(path)]
        if member.type == "float":
            known = [self.floats[word] for word in paths if word in self.floats]
            whole = len(known) == len(paths)
            return (min(i.low for i in known), max(i.high for i in known)) if whole else (-LARGEST, LARGEST)
        return 0.0, max(float(self.integers.get(word, LARGEST_WORD)) for word in paths)


@dataclass(frozen=True)
class Place:
    """A struct in memory. variable: C name; path: of the struct in the variable, with its dot."""

    variable: str
    address: int
    path: str = ""


def _bits(word: Entry, flags: Iterable[Status | LearnerStatus]) -> Iterator[Entry]:
    """One measurement of 0 or 1 for every bit of a status word."""
    for flag in flags:
        yield replace(word, name=f"{word.name}.{flag.name}", about=flag.meaning, high=1.0, mask=f"0x{int(flag):X}")


def _placed(elf: Elf, symbol: str, size: int) -> int:
    if symbol not in elf.symbols:
        raise BuildError(f"{symbol}: the ELF has no such variable; name it with --instance, or link it")
    address, linked = elf.symbols[symbol]
    if linked != size:
        raise BuildError(f"{symbol}: has {linked} bytes in the ELF, {size} in the model; link the model's present C")
    if address + size > 1 << _ADDRESS_BITS:
        raise BuildError(f"{symbol}: lies at {address:#x}, beyond the 32 bits of an A2L address; link with -no-pie")
    return address


def _table(model: str, table: Table, elf: Elf) -> Entry:
    """A table of constants, whose limits are its least and its largest number."""
    symbol, count = f"{model}_{table.name}", len(table.values)
    address = _placed(elf, symbol, BYTES_PER_WORD * count)
    low, high = float(table.values.min()), float(table.values.max())
    if low == high:
        low, high = min(low, 0.0), max(high, 0.0) or 1.0
    about = table.about
    return Entry(symbol, about.meaning, table.type, about.unit, address, count, low, high, table.axis)


def _members(struct: Struct, place: Place, limits: Limits, parameters: str = "") -> Iterator[Entry]:
    """One entry for every scalar and array of scalars; parameters: type of the structs that a tool may write."""
    address = place.address
    for member in struct.members:
        path = f"{place.path}{member.name}"
        if isinstance(member.type, Struct):
            for index in itertools.product(*(range(size) for size in member.sizes)):
                inner = Place(place.variable, address, path + "".join(f"[{i}]" for i in index) + ".")
                yield from _members(member.type, inner, limits, parameters)
                address += member.type.bytes
            continue
        count = sum(1 for _ in member.words())
        low, high = limits.of(place.path, member)
        yield Entry(
            f"{place.variable}.{path}", member.meaning, member.type, member.unit, address, count, low, high,
            member.axis, writable=struct.name == parameters,
        )  # fmt: skip
        address += BYTES_PER_WORD * count


def finish(written: Written) -> list[str]:
    """Write the A2L file and the README, with the addresses of the ELF; without --elf, of the example, linked here.

    Raises BuildError where a compiler is missing or the ELF does not fit the model.
    """
    draft, given, name = written.draft, written.given, written.draft.model.name
    elf = Path(given["elf"] or written.folder / f"{name}.elf")
    if not given["elf"]:
        make(written.folder, elf.name)
    linked = read_elf(elf)
    learner = given["learner"] or f"{name}_learner"
    has_learner = bool(draft.model.learner) and bool(given["learner"] or not given["elf"] or learner in linked.symbols)
    described = describe(
        draft.model,
        interface(draft.model, inverse=draft.options.inverse),
        tables(draft.model),
        linked,
        given["instance"] or f"{name}_instance",
        learner if has_learner else None,
    )
    digest = numbers_digest_of(draft.generated[f"{name}_params.h"])
    full = replace(draft, facts={**draft.facts, "description": described, "digest": digest, "elf": elf.name})
    texts = {f"{name}.a2l": full.text("a2l"), "README.md": full.readme(README)}
    texts = {path: draft.model.quantities.text(text) for path, text in texts.items()}
    for path, text in texts.items():
        write_whole(written.folder / path, text)
    return list(texts)


EXPORT = Export(
    "a2l",
    "A2L description for XCP",
    files={"{name}_ecu.c": "a2l_ecu.c", "Makefile": "a2l_Makefile"},
    sources=lambda draft: {},
    options_title="addresses of an A2L file",
    options=(
        Option("elf", "FILE", "linked program (default: the example in the folder)"),
        Option("instance", "NAME", "its variable of type <model>_t"),
        Option("learner", "NAME", "its variable of type <model>_learner_t"),
    ),
    finish=finish,
)
