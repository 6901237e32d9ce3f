"""Scheduled kernels: the bits of the C and of the mirror, at every interrupt; an inspection that finds every fault."""

import dataclasses
import re
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.c674x_kernels import FAULTS, FRAMED, assembled, framed_kernel
from fixtures.generated_models import smooth
from fixtures.proof_models import model, texts
from hysgen.checking.symbolic.dataflow import Kernel
from hysgen.checking.symbolic.equivalence import SAMPLES, Sweep
from hysgen.checking.symbolic.from_c import kernel
from hysgen.checking.symbolic.source import KernelRefusalError, Source
from hysgen.codegen import Options, generate
from hysgen.errors import BuildError, TargetError
from hysgen.firmware import with_learner
from hysgen.model.learner_settings import LearnerSettings
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import bounds, c_texts
from hysgen_c674x.schedule import plans
from hysgen_c674x.schedule.checker import function_packets, inspect
from hysgen_c674x.schedule.folder import Kernels, file_text, kernels, with_kernels
from hysgen_c674x.schedule.instructions import TooLongError
from hysgen_c674x.schedule.scheduler import planned, unlimited
from hysgen_c674x.schedule.selection import select

SEVERAL_POINTERS = """
static uint32_t appendix_a_two(const appendix_a_t *self, float *a, float *b)
{
    *a = self->u_V;
    *b = *a + *a;
    return 1u;
}
float appendix_a_caller(const appendix_a_t *self)
{
    float a;
    float b;
    (void)appendix_a_two(self, &a, &b);
    return a + b;
}
"""
ENDLESS = """
float appendix_a_sum(float x)
{
    float s = 0.0f;
    for (uint32_t i = 0u; s < x; ++i) {
        s = s + 1.0f;
    }
    return s;
}
"""
DECIDED = """
float appendix_a_decided(float x, float y, uint32_t rested)
{
    float kept = x;
    float found = 0.0f;
    uint32_t begun = 0u;
    if (rested == 0u) {
        if (y < 1.0f) {
            kept = x * 2.0f;
            begun = 1u;
        }
    }
    if (begun != 0u) {
        found = kept * 3.0f;
    }
    return found + kept;
}
"""
LARGEST = """
uint32_t appendix_a_largest(uint32_t a, uint32_t b, uint32_t c, uint32_t d, uint32_t e)
{
    const uint32_t values[5] = {a, b, c, d, e};
    uint32_t largest = 0u;
    for (uint32_t j = 0u; j < 5u; ++j) {
        largest = (values[j] > largest) ? values[j] : largest;
    }
    return largest;
}
"""
DOCS = Path(__file__).parents[2] / "docs" / "scheduled.md"


def computed(kernel: Kernel, arguments: Sequence[int]) -> int:
    """The result of a kernel that reads no memory."""
    sweep = Sweep(lambda op: np.full(SAMPLES, arguments[op.number], np.uint32))
    assert kernel.result is not None
    return int(sweep.values(sweep.representative(kernel.result))[0])


def test_what_depends_on_data_is_refused() -> None:
    source = dict(texts("appendix_a"))
    source["appendix_a.c"] += ENDLESS
    with pytest.raises(KernelRefusalError, match="length of a loop depends on data"):
        kernel(Source("appendix_a", source), "appendix_a_sum")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("&a, &b", "&a, &a"),
        ("&a, &b", "(float *)&self->u_V, &b"),
        ("const appendix_a_t *self, float *a, float *b", "float *self_, float *a, float *b"),
        ("static uint32_t", "uint32_t"),
    ],
)
def test_pointers_that_may_overlap_are_refused(old: str, new: str) -> None:
    source = dict(texts("appendix_a"))
    separate = source["appendix_a.c"] + SEVERAL_POINTERS
    for text in (separate, separate.replace("(void)appendix_a_two", "const uint32_t done = appendix_a_two")):
        assert kernel(Source("appendix_a", source | {"appendix_a.c": text}), "appendix_a_two").stores
    changed = SEVERAL_POINTERS.replace(old, new)
    if "self_" in new:
        changed = changed.replace("self->u_V", "*self_").replace("const appendix_a_t *self", "float *self, float *a_")
        changed = changed.replace("(self, &a, &b)", "(self, a_, &b)")
    source["appendix_a.c"] += changed
    with pytest.raises(KernelRefusalError, match="two pointers"):
        kernel(Source("appendix_a", source), "appendix_a_two")


