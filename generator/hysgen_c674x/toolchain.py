"""The C compiler for the target, gcc for the C6000 built by firmware/toolchain/build_c674x.sh, and its output."""

import functools
import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from hysgen.checking.proof.static import BASIC
from hysgen.errors import BuildError
from hysgen.machine.native import cached_object, compiler_version
from hysgen_c674x import elf
from hysgen_c674x.assembly import instructions
from hysgen_c674x.elf import ProgramImage
from hysgen_c674x.machine import Machine
from hysgen_c674x.packets import Packet, packets

# -ffp-contract=off, -fno-reciprocal-math: keep the bits. -msdata=none: no pointer register to set up.
# -fno-modulo-sched: no hardware loops, which the simulator does not model and which save no cycles here.
# -fno-jump-tables: the only jumps through a register are returns, so cycles can be bounded statically.
# -fno-tree-loop-distribute-patterns: no calls of the library's copy routine, a hardware loop whose counter interrupt
# service routines do not save. -fsched-pressure, -fno-tree-forwprop: fewest cycles for the generated code.
# -fdbg-cnt=sched_breakdep:0: the scheduler does not move loads across changes of their base register; gcc 12 sometimes
# corrects the offset twice when it does, and the code is wrong.
# -fno-ipa-modref: gcc 12.2 keeps a struct member in a register across a call that changes it (SipHash is wrong).
FLAGS = (
    "-std=c99",
    "-O2",
    "-fsched-pressure",
    "-fno-tree-forwprop",
    "-march=c674x",
    "-ffreestanding",
    "-ffp-contract=off",
    "-fno-reciprocal-math",
    "-fno-modulo-sched",
    "-fno-jump-tables",
    "-fno-tree-loop-distribute-patterns",
    "-fdbg-cnt=sched_breakdep:0",
    "-fno-ipa-modref",
    "-msdata=none",
)

_PREFIX = "tic6x-elf-"


@dataclass(frozen=True)
class Firmware:
    """A linked program. listing: disassembly. section_bytes: sizes of .text, .rodata, .data and .bss, 0 if absent."""

    elf: bytes
    image: ProgramImage
    listing: str
    section_bytes: Mapping[str, int]

    def machine(self, interpreted: bool = False) -> Machine:
        """A simulated C674x with this program in its memory."""
        return Machine(self.image, self.packets, interpreted)

    @functools.cached_property
    def packets(self) -> Mapping[int, Packet]:
        """The execute packets of the listing by address."""
        return packets(instructions(self.listing))

    def function_bytes(self, name: str) -> int:
        """Code bytes of one function, without its callees."""
        return self.image.symbol(name).size


def folder() -> Path:
    """Folder of the toolchain: HYSGEN_C674X if set, else the build script's cache folder.

    Raises BuildError with the script's name if there is no compiler.
    """
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    chosen = Path(os.environ.get("HYSGEN_C674X") or Path(base) / "hysgen" / "c674x")
    if not (chosen / "bin" / f"{_PREFIX}gcc").exists():
        raise BuildError(
            f"{chosen}: no C674x compiler there; run firmware/toolchain/build_c674x.sh (five minutes, once), "
            "or point HYSGEN_C674X at one"
        )
    return chosen


def version() -> str:
    """First line of the compiler's own `--version`."""
    return compiler_version(str(folder() / "bin" / f"{_PREFIX}gcc"))


def compile(sources: Sequence[tuple[str, str]], flags: Sequence[str] = (), script: str | None = None) -> Firmware:
    """Compile and link C texts for the target.

    sources: (file name, text) pairs; headers among them are found by #include, `.c` and `.s` files are compiled.
    flags: added after FLAGS. script: text of the linker script; None: l2ram.ld, a program alone in L2 RAM. The linker
    keeps functions that are never called.
    Raises BuildError with the compiler's first error message.
    """
    texts = dict(sources)
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        for name, text in texts.items():
            (here / name).write_text(text, encoding="utf-8", newline="\n")
        default_script = resources.files(__package__) / "l2ram.ld"
        (here / "link.ld").write_text(script or default_script.read_text(encoding="utf-8"), encoding="utf-8")
        units = [name for name in texts if name.endswith((".c", ".s"))]
        chosen = [*FLAGS, *BASIC, *flags]

        def compiled(unit: str) -> str:
            return str(cached_object(unit, texts, [version(), *chosen], lambda path: compile_to(unit, path)))

        def compile_to(unit: str, path: Path) -> None:
            _run("gcc", [*chosen, "-c", unit, "-o", str(path)], here)

        objects = [compiled(unit) for unit in units]
        _run("gcc", [*chosen, "-nostdlib", "-T", "link.ld", *objects, "-lgcc", "-o", "a.out"], here)
        # -z: long runs of `nop 1` are encoded as zeros, which objdump would skip.
        listing = _run("objdump", ["-dz", "a.out"], here)
        data = (here / "a.out").read_bytes()
    image = elf.read(data)
    sizes = {section.name: section.size for section in image.sections}
    wanted = (".text", ".rodata", ".data", ".bss")
    return Firmware(data, image, listing, {name: sizes.get(name, 0) for name in wanted})


def _run(tool: str, arguments: Sequence[str], where: Path) -> str:
    command = str(folder() / "bin" / f"{_PREFIX}{tool}")
    environment = {**os.environ, "LC_ALL": "C"}
    run = subprocess.run([command, *arguments], cwd=where, capture_output=True, text=True, check=False, env=environment)
    if run.returncode != 0:
        lines = run.stderr.splitlines()
        message = next((line for line in lines if "error" in line or "undefined" in line), run.stderr.strip()[:200])
        raise BuildError(f"{_PREFIX}{tool}: {message}")
    return run.stdout
