"""Generated folders with kernels: `<name>_c674x.s`, and in `<name>.c` the choice between the kernels and the C.

The kernels are read out of the portable C, so there is one description of every function. In the C, each function that
has a kernel is left out where the kernels are used:

    #if defined(_TMS320C6X) && !defined(<NAME>_PORTABLE)      the kernels
    otherwise                                                  the C, on every processor

`<name>_c674x.asm` is the same file in the syntax of TI's assembler: the instructions in capitals; symbols keep their
case. The directives differ: .sect names a section, .align counts bytes, and .asmfunc and .endasmfunc stand for .type
and .size (TMS320C6000 Assembly Language Tools, SPRUI03). TI's tools did not assemble the result; the GNU assembler
makes the same code of its instructions.

Assembly text of a schedule, in the syntax of the GNU assembler for the C6000.
"""

import json
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Final

from hysgen.checking.symbolic.from_c import kernel
from hysgen.checking.symbolic.source import KernelRefusalError, Source
from hysgen.codegen.manifest import CMAKE, MANIFEST
from hysgen.errors import TargetError
from hysgen.machine.files import digest
from hysgen_c674x.schedule.instructions import OutOfRegistersError, Placement, Schedule
from hysgen_c674x.schedule.plans import shortest

_MOST_IDLE = 9


def function_text(name: str, schedule: Schedule) -> str:
    """One function; its packets in order, empty cycles as a multi-cycle nop."""
    packets: dict[int, list[str]] = defaultdict(list)
    for placement in schedule.placements:
        packets[placement.cycle] += _instructions(placement)
    for each in schedule.frame:
        packets[each.cycle].append(each.text)
    packets[schedule.branch].append("b .s2 b3")
    lines = [f"\t.global {name}", f"\t.type {name}, @function", "\t.align 5", f"{name}:"]
    idle = 0
    for cycle in range(schedule.cycles):
        if not packets[cycle]:
            idle += 1
            continue
        lines += _idle(idle)
        idle = 0
        first, *others = packets[cycle]
        lines += [f"\t   {first}", *(f"\t|| {each}" for each in others)]
    lines += [*_idle(idle), f"\t.size {name}, .-{name}"]
    return "\n".join(lines) + "\n"


def code_bytes(schedule: Schedule) -> int:
    """Bytes of a function without padding: 4 for every instruction."""
    return 4 * sum(line.startswith(("\t   ", "\t|| ")) for line in function_text("", schedule).splitlines())


def table_text(name: str, words: tuple[int, ...]) -> str:
    """A table of constants."""
    rows = [", ".join(f"0x{word:08x}" for word in words[k : k + 6]) for k in range(0, len(words), 6)]
    return "\n".join(["\t.align 2", f"{name}:", *(f"\t.word {row}" for row in rows)]) + "\n"


def file_text(header: str, functions: Mapping[str, Schedule], tables: Mapping[str, tuple[int, ...]]) -> str:
    """The assembly file of several functions and their tables."""
    parts = [header]
    parts += [f'\t.section .text.{name}, "ax"\n{function_text(name, each)}\n' for name, each in functions.items()]
    if tables:
        parts += ["\t.section .rodata\n", *(table_text(name, words) for name, words in tables.items())]
    return "".join(parts)


def _idle(cycles: int) -> list[str]:
    lines = []
    while cycles > 0:
        here = min(cycles, _MOST_IDLE)
        lines.append(f"\t   nop {here}" if here > 1 else "\t   nop")
        cycles -= here
    return lines


def _register(register: tuple[int, int] | int) -> str:
    return str(register) if isinstance(register, int) else f"{'ab'[register[0]]}{register[1]}"


def _instructions(placement: Placement) -> list[str]:
    node = placement.node
    own = [_register(operand) for operand in placement.operands]
    result = _register((placement.data_side, placement.register)) if placement.register is not None else ""
    unit = f".{placement.unit.lower()}" + ("x" if placement.cross else "")
    match node.mnemonic:
        case "lddw":
            sign, words = ("-" if node.number < 0 else "+"), abs(node.number) // 8
            assert placement.register is not None
            high = _register((placement.data_side, placement.register + 1))
            return [f"lddw {unit}t{placement.data_side + 1} *{sign}{own[0]}[{words}], {high}:{result}"]
        case "stdw":
            sign, words = ("-" if node.number < 0 else "+"), abs(node.number) // 8
            even, odd = (operand for operand in placement.operands[1:] if not isinstance(operand, int))
            assert (even[0], even[1] + 1) == odd, "a 64-bit store takes neighbouring registers"
            guard = f"[{_register(placement.guard)}] " if placement.guard else ""
            return [f"{guard}stdw {unit}t{placement.data_side + 1} {own[2]}:{own[1]}, *{sign}{own[0]}[{words}]"]
        case "ldw" | "stw":
            sign, words = ("-" if node.number < 0 else "+"), abs(node.number) // 4
            path = f"{unit}t{placement.data_side + 1}"
            where = f"*{sign}{own[0]}[{words}]"
            if node.mnemonic == "ldw":
                return [f"ldw {path} {where}, {result}"]
            guard = f"[{_register(placement.guard)}] " if placement.guard else ""
            return [f"{guard}stw {path} {own[1]}, {where}"]
        case "select":
            assert placement.guard is not None
            return [
                f"[{'!' if when_zero else ''}{_register(placement.guard)}] "
                f"{'mvk' if isinstance(operand, int) else 'mv'} .{name.lower()}{'x' if cross else ''} "
                f"{_register(operand)}, {result}"
                for name, when_zero, operand, cross in placement.moves
            ]
        case "mvk":
            return [f"mvk {unit} {node.number}, {result}"]
        case "mvkl" | "mvkh":
            return [f"{node.mnemonic} {unit} {node.symbol or hex(node.number)}, {result}"]
    return [f"{node.mnemonic} {unit} {', '.join([*own, result])}"]


