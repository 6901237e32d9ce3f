"""A generated folder is a project: CMake builds and runs it, C++ calls it, digests and layouts are checked."""

import functools
import hashlib
import re
import struct
import subprocess
from pathlib import Path

import pytest

from fixtures.generated_models import everything, learning
from fixtures.tools import need
from hysgen.codegen import generate
from hysgen.codegen.manifest import read_folder, write
from hysgen.firmware import with_learner
from hysgen.model.file import load_model
from hysgen.model.model import Model

MODELS = {model.name: model for model in (learning(), everything(), with_learner(load_model("extended")))}


@functools.cache
def generated(name: str) -> dict[str, str]:
    """What the templates make of one of MODELS."""
    return generate(MODELS[name])


def run(folder: Path, *call: str) -> subprocess.CompletedProcess[str]:
    """A command in `folder`, and what it printed."""
    return subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_the_folder_builds_by_cmake_and_its_example_runs(tmp_path: Path) -> None:
    """Without a learner; the export of a CMake package runs an example that learns."""
    name = "everything"
    write(generated(name), tmp_path)
    assert built(tmp_path, "-DCMAKE_C_FLAGS=-Wall -Wextra -Werror") == ""
    example = run(tmp_path, f"build/{name}_example")
    assert example.returncode == 0
    assert "self-test: 0 mismatches" in example.stdout
    error = re.search(r"largest error (\S+) um, status 0x(?:0|40)\n", example.stdout)
    assert error is not None
    assert float(error[1]) < 1e-5
    assert run(tmp_path, "ctest", "--test-dir", "build").returncode == 0


@pytest.mark.slow
def test_the_project_fails_its_test_if_the_algorithm_has_a_wrong_bit(tmp_path: Path) -> None:
    texts = generated("learning")
    wrong = texts["learning.c"].replace("12582912.0f;", "12582914.0f;", 1)
    write(texts | {"learning.c": wrong}, tmp_path)
    assert built(tmp_path) == ""
    assert run(tmp_path, "ctest", "--test-dir", "build").returncode != 0


def built(folder: Path, *options: str) -> str:
    """What CMake complains about while it configures and builds the project in `folder`, "" if nothing."""
    need("cmake")
    configured = run(folder, "cmake", "-S", ".", "-B", "build", *options)
    return configured.stderr or run(folder, "cmake", "--build", "build").stderr


def test_cpp_calls_the_model_without_warnings(tmp_path: Path) -> None:
    need("g++", "gcc")
    write(generated("learning"), tmp_path)
    (tmp_path / "caller.cpp").write_text(
        '#include "learning.h"\n'
        'static_assert(LEARNING_PERIOD_NS == 20000u, "");\n'
        "int main() { learning_t self; learning_init(&self, LEARNING_Y_REST_UM, LEARNING_U_REST_V);\n"
        "    return learning_simulate(&self, LEARNING_U_MAX_V) > LEARNING_Y_MIN_UM ? 0 : 1; }\n"
    )
    made = run(tmp_path, "gcc", "-std=c99", "-O2", "-ffp-contract=off", "-c", "learning.c")
    flags = ("-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wold-style-cast", "-Werror")
    linked = run(tmp_path, "g++", *flags, "caller.cpp", "learning.o", "-o", "caller")
    assert (made.stderr, linked.stderr) == ("", "")
    assert run(tmp_path, "./caller").returncode == 0


@pytest.mark.parametrize(
    ("file", "flag", "complaint"),
    [
        ("caller.c", "-Dfloat=double", r"learning_float_size"),
        ("caller.c", "-DWIDE", r"learning_t_size"),
        ("learning.c", "-U__FLT_MANT_DIG__ -D__FLT_MANT_DIG__=16", r"#error .*32-bit format of IEEE 754"),
        ("learning.c", "-U__CHAR_BIT__ -D__CHAR_BIT__=16", r"#error .*bytes of 8 bits"),
    ],
)
def test_another_layout_does_not_compile(file: str, flag: str, complaint: str, tmp_path: Path) -> None:
    need("gcc")
    write(generated("learning"), tmp_path)
    (tmp_path / "caller.c").write_text(
        '#include <stdint.h>\n#ifdef WIDE\n#define uint32_t uint64_t\n#endif\n#include "learning.h"\n'
    )
    assert run(tmp_path, "gcc", "-std=c99", "-c", file).returncode == 0
    refused = run(tmp_path, "gcc", "-std=c99", *flag.split(), "-c", file)
    assert refused.returncode != 0
    assert re.search(complaint, refused.stderr)


@pytest.mark.parametrize("name", ["everything", "extended"])
@pytest.mark.slow
def test_section_macros_place_every_function_and_every_table(name: str, tmp_path: Path) -> None:
    """Without optimisation, so that no function is hidden by inlining."""
    need("gcc")
    write(generated(name), tmp_path)
    placed = [f'-D{name.upper()}_{macro}=__attribute__((section("{section}")))'
              for macro, section in (("CODE", ".fast_code"), ("TABLE", ".fast_table"))]  # fmt: skip
    for extra in ([], placed):
        for unit in (name, f"{name}_selftest"):
            flags = ("-std=c99", "-O0", "-Wall", "-Wextra", "-Werror")
            assert run(tmp_path, "gcc", *flags, *extra, "-c", f"{unit}.c").stderr == ""
            headers = run(tmp_path, "objdump", "-h", f"{unit}.o").stdout
            sizes = {name: int(size, 16) for name, size in re.findall(r"^ +\d+ (\S+) +([0-9a-f]{8})", headers, re.M)}
            own = sizes.get(".fast_code", 0), sizes.get(".fast_table", 0)
            assert all(own) == bool(extra)
            assert (sizes[".text"] == 0) == bool(extra), "a function without the macro"


@pytest.mark.slow
def test_digests_are_those_of_the_algorithm_and_of_the_numbers(tmp_path: Path) -> None:
    texts = generated("learning")
    write(texts, tmp_path)
    algorithm = re.search(r'LEARNING_ALGORITHM "(\w+)"', texts["learning.h"])
    assert algorithm is not None
    assert algorithm[1] == read_folder(tmp_path).facts["files"]["learning.c"]
    assert f"LEARNING_ALGORITHM_WORD 0x{algorithm[1][:8]}u" in texts["learning.h"]
    numbers = re.search(r'LEARNING_NUMBERS_DIGEST "(\w+)"', texts["learning_params.h"])
    assert numbers is not None
    assert numbers[1] == digest_of_numbers(texts["learning_params.h"])
    moved = generate(shifted(MODELS["learning"]))
    assert moved["learning.h"] == texts["learning.h"]
    assert numbers[1] not in moved["learning_params.h"]


def shifted(model: Model) -> Model:
    """The model with an input range that ends 1 V earlier."""
    return model.within(None, (model.u_min_V, model.u_max_V - 1.0))


def digest_of_numbers(text: str) -> str:
    """SHA-256 of the words in parts 1 and 2 of a params header: the bits of its floats and its unsigned numbers."""
    parts = re.sub(r"/\*.*?\*/", "", text.partition("_NUMBERS_WORD")[2].partition("\n")[2], flags=re.DOTALL)
    numbers = re.findall(r"(?<![\w.])(-?[\d.]+(?:e[-+]\d+)?)f\b|(?<![\w.])(0x[0-9a-f]{8})u\b", parts)
    words = [
        struct.pack("<f", float(number)) if number else struct.pack("<I", int(word, 16)) for number, word in numbers
    ]
    return hashlib.sha256(b"".join(words)).hexdigest()
