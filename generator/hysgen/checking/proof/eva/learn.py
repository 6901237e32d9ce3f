"""What Eva is given for one call of learn: any 32 bits as inputs, from any state of the learner's box.

In two parts. First what an update does to the shadow, from any bits at all: which words it writes, and that the shadow
starts again unless every parameter is finite and inside its limit. Then the whole call with that as contracts.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from hysgen.checking.proof.eva.banks import bank_box
from hysgen.checking.proof.eva.boxes import KEPT
from hysgen.checking.proof.eva.calls import ENTRY, FINITE_CHECKED
from hysgen.checking.proof.eva.contracts import (
    LOOKED_AT,
    WRITES,
    beyond_contract,
    parameters,
    update_cases,
    update_contracts,
    update_functions,
    within,
)
from hysgen.checking.proof.eva.frama import Verdict, analyse
from hysgen.checking.proof.eva.intervals import hexadecimal
from hysgen.checking.proof.eva.learner_box import WILD, LearnerBox, learner_box
from hysgen.checking.proof.eva.splits import Join, Split, case_lines, displacements, signs, splits
from hysgen.checking.proof.eva.states import ANY_WORD, assumed, bank_words, float_word, instance_words
from hysgen.checking.proof.hooked import hooked
from hysgen.codegen.interface import interface_of
from hysgen.codegen.render import render
from hysgen.float32.coefficients import coefficients
from hysgen.model.disturbances import channels_of
from hysgen.model.model import Model


def learn_step(model: Model, texts: Mapping[str, str], function: str) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call of learn_init, learn_aux or learn, and the number of its checks.

    Inputs are any 32 bits; learn_init has none, but a model in any state and with any bank that may be committed.
    """
    name, box = model.name, learner_box(model)
    struct = interface_of(name, texts).struct(f"{name}_learner_t")
    found = [
        word
        for word in struct.words()
        if word.path.split("[")[0] not in WILD and not word.path.startswith(("candidate.", "base."))
    ]
    known = assumed("learner", struct.name, found, box.floats, box.integers)
    # The bank that the learner started from: any that may have been committed before learn_init.
    if any(word.path.startswith("base.") for word in struct.words()):
        known += [float_word("learner", f"base.{path}", bank) for path, bank in bank_box(model).items()]
    facts = {
        "name": name,
        "function": function,
        "model_words": [*bank_words(model), *instance_words(model, texts)],
        "words": known,
        "channels": len(channels_of(model.terms)),
        "wild": [member.name for member in struct.members if member.name in WILD and member.sizes],
        "scalars": ["per_alpha"],
        "any": f"{name}_float({ANY_WORD})",
    }
    lines = case_lines([*splits(model, KEPT), *_learn_splits(model)], _joins(model, box))
    source = hooked(model, texts, {**lines, **FINITE_CHECKED, **update_contracts(model, texts)})
    checks = sum(word.demanded != "" for word in known)
    return {**texts, f"{name}.c": source, ENTRY: render("proof/learn.c.j2", facts)}, checks


def prove_learn(model: Model, texts: Mapping[str, str], function: str) -> tuple[Verdict, int]:
    """Eva's verdict on a call of learn_init, learn_aux or learn, and the number of checks of a complete analysis."""
    sources, checks = learn_step(model, texts, function)
    name = model.name
    trusted = [f"{name}_{function}" for function in update_functions(model, texts)]
    apart = ",".join(f"{name}_{answers}" for answers in ("update_diagonal:0:2", "update:0", "evaluate_reading:0"))
    options = ("-eva-use-spec", ",".join(trusted), "-eva-split-return-function", apart)
    return analyse(sources, ENTRY, "finite" if function == "learn_init" else "any", options=options), checks


def update_step(model: Model, texts: Mapping[str, str]) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for what one update does to the shadow, and the number of its checks."""
    name = model.name
    functions = update_functions(model, texts)
    source = hooked(model, texts, beyond_contract(name) | update_cases(model))
    kept = [within(name, f"learner.theta[{j}]") for j in range(parameters(name, texts))]
    facts = {
        "name": name,
        "looked_at": LOOKED_AT,
        "functions": [f"{name}_{function}" for function in functions if function != "step"],
        "kept": kept,
    }
    return {**texts, f"{name}.c": source, ENTRY: render("proof/update.c.j2", facts)}, 2 * len(kept)


def prove_update(model: Model, texts: Mapping[str, str]) -> tuple[Verdict, int]:
    """Eva's verdict on an update, and the number of checks that a complete analysis reaches.

    A write of a function to a word of the learner that its contract does not list counts as an alarm.
    """
    name = model.name
    sources, checks = update_step(model, texts)
    options = ("-eva-use-spec", f"{name}_beyond", "-eva-split-return", "full", "-out-external")
    verdict = analyse(sources, ENTRY, "any", options=options)
    alarms = list(verdict.alarms)
    for function in update_functions(model, texts):
        more = sorted(verdict.fields(f"{name}_{function}", "learner") - set(WRITES[function]))
        alarms += [f"{name}_{function}: writes {', '.join(more)}: not in its contract"] if more else []
    return dataclasses.replace(verdict, alarms=tuple(alarms)), checks


def _learn_splits(model: Model) -> list[Split]:
    return [
        Split("learn: y", _plausible(model)),
        Split("store_regressors: y", displacements(coefficients(model))),
        Split("restart_needed", signs("moved")),
        Split("begin: sliding", ("sliding == 0u",)),
        Split("admit: e", signs("e")),
        Split("limited", ("x <= high",)),
    ]


def _joins(model: Model, box: LearnerBox) -> list[Join]:
    """Places where cases are merged; the cases of the mean input and of `usable` stay separate to the end."""
    levels = {level.path: level for level in box.levels}
    low, high = (hexadecimal(end) for end in (model.u_min_V, model.u_max_V))
    return [
        Join("learn: away", kept=(f"self->mean_u_V < {low}", f"self->mean_u_V <= {high}", "usable")),
        Join("learn: update"),
        Join("learn: fresh"),
        *(
            Join(f"restart_needed: {path}", levels[path].borders)
            for path in ("moving_um", "error", "reference_error", "step_error")
        ),
        Join("restart_needed: return"),
        Join("admit: scale", levels["scale_um"].borders),
        Join("admit: run"),
        Join("store_regressors: x"),
    ]


def _plausible(model: Model) -> tuple[str, ...]:
    upper = model.name.upper()
    return (f"y < {upper}_LEARN_Y_LOW_UM", f"y <= {upper}_LEARN_Y_HIGH_UM")
