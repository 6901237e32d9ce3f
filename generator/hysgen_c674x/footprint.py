"""Resources of the generated C of a model on the C674x: cycles, code and stack of each function, bytes of data."""

from collections.abc import Mapping

from hysgen.codegen.manifest import c_files
from hysgen.codegen.operations import figures
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import CycleBounds, bounds


def c_texts(texts: Mapping[str, str]) -> list[tuple[str, str]]:
    """(file name, text) of what is compiled for the target among generated files: C, headers, and scheduled kernels."""
    return [*c_files(texts).items(), *((name, text) for name, text in texts.items() if name.endswith("_c674x.s"))]


def cycle_bounds(
    name: str, texts: Mapping[str, str], firmware: toolchain.Firmware | None = None
) -> dict[str, CycleBounds]:
    """Stall-free cycles of each public function, by its name without the model's.

    firmware: the compiled texts, if they are compiled already.
    Raises BuildError without the toolchain, TargetError if the cycles of a function cannot be bounded.
    """
    program = firmware or toolchain.compile(c_texts(texts))
    code = program.packets
    functions = figures(name, texts).operations
    return {function: bounds(program.image, code, f"{name}_{function}") for function in functions}


def footprint(name: str, texts: Mapping[str, str]) -> dict[str, dict[str, int]]:
    """Function without the model's name -> worst-case cycles, bytes of its own code, most stack including callees.

    "all" holds the bytes of the program's code, "data" the bytes of the public structs and of the constant tables. The
    self-test is left out.
    Raises BuildError without the toolchain, TargetError if cycles or stack cannot be bounded.
    """
    firmware = toolchain.compile([(file, text) for file, text in c_texts(texts) if "selftest" not in file])
    counted = figures(name, texts)
    taken: dict[str, dict[str, int]] = {}
    for function, bound in cycle_bounds(name, texts, firmware).items():
        taken[function] = {
            "cycles": bound.worst,
            "code_bytes": firmware.function_bytes(f"{name}_{function}"),
            "stack_bytes": bound.stack_bytes,
        }
    taken["all"] = {"code_bytes": firmware.section_bytes[".text"]}
    taken["data"] = {"struct_bytes": sum(counted.struct_bytes.values()), "constant_bytes": counted.constant_bytes}
    return taken
