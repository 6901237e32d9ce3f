"""The models of Cortex-M beside what manual and LLVM say of the instructions that clang makes: within a quarter."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from fixtures.generated_models import everything, smooth
from fixtures.learner_bench import sized
from fixtures.tools import need
from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import write
from hysgen.codegen.operations import estimated, figures
from hysgen.model.file import load_model
from hysgen.model.model import Model
from hysgen.targets import target

TRIPLE = "thumbv7em-none-eabihf"
REFUSED = r"\n\t(vmrs|vcmp|bx|vldmia|vpush|vpop|it[te]*)\b[^\n]*"
"""Instructions that llvm-mca has no timing of; a sum stands for each."""


def by_the_manual(body: str) -> int:
    """Cycles on a Cortex-M4F of instructions one after the other, memory without wait states."""
    cycles, before = 0, ""
    for line in re.findall(r"\n\t([a-z][^\n@]*)", body):
        name, _, operands = line.partition("\t")
        name, used = name.split(".")[0], re.findall(r"\b[rs]\d+\b", operands)
        if re.fullmatch(r"v?(ldr|str)[bd]?", name):
            cycles += 2 + name.endswith("d")
        elif re.fullmatch(r"v?(push|pop)|v?(ldm|stm)(ia)?", name):
            cycles += 1 + len(re.findall(r"\b(?:[rds]\d+|lr|pc)\b", operands))
        elif re.fullmatch(r"b|bl|bx|cbn?z|b(eq|ne|lo|hs|hi|ls|lt|gt|le|ge|mi|pl)", name):
            cycles += 3
        else:
            cycles += not re.fullmatch(r"it[te]*", name)
        cycles += name.startswith("v") and before in used[1:]
        before = used[0] if used and name in ("vadd", "vsub", "vmul") else ""
    return cycles


def by_llvm(body: str) -> int:
    need("llvm-mca")
    call = ["llvm-mca", f"--mtriple={TRIPLE}", "-mcpu=cortex-m7", "-iterations=1"]
    given = re.sub(REFUSED, r"\n\tadd\tr0, r0, #1", body)
    run = subprocess.run(call, input=given, capture_output=True, text=True, check=True)
    return int(re.findall(r"Total Cycles:\s+(\d+)", run.stdout)[0])


UNROLLED = [f"-unroll-{name}=1000000" for name in ("threshold", "full-max-count", "max-upperbound")]
CALLS = ("predict", "simulate", "inverse")
LEAST, MOST = 0.8, 1.25
"""Least and largest ratio of the estimate."""

MAIN = """#include "NAME.h"
static NAME_t self;
static NAME_learner_t learner;
void _start(void) {
    NAME_init(&self, 2.0f, 30.0f);
    NAME_learn_init(&learner, &self);
    for (unsigned k = 0u, drawn = 1u; k < 60u; ++k, drawn = drawn * 1664525u + 1013904223u)
        NAME_learn(&learner, 2.0f + 1e-10f * (float)(drawn >> 3), 1e-8f * (float)drawn);
    __asm volatile("mov r0, #0\\n mov r7, #1\\n svc #0");
}
"""


def compiled(model: Model, name: str, folder: Path, *options: str) -> None:
    need("clang")
    flags = ["-O2", "-ffp-contract=off", "-ffreestanding", "-std=c99"]
    call = ["clang", f"--target={TRIPLE}", f"-mcpu={name}", *flags, *options]
    subprocess.run(call, cwd=folder, capture_output=True, text=True, check=True)


def executed(model: Model, name: str, folder: Path) -> str:
    """What the longest of 60 calls of learn executes, line by line; a branch that is taken is a bx, another a nop."""
    need("arm-none-eabi-gcc", "qemu-arm-static", "llvm-mca")
    (folder / "main.c").write_text(MAIN.replace("NAME", model.name), encoding="utf-8")
    compiled(model, name, folder, "-c", f"{model.name}.c", "main.c")
    board = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-nostdlib"]
    link = ["arm-none-eabi-gcc", *board, f"{model.name}.o", "main.o", "-lgcc", "-o", "program"]
    emulator = ["qemu-arm-static", "-cpu", "max", "-singlestep", "-d", "nochain,exec", "-D", "log", "./program"]
    listing = ["llvm-objdump", "-d", "--no-show-raw-insn", f"--triple={TRIPLE}", f"--mcpu={name}", "program"]
    for call in (link, emulator, listing):
        run = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=True)
    text, inside, caller = {}, "", {}
    for line in run.stdout.splitlines():
        inside = line if line.endswith(">:") else inside
        if found := re.match(r" *([0-9a-f]+):\s+(\S+)\s*([^@<]*)", line):
            text[int(found[1], 16)] = f"\n\t{found[2]}\t{found[3].strip()}"
            caller[int(found[1], 16)] = "<_start>" in inside
    places = [int(at, 16) for at in re.findall(r"\[[0-9a-f]+/([0-9a-f]+)/", (folder / "log").read_text())]
    calls: list[list[int]] = [[]]
    for at in places:
        calls += [[]] if caller[at] else []
        calls[-1] += [] if caller[at] else [at]
    learn = int(re.findall(rf"([0-9a-f]+) <{model.name}_learn>:", run.stdout)[0], 16)
    longest = max((call for call in calls if call[:1] == [learn]), key=len)
    lines = []
    for at, after in zip(longest, [*longest[1:], 0], strict=True):
        branch = re.match(r"\n\t(b|bl|bx|cbn?z|b(eq|ne|lo|hs|hi|ls|lt|gt|le|ge|mi|pl))(\.[nw])?\t", text[at])
        lines.append(text[at] if not branch else "\n\tnop\t" if after - at in (2, 4) else "\n\tbx\tlr")
    return "".join(lines)


MODELS = [load_model("appendix_a"), smooth(3), smooth(20), everything(), sized(6), sized(18)]


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
@pytest.mark.parametrize(("name", "judge"), [("cortex-m4", by_the_manual), ("cortex-m7", by_llvm)])
def test_a_call_takes_what_the_model_says(name: str, judge: Callable[[str], int], model: Model, tmp_path: Path) -> None:
    texts, weights = generate(model, Options(clock_Hz=1e10)), target(name, "weights").weights
    assert weights is not None
    write(texts, tmp_path)
    unrolled = [word for option in ("-inline-threshold=1000000", *UNROLLED) for word in ("-mllvm", option)]
    compiled(model, name, tmp_path, *(unrolled if model.learner else ()), "-S", "-o", "made.s", f"{model.name}.c")
    assembly = (tmp_path / "made.s").read_text(encoding="utf-8")
    functions = ("commit",) if model.learner else CALLS
    bodies = {each: assembly.split(f"\n{model.name}_{each}:")[1].split(".fnend")[0] for each in functions}
    if model.learner:
        bodies["learn"] = executed(model, name, tmp_path)
    for function, body in bodies.items():
        guess = estimated(figures(model.name, texts).operations[function], function, weights).value
        assert LEAST < guess / judge(body) < MOST, (function, guess, judge(body))