FUNCTIONS: Final = (
    "predict",
    "simulate",
    "inverse",
    "snapshot",
    "learn",
    "evaluate_reading",
    "project",
    "update_diagonal",
    "factor",
    "step",
    "restart",
    "store_regressors",
)
"""Functions that become kernels if they can, without the model's prefix."""

PARTS_OF_LEARN: Final = FUNCTIONS[FUNCTIONS.index("learn") + 1 :]
"""Functions that only learn calls in a sample; they stay in C if learn is a kernel."""

LARGEST_TOGETHER: Final = 28 * 1024
"""Bytes of the kernels of inverse and learn, which run in every sample, of 32 KiB of program cache (SPRUFK5)."""


@dataclass(frozen=True)
class Kernels:
    """Schedules by function, named with the model's prefix; refused: why a function stays in C."""

    schedules: Mapping[str, Schedule]
    tables: Mapping[str, tuple[int, ...]]
    refused: Mapping[str, str]


def kernels(name: str, texts: Mapping[str, str], functions: Sequence[str] = FUNCTIONS) -> Kernels:
    """Schedules of the functions of model `name` in the portable C `texts`."""
    source = Source(name, texts)
    schedules: dict[str, Schedule] = {}
    tables: dict[str, Mapping[str, tuple[int, ...]]] = {}
    refused: dict[str, str] = {}
    for short in functions:
        function = f"{name}_{short}"
        if function not in source.functions or (short in PARTS_OF_LEARN and f"{name}_learn" in schedules):
            continue
        try:
            dataflow = kernel(source, function)
            schedules[function] = shortest(dataflow)
            tables[function] = dataflow.tables
        except (KernelRefusalError, OutOfRegistersError) as refusal:
            refused[function] = str(refusal)
    inverse, learn = f"{name}_inverse", f"{name}_learn"
    if {inverse, learn} <= set(schedules):
        together = code_bytes(schedules[inverse]) + code_bytes(schedules[learn])
        if together > LARGEST_TOGETHER:
            refused[inverse] = f"with learn {together} bytes of code, too many for the program cache"
            del schedules[inverse]
    used = {symbol: words for function in schedules for symbol, words in tables[function].items()}
    return Kernels(schedules, used, refused)


def assembly_file(name: str) -> str:
    """Name of the file of the kernels."""
    return f"{name}_c674x.s"


def with_kernels(name: str, texts: Mapping[str, str], found: Kernels) -> dict[str, str]:
    """The generated folder `texts` with the file of the kernels; its manifest lists them with their cycles.

    Raises TargetError if the learner in `texts` is not aligned (`Options.aligned`).
    """
    if f"}} {name}_learner_t;" in texts[f"{name}.h"]:
        raise TargetError(
            f"{name}.h: kernels load 64 bits of the learner at a time; generate with Options(aligned=True)"
        )
    source = texts[f"{name}.c"]
    for function in found.schedules:
        source = _left_out(name, source, function)
    changed = {
        f"{name}.c": _choice(name, source),
        assembly_file(name): file_text(_header(name, found), found.schedules, found.tables),
        CMAKE: _with_assembly(name, texts[CMAKE]),
    }
    facts = {
        "cycles": {function.removeprefix(f"{name}_"): each.cycles for function, each in found.schedules.items()},
        "in_c": {function.removeprefix(f"{name}_"): reason for function, reason in found.refused.items()},
    }
    return _listed(texts, changed, {"kernels": facts})


def _listed(texts: Mapping[str, str], changed: Mapping[str, str], further: Mapping[str, object]) -> dict[str, str]:
    """The folder with the files of `changed`, and its manifest with their digests and `further` facts."""
    facts = json.loads(texts[MANIFEST]) | further
    files = facts["files"] | {file: digest(text.encode()) for file, text in changed.items()}
    manifest = json.dumps(facts | {"files": dict(sorted(files.items()))}, indent=2, ensure_ascii=False, allow_nan=False)
    return {**texts, **changed, MANIFEST: manifest + "\n"}


