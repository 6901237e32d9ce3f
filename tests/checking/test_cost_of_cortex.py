"""The models of Cortex-M: within a quarter of what manual and LLVM say of the instructions that clang makes."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from fixtures.generated_models import everything, smooth
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


@pytest.mark.parametrize("model", [load_model("appendix_a"), smooth(3), smooth(20), everything()], ids=lambda m: m.name)
@pytest.mark.parametrize(("name", "judge"), [("cortex-m4", by_the_manual), ("cortex-m7", by_llvm)])
def test_a_call_takes_what_the_model_says_within_a_quarter(
    name: str, judge: Callable[[str], int], model: Model, tmp_path: Path
) -> None:
    need("clang")
    texts, weights = generate(model, Options(clock_Hz=1e10)), target(name, "weights").weights
    assert weights is not None
    write(texts, tmp_path)
    flags = ["-O2", "-ffp-contract=off", "-ffreestanding", "-std=c99", "-S", "-o", "-"]
    call = ["clang", f"--target={TRIPLE}", f"-mcpu={name}", *flags, f"{model.name}.c"]
    assembly = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    for function in ("predict", "simulate", "inverse"):
        body = assembly.split(f"\n{model.name}_{function}:")[1].split(".fnend")[0]
        guess = estimated(figures(model.name, texts).operations[function], function, weights).value
        assert 0.8 < guess / judge(body) < 1.25, function
