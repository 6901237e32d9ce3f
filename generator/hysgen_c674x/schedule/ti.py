"""The assembly file of the kernels in the syntax of TI's assembler, from the text for the GNU assembler.

The instructions are the same, in capitals; symbols keep their case. The directives differ: .sect names a section,
.align counts bytes, and .asmfunc and .endasmfunc stand for .type and .size (TMS320C6000 Assembly Language Tools,
SPRUI03). TI's tools did not assemble the result; the GNU assembler makes the same code of its instructions.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Set
from typing import Final

from hysgen.codegen.manifest import MANIFEST
from hysgen.errors import TargetError
from hysgen.machine.files import digest
from hysgen_c674x.schedule.folder import assembly_file

_SECTION: Final = re.compile(r"\.section \.text\.(\w+), \"ax\"")
_GLOBAL: Final = re.compile(r"^\t\.global (\w+)$", re.MULTILINE)
_CONSTANT: Final = re.compile(r"(?P<before>.*\bmvk[lh] \S+ )(?P<symbol>[A-Za-z_]\w*)(?P<behind>, .*)")


def ti_file(name: str) -> str:
    """Name of the file in TI's syntax."""
    return f"{name}_c674x.asm"


def with_ti_assembly(name: str, texts: Mapping[str, str]) -> dict[str, str]:
    """The generated folder `texts`, which has kernels, with their file in TI's syntax, too; listed in its manifest."""
    text = ti_text(texts[assembly_file(name)].replace(assembly_file(name), ti_file(name)))
    facts = json.loads(texts[MANIFEST])
    facts["files"] = dict(sorted({**facts["files"], ti_file(name): digest(text.encode())}.items()))
    manifest = json.dumps(facts, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return dict(texts) | {ti_file(name): text, MANIFEST: manifest}


def ti_text(gnu: str) -> str:
    """The text of `emit.file_text` in TI's syntax. Raises TargetError for a directive without a counterpart."""
    functions = set(_GLOBAL.findall(gnu))
    lines = (_line(each, functions) for each in gnu.splitlines())
    return "".join(f"{line}\n" for line in lines if line is not None)


def _line(line: str, functions: Set[str]) -> str | None:
    """One line; None for .type, whose place .asmfunc behind the label takes."""
    text = line.strip()
    if not text or text.startswith(";"):
        return line
    if text.endswith(":"):
        return f"{text}\t.asmfunc" if text[:-1] in functions else text
    if not text.startswith("."):
        return _instruction(line)
    if text == ".section .rodata":
        return '\t.sect ".const"'
    section = _SECTION.fullmatch(text)
    if section is not None:
        return f'\t.sect ".text:{section[1]}"'
    directive, _, operand = text.partition(" ")
    match directive:
        case ".global" | ".word":
            return line
        case ".align":
            return f"\t.align {1 << int(operand)}"
        case ".type":
            return None
        case ".size":
            return "\t.endasmfunc"
    raise TargetError(f"assembly: directive {directive} has no counterpart in TI's syntax")


def _instruction(line: str) -> str:
    constant = _CONSTANT.fullmatch(line)
    if constant is not None:
        return constant["before"].upper() + constant["symbol"] + constant["behind"].upper()
    return re.sub(r"\b0X", "0x", line.upper())
