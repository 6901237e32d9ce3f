"""Warnings, MISRA rules, sanitizers: the generated C is clean, and each tool sees the faults that are put into it."""

import dataclasses
import json
from collections import Counter
from collections.abc import Mapping

import pytest

from fixtures.proof_models import SHIPPED, model, shipped, texts
from fixtures.tools import need
from hysgen.checking.bits import Report
from hysgen.checking.bits.learning_run import LearningResult
from hysgen.checking.proof import sanitize
from hysgen.checking.proof.emulated import EmulatedReport
from hysgen.checking.proof.static import ADVISORY, COMPILERS, DEVIATIONS, misra, wall
from hysgen.codegen import generate
from hysgen.errors import BuildError
from hysgen.model.learner_settings import LearnerSettings

by_compiler = pytest.mark.parametrize("compiler", COMPILERS)


def planted(anchor: str, replacement: str) -> Mapping[str, str]:
    """The C of Appendix A with one place of its algorithm replaced."""
    source = texts("appendix_a")["appendix_a.c"]
    assert anchor in source
    return {**texts("appendix_a"), "appendix_a.c": source.replace(anchor, replacement, 1)}


def learners() -> Mapping[str, LearnerSettings]:
    """Kinds of learner whose C has another shape than the one in `small_everything`."""
    return {"bias": LearnerSettings(learned=("bias",)), "windowed": LearnerSettings(points_per_call=4, forgetting=1.0)}


@pytest.mark.parametrize("name", ["appendix_a", "extended", "diagnosed", "small_everything", "smooth_50"])
@by_compiler
@pytest.mark.slow
def test_no_compiler_warns_of_generated_c(name: str, compiler: str) -> None:
    need(compiler)
    found = wall(name, texts(name), compilers=[compiler])
    assert found.clean, "\n".join(found.lines())
    assert len(found.files) == 2  # algorithm and self-test


@pytest.mark.parametrize("kind", learners())
@by_compiler
@pytest.mark.slow
def test_no_compiler_warns_of_any_learner(kind: str, compiler: str) -> None:
    need(compiler)
    learner = dataclasses.replace(model("small"), name=kind, learner=learners()[kind])
    found = wall(kind, generate(learner), compilers=[compiler])
    assert found.clean, "\n".join(found.lines())


@pytest.mark.parametrize(
    ("fault", "anchor", "replacement"),
    [
        ("unused", "const float r2 = r * r;", "const float r2 = r * r;\n    const float spare = r2;"),
        ("conversion", "const float r2 = r * r;", "const float r2 = r * (r + 1e-9);"),
        ("sign", "const uint32_t infinite =", "const int32_t infinite ="),
        (
            "shadow",
            "const float r2 = r * r;",
            "const float r2 = r * r;\n    {\n        const float r = r2;\n        (void)r;\n    }",
        ),
    ],
)
@by_compiler
def test_every_compiler_sees_a_planted_fault(compiler: str, fault: str, anchor: str, replacement: str) -> None:
    need(compiler)
    found = wall("appendix_a", planted(anchor, replacement), compilers=[compiler])
    assert any(fault in line for walled in found.files for line in walled.complaints), "\n".join(found.lines())


@pytest.mark.slow
def test_required_misra_rules_are_followed_and_every_deviation_is_advisory_and_met() -> None:
    need("cppcheck")
    found = [misra(name, texts(name)) for name in ("learning", "small_everything", "smooth_50")]
    for report in found:
        assert report.clean, "\n".join(report.lines())
        assert report.required == 0
    assert {deviation.rule for deviation in DEVIATIONS} == set().union(*(report.deviating for report in found))
    assert {deviation.rule for deviation in DEVIATIONS} <= ADVISORY


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.proof
def test_no_rule_of_misra_is_broken_in_a_model_that_ships(name: str) -> None:
    need("cppcheck")
    report = misra(name, shipped(name).texts)
    assert report.clean, "\n".join(report.lines())
    assert report.required == 0


@pytest.mark.slow
def test_misra_sees_planted_faults() -> None:
    need("cppcheck")
    faults = {
        "10.4": ("APPENDIX_A_BANK_RULES; ++l", "6; ++l"),
        "14.4": ("    self->status = 0u;", "    if (self->u_clamped) {\n        self->status = 0u;\n    }"),
        "15.6": ("    self->active = 0u;", "    if (y_um < 0.0f)\n        self->active = 0u;"),
        "17.7": ("    (void)appendix_a_apply(", "    appendix_a_apply("),
        "21.6": ('#include "appendix_a.h"', '#include "appendix_a.h"\n#include <stdio.h>'),
    }
    source = texts("appendix_a")["appendix_a.c"]
    for anchor, replacement in faults.values():
        assert anchor in source
        source = source.replace(anchor, replacement, 1)
    found = misra("appendix_a", {**texts("appendix_a"), "appendix_a.c": source})
    assert set(faults) <= {finding.rule for finding in found.findings}, "\n".join(found.lines())
    assert found.required > 0


@pytest.mark.slow
def test_sanitizers_find_nothing_in_what_runs() -> None:
    """Every term, block and the learner; few samples, for `hysgen prove DIR --only sanitize` runs 1e5 of each call."""
    need("gcc")
    assert sanitize(model("small_everything"), texts("small_everything"), samples=200).equal


@pytest.mark.parametrize(
    ("anchor", "replacement"),
    [
        (
            "    return appendix_a_float(appendix_a_bits(mantissa)",
            "    const int32_t far = (int32_t)appendix_a_bits(shifted) + 2000000000;\n    if (far == 7) { return x; }\n"
            "    return appendix_a_float(appendix_a_bits(mantissa)",
        ),
        ("&self->bank[self->active];", "&self->bank[self->active + 2u];"),
    ],
    ids=["signed overflow", "index out of bounds"],
)
@pytest.mark.slow
def test_sanitizers_stop_at_a_planted_fault(anchor: str, replacement: str) -> None:
    need("gcc")
    with pytest.raises(BuildError, match="sanitizers: the program ended"):
        sanitize(model("appendix_a"), planted(anchor, replacement), samples=100)


def test_answers_of_commit_are_told_by_name() -> None:
    comparison = Report("m", builds=(), skipped=(), altered=(), runs=(), mismatches=(), seconds=0.0)
    report = EmulatedReport(comparison, (LearningResult("sanitizers", answers=Counter(COMMITTED=2)),))
    assert json.loads(json.dumps(report.to_json()))["followed"][0]["answers"] == {"COMMITTED": 2}
