"""What the generated C of a model takes on the C674x: cycles, code and stack of each function, bytes of data."""

from __future__ import annotations

from collections.abc import Mapping

from hysgen.c674x import toolchain
from hysgen.c674x.generated import c_texts, cycles_of
from hysgen.codegen.operations import figures


def footprint(name: str, texts: Mapping[str, str]) -> dict[str, dict[str, int]]:
    """Function without the model's name -> worst cycles, bytes of its own code, most stack with all that it calls.

    "data" holds the bytes of the public structs and of the constant tables, "all" the bytes of the program's code.
    Raises BuildError without the toolchain, TargetError if cycles or stack cannot be bounded.
    """
    firmware = toolchain.compile([(file, text) for file, text in c_texts(texts) if "selftest" not in file])
    counted = figures(name, texts)
    taken: dict[str, dict[str, int]] = {}
    for function, bound in cycles_of(name, texts, firmware).items():
        taken[function] = {
            "cycles": bound.worst,
            "code_bytes": firmware.function_bytes(f"{name}_{function}"),
            "stack_bytes": bound.stack_bytes,
        }
    taken["all"] = {"code_bytes": firmware.section_bytes[".text"]}
    taken["data"] = {"struct_bytes": sum(counted.struct_bytes.values()), "constant_bytes": counted.constant_bytes}
    return taken