def _choice(name: str, source: str) -> str:
    """The C with the definition of the macro behind its #include."""
    upper = name.upper()
    include = f'#include "{name}.h"\n'
    lines = [
        include,
        f"/* On the C674x the functions inside #ifndef {upper}_KERNELS stand in {assembly_file(name)}, scheduled for",
        f" * this processor and equal in every bit; with {upper}_PORTABLE defined they are compiled here. */",
        f"#if defined(_TMS320C6X) && !defined({upper}_PORTABLE)",
        f"#define {upper}_KERNELS",
        "#if defined(__GNUC__)",
        '#pragma GCC diagnostic ignored "-Wunused-function"',
        "#endif",
        "#endif",
    ]
    if source.count(include) != 1:
        raise TargetError(f"{name}.c: {include.strip()} is expected once")
    return source.replace(include, "\n".join(lines) + "\n")


def _with_assembly(name: str, project: str) -> str:
    """CMakeLists.txt with the file of the kernels in the library, under the same condition as in the C."""
    upper = name.upper()
    example = "\nif(CMAKE_SOURCE_DIR STREQUAL CMAKE_CURRENT_SOURCE_DIR)\n    add_executable("
    lines = [
        "",
        f"# The kernels, on the C674x only and without {upper}_PORTABLE, as in the C; this compiler has no -fPIC.",
        "include(CheckCSourceCompiles)",
        "set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)",
        "check_c_source_compiles(",
        f'    "#if !defined(_TMS320C6X) || defined({upper}_PORTABLE)\\n#error\\n#endif\\nint x;" {upper}_KERNELS)',
        f"if({upper}_KERNELS)",
        "    enable_language(ASM)",
        f"    target_sources({name} PRIVATE {assembly_file(name)})",
        f"    set_target_properties({name} PROPERTIES POSITION_INDEPENDENT_CODE OFF)",
        "endif()",
    ]
    if project.count(example) != 1:
        raise TargetError(f"{CMAKE}: the example is expected once")
    return project.replace(example, "\n".join(lines) + "\n" + example)


def _left_out(name: str, source: str, function: str) -> str:
    """The C with one function inside #ifndef; a static function is declared as an external one instead."""
    upper = name.upper()
    start = rf"^(?:{upper}_CODE\n(?P<static>static )?|{upper}_INLINE )"
    head_and_body = rf"(?P<head>[^;{{}}#]*?\b{function}\([^;{{}}]*?\))\n\{{.*?^\}}\n"
    pattern = re.compile(start + head_and_body, re.MULTILINE | re.DOTALL)
    found = list(pattern.finditer(source))
    if len(found) != 1:
        raise TargetError(f"{name}.c: the definition of {function} is expected once, found {len(found)} times")
    (match,) = found
    local = match["static"] or match[0].startswith(f"{upper}_INLINE")
    head = re.sub(rf"{upper}_ALONE ", "", match["head"])
    instead = f"#ifdef {upper}_KERNELS\nextern {head};\n#else\n" if local else f"#ifndef {upper}_KERNELS\n"
    return source[: match.start()] + instead + match[0] + "#endif\n" + source[match.end() :]


def _header(name: str, found: Kernels) -> str:
    rows = [f"; {function:<40} {each.cycles:>5} cycles" for function, each in found.schedules.items()]
    return "\n".join(
        [
            f"; {assembly_file(name)}: functions of {name}.c scheduled for the C674x, equal in every bit.",
            "; Interrupts may occur at every packet. Registers that a callee preserves are saved on the stack.",
            "; Stall-free cycles of a call, until the return takes effect:",
            *rows,
            "",
            "",
        ]
    )


_SECTION: Final = re.compile(r"\.section \.text\.(\w+), \"ax\"")
_GLOBAL: Final = re.compile(r"^\t\.global (\w+)$", re.MULTILINE)
_CONSTANT: Final = re.compile(r"(?P<before>.*\bmvk[lh] \S+ )(?P<symbol>[A-Za-z_]\w*)(?P<behind>, .*)")


def ti_file(name: str) -> str:
    """Name of the file in TI's syntax."""
    return f"{name}_c674x.asm"


def with_ti_assembly(name: str, texts: Mapping[str, str]) -> dict[str, str]:
    """The generated folder `texts`, which has kernels, with their file in TI's syntax, too; listed in its manifest."""
    text = ti_text(texts[assembly_file(name)].replace(assembly_file(name), ti_file(name)))
    return _listed(texts, {ti_file(name): text}, {})


def ti_text(gnu: str) -> str:
    """The text of `file_text` in TI's syntax. Raises TargetError for a directive without a counterpart."""
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