def test_a_value_does_not_wait_for_a_condition_under_which_it_is_used() -> None:
    source = dict(texts("appendix_a"))
    source["appendix_a.c"] += DECIDED
    dataflow = kernel(Source("appendix_a", source), "appendix_a_decided")
    products = [op for op in dataflow.operations() if op.kind == "mpysp"]
    assert len(products) == 2
    assert products[0] in products[1].args
    for y, rested, expected in ((0.5, 0, 16.0), (0.5, 7, 2.0), (1.5, 0, 2.0), (1.5, 1, 2.0)):
        x_bits, y_bits, bits = (int(each) for each in np.array([2.0, y, expected], np.float32).view(np.uint32))
        assert computed(dataflow, [x_bits, y_bits, rested]) == bits


def test_a_side_that_a_constant_decides_is_executed_once_and_may_return() -> None:
    source = dict(texts("appendix_a"))
    source["appendix_a.c"] += """
float appendix_a_unrolled(float x)
{
    float s = x;
    for (uint32_t i = 0u; i < 3u; ++i) {
        if (i == 1u) {
            s = s + 1.0f;
        } else {
            s = s * 2.0f;
        }
    }
    if (s < 100.0f) {
        s = s - 3.0f;
    }
    if (1u != 0u) {
        return s;
    }
    return 0.0f;
}
"""
    dataflow = kernel(Source("appendix_a", source), "appendix_a_unrolled")
    for x, expected in ((5.0, 19.0), (60.0, 242.0)):
        given, bits = (int(each) for each in np.array([x, expected], np.float32).view(np.uint32))
        assert computed(dataflow, [given]) == bits


def test_the_largest_of_many_words_is_found_by_pairs() -> None:
    source = dict(texts("appendix_a"))
    source["appendix_a.c"] += LARGEST
    dataflow = kernel(Source("appendix_a", source), "appendix_a_largest")
    length: dict[int, int] = {}
    for op in dataflow.operations():
        length[id(op)] = (op.kind == "select") + max((length[id(arg)] for arg in op.args), default=0)
    assert max(length.values()) == 3
    for words in ([1, 2, 3, 4, 5], [5, 4, 3, 2, 1], [7, 0xFFFF_FFFF, 7, 0x8000_0000, 0], [0, 0, 0, 0, 0]):
        assert computed(dataflow, words) == max(words)


def test_the_limits_of_the_issue_are_kept() -> None:
    """Six rules: predict at most 140 cycles, inverse 160; scheduled in at most 10 s of processor time."""
    started = time.process_time()
    found = kernels("appendix_a", texts("appendix_a"))
    assert time.process_time() - started < 10.0
    assert not found.refused
    cycles = {function.removeprefix("appendix_a_"): each.cycles for function, each in found.schedules.items()}
    assert cycles["predict"] <= 140, cycles
    assert cycles["inverse"] <= 160, cycles


@pytest.mark.slow
def test_learn_of_18_parameters_takes_at_most_980_cycles() -> None:
    """Some seventy of them are the trial of a commit. The zeros of a restart are stored 64 bits at a time."""
    started = time.process_time()
    found = kernels("learning", generate(model("learning"), Options(aligned=True)), ("learn",))
    assert time.process_time() - started < 10.0
    learn = found.schedules["learning_learn"]
    cycles = learn.cycles  # a report of `learn` itself would have gigabytes
    assert cycles <= 980
    assert sum(each.node.mnemonic == "stdw" for each in learn.placements) >= 153 // 2
    program = assembled(file_text("", found.schedules, found.tables))
    assert inspect(function_packets(program.image, program.packets, "learning_learn"), 3) == []


