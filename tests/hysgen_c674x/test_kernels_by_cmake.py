"""The generated project with kernels: CMake takes them into the library for the C674x, and only there."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.c674x_kernels import scheduled_model, scheduled_texts
from fixtures.tools import need
from hysgen.codegen import generate, write
from hysgen_c674x import toolchain


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
