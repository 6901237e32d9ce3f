"""The kernels as files: the same code by TI's assembler, and part of the library for the C674x by CMake."""

import json
import re
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.c674x_kernels import scheduled_model, scheduled_texts
from fixtures.tools import need
from hysgen.codegen import generate
from hysgen.codegen.manifest import MANIFEST, write
from hysgen.errors import TargetError
from hysgen.machine.files import digest
from hysgen_c674x import toolchain
from hysgen_c674x.schedule.folder import ti_text, with_ti_assembly

FILE = "appendix_a_c674x"


def gnu_directives(text: str) -> str:
    """TI's text with the directives of the GNU assembler; its instructions as they are."""
    text = re.sub(r"\.align (\d+)", lambda found: f".balign {found[1]}", text)
    text = re.sub(r'\.sect "\.text:(\w+)"', r'.section .text.\1, "ax"', text).replace(
        '.sect ".const"', ".section .rodata"
    )
    return re.sub(r"\t\.(end)?asmfunc", "", text)


def code(text: str) -> dict[tuple[str, int], bytes]:
    """Code and constants of the program that consists of one assembly file, by section and address."""
    sections = toolchain.compile([(f"{FILE}.s", text)]).image.sections
    return {(each.name, each.address): each.content for each in sections}


def test_instructions_in_tis_syntax_are_the_same_code() -> None:
    need_compiler()
    gnu = scheduled_texts("appendix_a")[f"{FILE}.s"]
    ti = ti_text(gnu)
    assert code(gnu_directives(ti)) == code(gnu)
    wrong = re.sub(r"ADDSP", "SUBSP", ti, count=1)
    assert code(gnu_directives(wrong)) != code(gnu)


def test_every_function_is_framed_by_tis_directives() -> None:
    ti = ti_text(scheduled_texts("appendix_a")[f"{FILE}.s"])
    functions = re.findall(r"\.global (\w+)", ti)
    assert functions
    assert re.findall(r"^(\w+):\t\.asmfunc$", ti, re.MULTILINE) == functions
    assert ti.count(".endasmfunc") == len(functions)
    assert set(re.findall(r"^\s+(\.\w+)", ti, re.MULTILINE)) <= {".sect", ".global", ".align", ".word", ".endasmfunc"}


def test_the_manifest_lists_the_file() -> None:
    folder = with_ti_assembly("appendix_a", scheduled_texts("appendix_a"))
    assert json.loads(folder[MANIFEST])["files"][f"{FILE}.asm"] == digest(folder[f"{FILE}.asm"].encode())


def test_an_unknown_directive_is_refused() -> None:
    with pytest.raises(TargetError, match=r"\.nocmp has no counterpart"):
        ti_text("\t.nocmp\n")


def defined_in(folder: Path, texts: Mapping[str, str], *options: str) -> str:
    """The object of the library that defines the prediction."""
    need("cmake")
    write(dict(texts), folder)
    subprocess.run(["cmake", "-S", folder, "-B", folder / "build", *options], check=True, capture_output=True)
    command = ["cmake", "--build", folder / "build", "--target", "appendix_a"]
    subprocess.run(command, check=True, capture_output=True)
    nm = toolchain.folder() / "bin" / "tic6x-elf-nm" if options else "nm"
    listing = subprocess.run([nm, "-A", folder / "build/libappendix_a.a"], check=True, capture_output=True, text=True)
    (line,) = [line for line in listing.stdout.splitlines() if line.endswith(" T appendix_a_predict")]
    return line.split(":")[1]


@pytest.mark.slow
def test_the_kernels_are_part_of_the_library_on_the_c674x_only(tmp_path: Path) -> None:
    need_compiler()
    texts = scheduled_texts("appendix_a")
    cross = (
        "-DCMAKE_SYSTEM_NAME=Generic",
        f"-DCMAKE_C_COMPILER={toolchain.folder() / 'bin' / 'tic6x-elf-gcc'}",
        "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY",
        "-DCMAKE_C_FLAGS=-march=c674x -ffreestanding",
    )
    assert defined_in(tmp_path / "target", texts, *cross).startswith("appendix_a_c674x.s")
    assert defined_in(tmp_path / "host", texts).startswith("appendix_a.c")
    # Without kernels the C is compiled there, by a compiler that refuses -fPIC.
    plain = generate(scheduled_model("appendix_a"))
    assert defined_in(tmp_path / "plain", plain, *cross).startswith("appendix_a.c")
