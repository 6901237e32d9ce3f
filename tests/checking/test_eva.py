"""Frama-C Eva: the generated C never fails and never leaves its box, and without any of its guards that is not proved.

Here for models of two rules, without and with every term and block, and with some of the guards taken out; `make prove`
takes out all of them and proves every call of the models that ship.
"""

import dataclasses
import functools
import re
from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from fixtures.generated_models import relaxing
from fixtures.guards import Guard, guards, without
from fixtures.proof_models import SHIPPED, model, shipped, texts
from fixtures.term_models import RESPONSES, model_with
from fixtures.tools import need
from hysgen.checking import Host
from hysgen.checking.proof.eva import calls, prove, proved
from hysgen.checking.proof.eva.calls import prove_call, prove_commit, prove_update, step
from hysgen.checking.proof.eva.frama import Floats, analyse, check_contract, hook_names, hooked
from hysgen.checking.proof.eva.states import case_lines, splits
from hysgen.codegen import Options, generate
from hysgen.errors import BuildError, ModelError
from hysgen.machine.native import Toolchain
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path import InputBlock


@functools.cache
def gains() -> tuple[Model, Mapping[str, str]]:
    """Two rules with a learner of their gains only."""
    learner = dataclasses.replace(model("small"), learner=LearnerSettings(learned=("gain",)))
    return learner, generate(learner, Options(clock_Hz=2e9))


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.proof
def test_every_call_of_a_model_that_ships_is_proved(name: str) -> None:
    """The folders of firmware/models to the byte, each with its learner: a good minute of one core each."""
    need("frama-c")
    folder = shipped(name)
    found = prove(folder.model, folder.texts)
    assert found.holds, "\n".join(found.lines())
    assert {p.function for p in found.proofs} >= {"init", "update", "learn_init", "learn", "commit"}
    assert {(p.function, p.inputs) for p in found.proofs} >= {
        (function, inputs) for function in ("predict", "simulate", "inverse") for inputs in ("finite", "any")
    }


@pytest.mark.slow
def test_terms_as_the_diagnosis_delivers_them_are_proved() -> None:
    need("frama-c")
    for function in ("predict", "init"):
        verdict, expected = prove_call(model("small_diagnosed"), texts("small_diagnosed"), function, "finite")
        assert not verdict.alarms
        assert verdict.held == verdict.checks >= expected > 20


@pytest.mark.parametrize(
    ("function", "inputs"),
    [("predict", "finite"), pytest.param("inverse", "any", marks=pytest.mark.proof), ("aux", "any")],
)
@pytest.mark.slow
def test_a_call_with_every_term_and_block_is_proved(function: str, inputs: Floats) -> None:
    need("frama-c")
    verdict, expected = prove_call(model("small_everything"), texts("small_everything"), function, inputs)
    assert not verdict.alarms
    assert verdict.held == verdict.checks >= expected > 20


@pytest.mark.proof
@pytest.mark.parametrize(
    ("block", "function"), [(relaxing(), "inverse"), *((RESPONSES[4], call) for call in ("aux", "simulate", "inverse"))]
)
def test_a_call_behind_plays_that_relax_or_modes_that_soften_is_proved(block: InputBlock, function: str) -> None:
    """Steps of such plays are exponentials; `aux` of such modes needs cases of its channels."""
    need("frama-c")
    verdict, expected = prove_call(behind := model_with((), (block,)), generate(behind), function, "any")
    assert not verdict.alarms
    assert verdict.held == verdict.checks >= expected > 20


FAST = ("voltage", "limits step", "limits low", "free run")
"""Guards that are taken out on every run of the suite, one of each function or more."""


def by_guard() -> list[Any]:
    """The guards of the small model, those that take longer with the proofs."""
    known = guards(model("small"), texts("small"))
    assert known.keys() >= set(FAST)
    return [pytest.param(guard, marks=() if name in FAST else pytest.mark.proof) for name, guard in known.items()]


@pytest.mark.parametrize("guard", by_guard(), ids=lambda guard: guard.name)
@pytest.mark.slow
def test_a_guard_that_is_taken_out_is_missed(guard: Guard) -> None:
    need("frama-c")
    opened = without(guard, model("small"), texts("small"))
    verdict, _ = prove_call(model("small"), opened, guard.function, guard.inputs)
    assert verdict.alarms


@pytest.mark.parametrize("name", ["step", pytest.param("usable", marks=pytest.mark.proof)])
@pytest.mark.slow
def test_learn_without_a_guard_is_not_proved(name: str) -> None:
    need("frama-c")
    learner, generated = gains()
    guard = guards(learner, generated)[name]
    opened = without(guard, learner, generated)
    assert proved(learner, opened, guard.function, guard.inputs)[0].alarms


@pytest.mark.slow
def test_a_part_of_an_update_that_writes_more_than_its_contract_says_is_told() -> None:
    need("frama-c")
    learner, generated = gains()
    source = generated["small.c"]
    altered = source.replace("        self->k[j] = ", "        self->theta[1] = 0.0f;\n        self->k[j] = ", 1)
    assert altered != source
    verdict, _ = prove_update(learner, {**generated, "small.c": altered})
    assert any("factor: writes theta" in alarm for alarm in verdict.alarms), verdict.alarms


