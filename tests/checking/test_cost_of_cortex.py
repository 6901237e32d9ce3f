"""The models of Cortex-M beside what manual and LLVM say of the instructions that clang makes: within a quarter."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from fixtures.generated_models import everything, smooth
from fixtures.learner_bench import sized
from fixtures.tools import need
from hysgen.codegen import Options, generate, write
from hysgen.codegen.operations import figures
from hysgen.codegen.operations.cycles import estimated
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
CALLS = [("predict", 0.8, 1.25), ("simulate", 0.8, 1.25), ("inverse", 0.8, 1.25)]
LEARNING = [("commit", 0.8, 1.25), ("learn", 1.0, 1.75)]
"""Least and largest ratio of the estimate. The estimate of `learn` is that of loops, which are unrolled here."""


MODELS = [load_model("appendix_a"), smooth(3), smooth(20), everything(), sized(6), sized(18)]


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.name)
@pytest.mark.parametrize(("name", "judge"), [("cortex-m4", by_the_manual), ("cortex-m7", by_llvm)])
def test_a_call_takes_what_the_model_says(name: str, judge: Callable[[str], int], model: Model, tmp_path: Path) -> None:
    need("clang")
    texts, weights = generate(model, Options(clock_Hz=1e10)), target(name, "weights").weights
    assert weights is not None
    write(texts, tmp_path)
    flags = ["-O2", "-ffp-contract=off", "-ffreestanding", "-std=c99", "-S", "-o", "-"]
    if model.learner:
        flags += [word for option in ("-inline-threshold=1000000", *UNROLLED) for word in ("-mllvm", option)]
    call = ["clang", f"--target={TRIPLE}", f"-mcpu={name}", *flags, f"{model.name}.c"]
    assembly = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    for function, least, most in LEARNING if model.learner else CALLS:
        body = assembly.split(f"\n{model.name}_{function}:")[1].split(".fnend")[0]
        guess = estimated(figures(model.name, texts).operations[function], function, weights).value
        assert least < guess / judge(body) < most, function
