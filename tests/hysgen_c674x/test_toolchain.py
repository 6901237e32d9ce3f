"""The compiler is found or its absence told, what it makes is measured, and its build leaves nothing half done."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fixtures.c674x_compiler import firmware, need_compiler
from fixtures.opcode_table import opcode_table
from fixtures.tools import missing
from hysgen.checking.proof.static import BASIC
from hysgen.errors import BuildError, TargetError
from hysgen_c674x import elf, toolchain

SCRIPT = Path(__file__).parents[2] / "firmware" / "toolchain" / "build_c674x.sh"


def build(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", str(SCRIPT), *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_missing_compiler_is_told_with_its_cure(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HYSGEN_C674X", str(tmp_path))
    with pytest.raises(BuildError, match=r"run firmware/toolchain/build_c674x\.sh") as said:
        toolchain.compile([("a.c", "")])
    assert "\n" not in str(said.value)


def test_a_compiler_made_elsewhere_lacks_only_the_opcode_table(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    need_compiler()
    (tmp_path / "bin").symlink_to(toolchain.folder() / "bin")
    monkeypatch.setenv("HYSGEN_C674X", str(tmp_path))
    assert "gcc" in toolchain.version()
    with pytest.raises(BuildError, match=r"tic6x-opcode-table\.h: missing"):
        opcode_table()


def test_the_compilers_complaint_is_one_line_with_file_and_row() -> None:
    need_compiler()
    with pytest.raises(BuildError, match=r"a\.c:2:\d+: error: .*undeclared") as refused:
        toolchain.compile([("a.c", "int f(void);\nint f(void) { return missing; }")])
    assert "\n" not in str(refused.value)
    with pytest.raises(BuildError, match="undefined reference to `missing'"):
        toolchain.compile([("a.c", "int missing(void); int f(void); int f(void) { return missing(); }")])


def test_sizes_are_those_of_the_program() -> None:
    need_compiler()
    text = (
        "const int table[6] = {1, 2, 3, 4, 5, 6}; int counter = 7; int room[100];int f(void); int f(void) { return 1; }"
    )
    program = toolchain.compile([("a.c", text)])
    sizes = program.section_bytes
    assert (sizes[".rodata"], sizes[".data"], sizes[".bss"]) == (24, 4, 400)
    assert 0 < program.function_bytes("f") <= sizes[".text"]
    assert [name for name, symbol in program.image.symbols.items() if symbol.function] == ["f"]
    machine = program.machine(interpreted=True)
    assert machine.read("table", 6, np.int32).tolist() == [1, 2, 3, 4, 5, 6]
    assert machine.read("counter", 1, np.int32).tolist() == [7]
    assert not machine.read("room", 100, np.int32).any()


def test_idle_cycles_that_encode_as_zeros_are_in_the_listing() -> None:
    need_compiler()
    text = 'void idle(void); void idle(void) { __asm__ volatile("nop 1\\n nop 1\\n nop 1\\n nop 1\\n nop 1"); }'
    program = toolchain.compile([("idle.c", text)])
    assert program.machine(interpreted=True).call("idle").cycles == 5 + 6


def test_the_same_texts_give_the_same_program(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    need_compiler()
    text = [("a.c", "float f(float x); float f(float x) { return x * x + 1.0f; }")]
    cached = toolchain.compile(text).elf
    monkeypatch.setenv("HYSGEN_CACHE", str(tmp_path))
    assert toolchain.compile(text).elf == cached
    assert toolchain.compile(text).elf == cached
    assert len(list(tmp_path.iterdir())) == 1


def test_a_header_that_changed_is_compiled_again() -> None:
    need_compiler()

    def value(number: int) -> int:
        unit = '#include "outer.h"\nint f(void); int f(void) { return VALUE; }'
        outer, inner = '#include "inner.h"\n', f"#define VALUE {number}\n"
        return toolchain.compile([("a.c", unit), ("outer.h", outer), ("inner.h", inner)]).machine(True).call("f").bits

    assert [value(1), value(2)] == [1, 2]


def test_the_firmware_is_built_with_the_flags_that_are_measured() -> None:
    makefile = (Path(__file__).parents[2] / "firmware" / "Makefile").read_text(encoding="utf-8")
    found = re.search(r"^FLAGS := ((?:.*\\\n)*.*)$", makefile, re.MULTILINE)
    assert found is not None
    assert sorted(found[1].replace("\\\n", " ").split()) == sorted((*toolchain.FLAGS, *BASIC))


def test_a_loop_that_copies_stays_a_loop() -> None:
    # The library's copy is a hardware loop, whose counter an interrupt would have to save.
    need_compiler()
    text = """
    typedef struct { float play[12]; } plays_t;
    void copy(plays_t *to, const plays_t *from);
    void assign(plays_t *to, const plays_t *from);
    void copy(plays_t *to, const plays_t *from) { for (int j = 0; j < 12; ++j) { to->play[j] = from->play[j]; } }
    """
    assign = "void assign(plays_t *to, const plays_t *from) { *to = *from; }\n"
    plain = toolchain.compile([("copy.c", text)])
    assert "sploop" not in plain.listing
    assert not [name for name in plain.image.symbols if name.startswith("__c6xabi")]
    assert "sploop" in toolchain.compile([("copy.c", text + assign)]).listing


def test_the_flags_keep_the_bits_and_the_bounds() -> None:
    # No fused, no reciprocal, no hardware loop: each would show in the listing.
    listing = firmware("predict").listing + firmware("learn").listing
    assert "rcpsp" not in listing
    assert "sploop" not in listing
    assert "mpysp" in listing


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        (b"", "not a little-endian 32-bit ELF"),
        (b"\x7fELF\x02\x01" + bytes(60), "not a little-endian 32-bit ELF"),
        (b"\x7fELF\x01\x01" + bytes(12) + b"\x03\x00" + bytes(60), "is not the C6000"),
    ],
    ids=["empty", "64 bits", "another processor"],
)
def test_what_is_not_a_target_program_is_refused(data: bytes, complaint: str) -> None:
    with pytest.raises(TargetError, match=complaint):
        elf.read(data)


def test_missing_packages_are_named_with_the_command_that_gets_them(tmp_path: Path) -> None:
    run = build(str(tmp_path / "new"), BINUTILS_TARBALL="/nowhere/binutils.tar.xz", GCC_TARBALL="/nowhere/gcc.tar.xz")
    assert run.returncode == 1
    assert "apt-get install -y --no-install-recommends binutils-source gcc-12-source" in run.stderr
    assert list(tmp_path.iterdir()) == []


def test_another_archive_than_the_measured_one_is_refused(tmp_path: Path) -> None:
    archive = tmp_path / "binutils.tar.xz"
    archive.write_bytes(b"something else")
    run = build(str(tmp_path / "new"), BINUTILS_TARBALL=str(archive))
    if "missing" in run.stderr:
        missing("sources of the C674x compiler")
    assert run.returncode == 1
    assert "not the archive that this recipe was measured with" in run.stderr
    assert not (tmp_path / "new").exists()


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    run = build(str(tmp_path))
    assert run.returncode == 1
    assert "not empty and not made by this script" in run.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_a_second_call_returns_at_once(tmp_path: Path) -> None:
    # The stamp alone decides: it is the digest of the recipe.
    stamp = tmp_path / "share" / "hysgen" / "recipe.sha256"
    stamp.parent.mkdir(parents=True)
    digest = subprocess.run(["sha256sum", str(SCRIPT)], capture_output=True, text=True, check=True).stdout.split()[0]
    stamp.write_text(f"{digest}\n")
    run = build(str(tmp_path))
    assert run.returncode == 0
    assert "is up to date" in run.stdout
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == [stamp.name], "nothing was built"


def test_an_interrupted_build_leaves_nothing(tmp_path: Path) -> None:
    target = tmp_path / "new"
    process = subprocess.Popen(
        ["bash", str(SCRIPT), str(target)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, bufsize=1
    )
    assert process.stdout is not None
    for line in process.stdout:
        if "missing" in line:
            process.wait()
            missing("sources of the C674x compiler")
        if "unpacking" in line:
            break
    assert any(path.name.startswith("new.building") for path in tmp_path.iterdir())
    process.terminate()
    process.communicate(timeout=600)
    assert process.returncode == 130
    assert list(tmp_path.iterdir()) == []