@pytest.mark.slow
def test_an_inverse_behind_a_fractional_delay_is_a_kernel() -> None:
    """Its result has the register of an argument that most instructions read, and comes last."""
    found = kernels("extended", texts("extended"), ("inverse",))
    assert not found.refused
    assert found.schedules["extended_inverse"].cycles <= 1200
    program = assembled(file_text("", found.schedules, found.tables))
    assert inspect(function_packets(program.image, program.packets, "extended_inverse"), 3) == []


@pytest.mark.proof
def test_an_inverse_too_large_for_the_program_cache_beside_learn_stays_in_c() -> None:
    """With both as kernels the firmware of `extended` missed 402 lines of the cache in every sample, not 183."""
    portable = generate(with_learner(model("extended")), Options(aligned=True))
    found = kernels("extended", portable, ("inverse", "learn"))
    assert set(found.schedules) == {"extended_learn"}
    assert set(found.tables) == set(kernels("extended", portable, ("learn",)).tables)
    assert "program cache" in found.refused["extended_inverse"]


def test_a_schedule_is_shorter_than_the_one_that_is_known() -> None:
    """The end of the stack frame counts, too."""
    selected = select(kernel(Source("appendix_a", texts("appendix_a")), "appendix_a_predict"))
    issue = unlimited(selected)
    cycles = planned(selected, plans.FRAMED[0], issue).cycles
    with pytest.raises(TooLongError):
        planned(selected, plans.FRAMED[0], issue, cycles)
    assert planned(selected, plans.FRAMED[0], issue, cycles + 1).cycles == cycles


def test_the_inspection_finds_no_fault_in_a_kernel() -> None:
    program = assembled(framed_kernel())
    assert inspect(function_packets(program.image, program.packets, FRAMED), 3) == []
    cycles = bounds(program.image, program.packets, FRAMED)
    assert cycles.constant


@pytest.mark.slow
def test_the_self_test_leaves_out_the_padding_of_an_aligned_learner() -> None:
    """With two rules the learner has an odd number of words, and padding where it is aligned to 8 bytes."""
    need_compiler()
    model = dataclasses.replace(smooth(2), name="odd", learner=LearnerSettings())
    odd = generate(model)
    with pytest.raises(TargetError, match="aligned=True"):
        with_kernels("odd", odd, Kernels({}, {}, {}))
    found = with_kernels("odd", generate(model, Options(aligned=True)), Kernels({}, {}, {}))
    words = re.search(r"#define ODD_LEARNER_WORDS (\d+)u", found["odd.h"])
    assert words is not None
    assert int(words[1]) % 2, words[1]
    machine = toolchain.compile(c_texts(found)).machine()
    assert machine.call("odd_selftest").bits == 0
    padded = dict(found) | {"odd_selftest.c": odd["odd_selftest.c"]}
    assert toolchain.compile(c_texts(padded)).machine().call("odd_selftest").bits > 0


@pytest.mark.parametrize("fault", FAULTS)
def test_the_inspection_finds_the_planted_fault(fault: str) -> None:
    rule, change = FAULTS[fault]
    changed = change(framed_kernel())
    assert changed != framed_kernel()
    if rule == "assembler":
        with pytest.raises(BuildError, match="already used in this execute packet"):
            assembled(changed)
        return
    program = assembled(changed)
    found = inspect(function_packets(program.image, program.packets, FRAMED), 3)
    assert rule in {each.rule for each in found}, [str(each) for each in found]


def test_the_table_of_planted_faults_stands_in_the_docs() -> None:
    rows = re.findall(r"^\| (.+?) \| `(.+?)` \|$", DOCS.read_text(encoding="utf-8"), re.MULTILINE)
    assert [(fault, rule) for fault, rule in rows] == [(fault, rule) for fault, (rule, _) in FAULTS.items()]