@pytest.mark.slow
@pytest.mark.proof
def test_the_inverse_of_a_committed_bank_needs_what_commit_checks() -> None:
    need("frama-c")
    learner, generated = gains()
    sources, _ = step(learner, generated, "inverse", "finite")
    # At one displacement: without the lower border of the gain there are too many cases to wait for.
    sources["step.c"] = re.sub(r"(const float input0 =) .*;", r"\1 2.0f;", sources["step.c"])
    assert not analyse(sources, "step.c", "finite").alarms
    untold = re.sub(r" *//@ admit committed: .*\n", "", sources["small.c"])
    assert untold != sources["small.c"]
    assert analyse({**sources, "small.c": untold}, "step.c", "finite").alarms


@pytest.mark.slow
@pytest.mark.proof
def test_the_contract_of_beyond_holds_for_every_float_and_another_does_not() -> None:
    need("gcc")
    learner, generated = gains()
    assert not check_contract(learner.name, generated).alarms
    open_limit = guards(learner, generated)["beyond"]
    assert check_contract(learner.name, without(open_limit, learner, generated)).alarms


@pytest.mark.slow
def test_commit_is_proved_and_a_check_point_too_many_is_missed() -> None:
    need("frama-c")
    learner = dataclasses.replace(model("small"), learner=LearnerSettings())
    generated = generate(learner, Options(clock_Hz=2e9))
    verdict, expected = prove_commit(learner, generated)
    assert not verdict.alarms
    assert verdict.held == verdict.checks >= expected
    endless = guards(learner, generated)["commit"]
    assert prove_commit(learner, without(endless, learner, generated))[0].alarms


@pytest.mark.parametrize(("name", "alarm"), [("delay read", "index|< 4"), ("path", "y_um")])
@pytest.mark.slow
@pytest.mark.proof
def test_a_block_without_its_guard_is_not_proved(name: str, alarm: str) -> None:
    need("frama-c")
    whole, generated = model("small_everything"), texts("small_everything")
    guard = guards(whole, generated)[name]
    verdict, _ = prove_call(whole, without(guard, whole, generated), guard.function, guard.inputs)
    assert any(re.search(alarm, line) for line in verdict.alarms), verdict.alarms


@pytest.mark.slow
def test_without_a_guard_the_c_compiles_and_is_another() -> None:
    need("gcc")
    models = ("appendix_a", "diagnosed", "everything")
    cases = {kind: name for name in models for kind in guards(model(name), texts(name))}
    for kind, name in cases.items():
        opened = without(guards(model(name), texts(name))[kind], model(name), texts(name))
        assert opened != texts(name)
        Host(name, opened, Toolchain("gcc", ("-O0",)))


def test_cases_leave_the_generated_text_as_it_is() -> None:
    generated = texts("everything")["everything.c"]
    looked_at = hooked(model("everything"), texts("everything"), case_lines(splits(model("everything"))))
    assert looked_at.count("/*@ ghost") > 20
    assert re.sub(r"    /\*@ ghost .* \*/\n", "", looked_at) == generated


def test_the_proof_and_the_templates_name_the_same_hooks(monkeypatch: pytest.MonkeyPatch) -> None:
    learner, generated = model("everything"), texts("everything")
    named: set[str] = set()

    def recorded(model: Model, texts: Mapping[str, str], lines: Mapping[str, Sequence[str]]) -> str:
        named.update(lines)
        return hooked(model, texts, lines)

    for module in (calls, calls, calls):
        monkeypatch.setattr(module, "hooked", recorded)
    calls.step(learner, generated, "inverse", "any")
    calls.learn_step(learner, generated, "learn")
    calls.update_step(learner, generated)
    calls.commit_step(learner, generated)
    assert named == {hook for hook in hook_names(learner, generated) if not hook.startswith("guard: ")}


def test_a_hook_whose_lines_are_gone_is_an_error() -> None:
    altered = texts("appendix_a")["appendix_a.c"]
    for line in ("const uint32_t below = ", "const uint32_t above = "):
        altered = altered.replace(line, line.replace("_t ", "_t the_"))
    lines = case_lines(splits(model("appendix_a")))
    with pytest.raises(ModelError, match="hook `limited: below`"):
        hooked(model("appendix_a"), {**texts("appendix_a"), "appendix_a.c": altered}, lines)


@pytest.mark.slow
def test_what_is_not_c_and_what_never_ends_is_refused() -> None:
    need("frama-c")
    for text in ("int main(void) { return }", "int main(void) { for (;;) { } return 0; }"):
        with pytest.raises(BuildError, match="frama-c"):
            analyse({"step.c": text}, "step.c", "finite")


@pytest.mark.slow
def test_a_narrower_box_is_not_proved() -> None:
    need("frama-c")
    sources, _ = step(model("small"), texts("small"), "predict", "finite")
    demand = re.search(r"check y_um: .*;", sources["step.c"])
    assert demand is not None
    narrow = sources["step.c"].replace(demand[0], r"check y_um: \is_finite(self.y_um) && 0.0 <= self.y_um <= 4.0;")
    verdict = analyse({**sources, "step.c": narrow}, "step.c", "finite")
    assert [alarm for alarm in verdict.alarms if "y_um" in alarm]


def test_a_call_that_is_not_there_is_refused() -> None:
    need("frama-c")
    with pytest.raises(ModelError, match="no call learn to prove"):
        prove(model("appendix_a"), texts("appendix_a"), calls=["learn"])
