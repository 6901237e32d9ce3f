"""The firmware for the C6748, compiled and linked by its gcc: sections, memories, bytes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from hysgen.firmware.binding import CONTROLLER, TARGET_BOARD, Sources, read_sources
from hysgen_c674x import toolchain
from hysgen_c674x.footprint import c_texts
from hysgen_c674x.toolchain import Firmware

MEMORIES: Final = {"L2 RAM": (0x11800000, 256 * 1024), "shared RAM": (0x80000000, 128 * 1024)}
"""Memories of the C6748 by name: first address, bytes."""


@dataclass(frozen=True)
class PlacedSection:
    """A section of the linked image: address, bytes, and the memory that holds it."""

    name: str
    address: int
    size: int
    memory: str


@dataclass(frozen=True)
class LinkedImage:
    """A linked image: its sections, and bytes of code by function."""

    model: str
    compiler: str
    firmware: Firmware
    sections: tuple[PlacedSection, ...]
    functions: Mapping[str, int]

    @property
    def used(self) -> dict[str, int]:
        """Bytes in use by memory."""
        total = dict.fromkeys(MEMORIES, 0)
        for section in self.sections:
            total[section.memory] += section.size
        return total

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "model": self.model,
            "compiler": self.compiler,
            "sections": [vars(section) for section in self.sections],
            "used": self.used,
            "functions": dict(self.functions),
        }


def link_image(name: str, texts: Mapping[str, str]) -> LinkedImage:
    """Compile controller, model and the C6748's board, warnings as errors, and link with the firmware's own script.

    texts: generated C and model.h by file name. Raises BuildError if there is no compiler or it reports an error.
    """
    sources = [*read_sources(CONTROLLER), *read_sources(TARGET_BOARD, "*.[chs]"), *c_texts(texts)]
    firmware = compile_placed(sources)
    sections = tuple(
        PlacedSection(each.name, each.address, each.size, _memory(each.address))
        for each in firmware.image.sections
        if each.size and each.address
    )
    functions = {s.name: s.size for s in firmware.image.symbols.values() if s.function and not s.name.startswith("__")}
    return LinkedImage(name, toolchain.version(), firmware, sections, functions)


def compile_placed(sources: Sources) -> Firmware:
    """Compile for the target and link by the firmware's script, which puts what runs in every period together.

    The settings and the key of the example count as filled in: nothing but the simulator runs the image.

    Raises BuildError as `toolchain.compile`.
    """
    script = dict(read_sources(TARGET_BOARD, "*.ld"))["c6748.ld"]
    return toolchain.compile(sources, ("-ffunction-sections", "-DMAIN_FILLED_IN"), script)


def _memory(address: int) -> str:
    return next(name for name, (start, size) in MEMORIES.items() if start <= address < start + size)
